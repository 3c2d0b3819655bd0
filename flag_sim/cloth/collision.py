# Copyright 2026 The flag_sim Authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
The pole and the attachment to the hoist, in every step of a method.

A node's place is projected to where it may be: beyond the tangents of the four cells that meet in
it (see planes), and no farther from the beginning of its row than the cloth reaches. All of that
is convex, and where the node was before the step is in it: so there is always such a place, the
way there is free, and nodes need not be asked in turn. Nothing rubs: of a velocity only what leads
into the pole or out of reach is taken.
"""
import math

from flag_sim.cloth.attachment import bring_back
from flag_sim.cloth.contact import Contact, Limits
from flag_sim.cloth.planes import cell_plane, is_beyond, project
from flag_sim.cloth.proximity import clear_room_out_of_reach, FAR, row_of, rows_of, set_room
from flag_sim.cloth.records import Band, Field, NEXT, Nodes
from flag_sim.cloth.turning import turn_nodes
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel
import numpy as np


@lean_inner_kernel
def _plane(position, corner, limits, contact, band):
    """
    Return the unit normal of the plane of a corner's cell, which is found once in a step.

    Cells of the band before are not this one's to note, and are found anew.
    """
    first, _, stride = band
    zero = type(limits.rounding)(0.0)
    nx = ny = zero
    if corner >= first:
        nx, ny = contact.normal_x[corner], contact.normal_y[corner]
    if nx == zero and ny == zero:
        nx, ny = cell_plane(position, corner, stride, limits.free, limits.pole)
        if corner >= first:
            contact.normal_x[corner], contact.normal_y[corner] = nx, ny
    return nx, ny


@lean_inner_kernel
def _planes_of(position, i, limits, contact, band):
    """Return the planes of the cells around node i; the first also for each that there is not."""
    n, zero = i - band[2], type(limits.rounding)(0.0)
    found = 0
    a = b = c = d = (zero, zero)
    for corner in (n - NEXT, n, i - NEXT, i):
        if limits.cell[corner] > zero:
            plane = _plane(position, corner, limits, contact, band)
            if found == 0:
                a = b = c = d = plane
            elif found == 1:
                b = plane
            elif found == 2:
                c = plane
            else:
                d = plane
            found += 1
    return a, b, c, d


@lean_inner_kernel
def _ahead(position, x, y, i, limits, contact, band):
    """Return how far beyond the last of the planes of the cells around node i a place is [m]."""
    n, number = i - band[2], type(limits.rounding)
    least = number(FAR)
    for corner in (n - NEXT, n, i - NEXT, i):
        if limits.cell[corner] > number(0.0):
            nx, ny = _plane(position, corner, limits, contact, band)
            least = min(least, nx * x + ny * y)
    return least - limits.pole[2]


@lean_kernel
def _beyond(old, new, velocity, planes, radius, rounding):
    """
    Return (x, y) beyond all planes, and (vx, vy) that leads into none of those the node is at.

    old, new: where the node was and would be, from the pole's axis. The nearest place is no
    farther from the old than the new is. A node that was in the pole may have none so near: it is
    then put beyond one plane after the other, and comes out in some steps.
    """
    number = type(radius)
    (ox, oy), (px, py), (vx, vy) = old, new, velocity
    found, x, y = project(px, py, planes, radius, rounding)
    depth = number(0.0)
    for nx, ny in planes:
        depth = max(depth, radius - (nx * ox + ny * oy))
    way = math.sqrt((px - ox)**2 + (py - oy)**2) + number(2.0) * depth + rounding
    touched = planes
    if found and (x - px)**2 + (y - py)**2 <= way * way:
        touched = _touched(x, y, planes, radius + rounding)
    elif depth <= rounding:
        return ox, oy, number(0.0), number(0.0)
    else:
        x, y = px, py
        for nx, ny in planes:
            inside = max(radius - (nx * x + ny * y), number(0.0))
            x, y = x + inside * nx, y + inside * ny
    fast = (abs(vx) + abs(vy)) * number(1e-6)
    _, vx, vy = project(vx, vy, touched, number(0.0), fast)
    return x, y, vx, vy


@lean_inner_kernel
def _touched(x, y, planes, radius):
    """Return four planes that are those of the four that a point is at."""
    a, b, c, d = planes
    last = a
    for nx, ny in planes:
        if nx * x + ny * y <= radius:
            last = nx, ny
    if a[0] * x + a[1] * y > radius:
        a = last
    if b[0] * x + b[1] * y > radius:
        b = last
    if c[0] * x + c[1] * y > radius:
        c = last
    if d[0] * x + d[1] * y > radius:
        d = last
    return a, b, c, d


@lean_inner_kernel
def _constrain_node(position, nodes_out, limits, contact, i, hoist, band):
    """Put node i of the row that begins at the node hoist where it may be."""
    x, y, z = position
    x_out, y_out, z_out = nodes_out.position
    vx, vy, vz = nodes_out.velocity
    center_x, center_y, radius = limits.pole
    longest = limits.reach * type(radius)(np.int64(i - hoist))
    start = x[hoist], y[hoist], z[hoist]
    old = x[i], y[i], z[i]
    new, v, excess = bring_back((x_out[i], y_out[i], z_out[i]), (vx[i], vy[i], vz[i]), start,
                                longest)
    if excess > limits.rounding:
        contact.brought_back[i] = type(radius)(1.0)
    planes = _planes_of(position, i, limits, contact, band)
    if not is_beyond(new[0] - center_x, new[1] - center_y, planes, radius):
        px, py, ux, uy = _beyond((old[0] - center_x, old[1] - center_y),
                                 (new[0] - center_x, new[1] - center_y), (v[0], v[1]),
                                 planes, radius, limits.rounding)
        new = center_x + px, center_y + py, new[2]
        new = _shortened(old, new, start, longest, limits.rounding)
        new, v, _ = bring_back(new, (ux, uy, v[2]), start, longest)
    x_out[i], y_out[i], z_out[i] = new
    vx[i], vy[i], vz[i] = v


@lean_inner_kernel
def _shortened(old, new, start, longest, rounding):
    """Return the last point on the way from old to new that is in reach, if old is; or new."""
    ax, ay, az = old[0] - start[0], old[1] - start[1], old[2] - start[2]
    bx, by, bz = new[0] - start[0], new[1] - start[1], new[2] - start[2]
    room = longest * longest - (ax * ax + ay * ay + az * az)
    zero = type(room)(0.0)
    dx, dy, dz = new[0] - old[0], new[1] - old[1], new[2] - old[2]
    along, way2 = ax * dx + ay * dy + az * dz, dx * dx + dy * dy + dz * dz
    if (bx * bx + by * by + bz * bz <= longest * longest or way2 == zero
            or room < -longest * (rounding + rounding)):
        return new
    part = min((math.sqrt(along * along + way2 * max(room, zero)) - along) / way2, type(room)(1.0))
    return old[0] + part * dx, old[1] + part * dy, old[2] + part * dz


@lean_kernel
def _constrain_near(position, nodes_out, limits, contact, band):
    """Look at all nodes that have no room, and put those that need it where they may be."""
    room, zero = contact.room, type(limits.rounding)(0.0)
    center_x, center_y, _ = limits.pole
    x_out, y_out, _ = nodes_out.position
    for row in range(*rows_of(limits, band)):
        hoist, begin, end = row_of(limits, row, band)
        near = 0
        for i in range(begin, end):
            near += room[i] < zero
        if near > 0:
            for i in range(begin, end):
                if (room[i] < zero and limits.free[i] > zero and
                        (room[i] == -math.inf or
                         _ahead(position, x_out[i] - center_x, y_out[i] - center_y, i, limits,
                                contact, band) < zero)):
                    _constrain_node(position, nodes_out, limits, contact, i, hoist, band)


@lean_kernel
def collide(nodes: Nodes, nodes_out: Nodes, limits: Limits, contact: Contact,
            band: Band) -> None:
    """
    Put every node that a step has taken from nodes to nodes_out where it may be.

    Changes nodes_out, of the nodes of a band alone; reads nodes, of all. contact: to work in.
    First brings them into the frame of a pole that has turned.
    """
    if limits.turn.size > type(limits.rounding)(0.0):
        turn_nodes(nodes, nodes_out, limits.turn, limits.free, band)
    constrain_nodes(nodes.position, nodes_out, limits, contact, band)


@lean_kernel
def constrain_nodes(position: Field, nodes_out: Nodes, limits: Limits, contact: Contact,
                    band: Band) -> None:
    """Bring what a step has moved from positions to nodes_out out of the pole, as collide does."""
    if not limits.pole[2] > 0.0:
        return
    set_room(position, nodes_out.position, limits, contact, band)
    if limits.reach < math.inf:
        clear_room_out_of_reach(nodes_out.position, limits, contact.room, band)
    _constrain_near(position, nodes_out, limits, contact, band)
