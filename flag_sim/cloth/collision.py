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
from typing import NamedTuple

from flag_sim.cloth.attachment import bring_back
from flag_sim.cloth.mesh import ONE
from flag_sim.cloth.planes import cell_plane, is_beyond, project, separation
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel, wide_kernel
import numpy as np

FAR = 1e9
"""A separation [m] that nothing covers in a step, given to cells beyond the cloth's edges."""
CAUTION = 1e-3
"""The part of a node's way by which it is looked at too early rather than, by rounding, not."""


class Limits(NamedTuple):
    """What keeps the nodes where they may be; measured as the state's positions."""

    pole: tuple        # x, y and radius [m] of an upright cylinder; no pole if that is zero
    rounding: float    # by how much a node may seem to be in the pole without being in it [m]
    reach: float       # how far from its row's beginning a node may be, a column [m]; or infinite
    cell: np.ndarray   # flat (mesh.size,): 1 where the node is a cell's upper hoist corner, or 0
    free: np.ndarray   # flat (mesh.size,): 1 where the node moves, or 0
    columns: np.uint64
    first: np.uint64   # the number of the mesh's first node

    @classmethod
    def of(cls, mesh, pole, stretch_limit):
        """
        Return the limits of a mesh, in its numbers.

        pole: x, y and radius [m]. It is held to be thicker by some units in the last place of the
        cloth's extent, so that what is rounded is still outside of it.
        """
        x, y, radius = pole
        extent = mesh.length + mesh.width + radius + math.hypot(x, y)
        rounding = 4.0 * float(np.finfo(mesh.precision).eps) * extent
        if radius > 0.0:
            radius += 2.0 * rounding
        reach = (1.0 + stretch_limit) * mesh.dx if mesh.pinned else math.inf
        return cls(mesh.number((x, y, radius)), mesh.number(rounding), mesh.number(reach),
                   mesh.weights.cell, mesh.free, np.uint64(mesh.columns), np.uint64(mesh.first))


class Contact(NamedTuple):
    """Flat fields (mesh.size,) that a step's contact with the pole is worked out in."""

    room: np.ndarray      # how much farther a node could go before the pole matters [m]
    normal_x: np.ndarray  # of the plane of the cell whose upper hoist corner is the node, or zero
    normal_y: np.ndarray
    held: np.ndarray      # 1 where the attachment brought a node back in this frame, or 0

    @classmethod
    def of(cls, mesh):
        """Return the fields of a mesh."""
        return cls(*mesh.fields(4))


@wide_kernel
def _set_room(position, position_out, cell, pole, contact, span):
    """
    Set how much farther each node could have gone before any of its cells met the pole [m].

    Where that is negative, the node has to be looked at more closely. Forgets all planes.
    """
    room, normal_x, normal_y, _ = contact
    center_x, center_y, radius = pole
    x, y, z = position
    x_out, y_out, z_out = position_out
    number = type(radius)
    one, far, more = number(1.0), number(FAR), number(1.0 + CAUTION)
    edge = radius * more
    first, last, stride = span
    for i in range(first, last):
        n, s = i - stride, i + stride
        xnw, xn, xne = x[n - ONE] - center_x, x[n] - center_x, x[n + ONE] - center_x
        xw, xi, xe = x[i - ONE] - center_x, x[i] - center_x, x[i + ONE] - center_x
        xsw, xs, xse = x[s - ONE] - center_x, x[s] - center_x, x[s + ONE] - center_x
        ynw, yn, yne = y[n - ONE] - center_y, y[n] - center_y, y[n + ONE] - center_y
        yw, yi, ye = y[i - ONE] - center_y, y[i] - center_y, y[i + ONE] - center_y
        ysw, ys, yse = y[s - ONE] - center_y, y[s] - center_y, y[s + ONE] - center_y
        nw = separation(xnw, xn, xw, xi, ynw, yn, yw, yi, edge)
        ne = separation(xn, xne, xi, xe, yn, yne, yi, ye, edge)
        sw = separation(xw, xi, xsw, xs, yw, yi, ysw, ys, edge)
        se = separation(xi, xe, xs, xse, yi, ye, ys, yse, edge)
        nearest = min(min(nw + (one - cell[n - ONE]) * far, ne + (one - cell[n]) * far),
                      min(sw + (one - cell[i - ONE]) * far, se + (one - cell[i]) * far))
        dx, dy, dz = x_out[i] - x[i], y_out[i] - y[i], z_out[i] - z[i]
        room[i] = nearest - more * math.sqrt(dx * dx + dy * dy + dz * dz)
        normal_x[i] = normal_y[i] = number(0.0)


@lean_kernel
def _find_far(position_out, limits, room, span):
    """Set room to -inf at nodes that are about as far as the cloth reaches, or farther."""
    x, y, z = position_out
    number = type(limits.reach)
    reach2 = limits.reach * limits.reach * number(1.0 - CAUTION)
    for row in range(*_rows(limits, span)):
        hoist, begin, end = _row(limits, row, span)
        hx, hy, hz = x[hoist], y[hoist], z[hoist]
        beyond = 0
        for i in range(begin, end):
            dx, dy, dz = x[i] - hx, y[i] - hy, z[i] - hz
            column = number(np.int64(i - hoist))
            beyond += dx * dx + dy * dy + dz * dz > reach2 * column * column
        if beyond > 0:
            for i in range(begin, end):
                dx, dy, dz = x[i] - hx, y[i] - hy, z[i] - hz
                column = number(np.int64(i - hoist))
                if dx * dx + dy * dy + dz * dz > reach2 * column * column:
                    room[i] = number(-math.inf)


@lean_inner_kernel
def _rows(limits, span):
    """Return the first and the last row, not included, that nodes of a span are in."""
    first, last, stride = span
    return ((first - limits.first) // stride,
            (max(last, limits.first) - limits.first + stride - ONE) // stride)


@lean_inner_kernel
def _row(limits, row, span):
    """Return a row's hoist node and the first and last node, not included, in it and a span."""
    first, last, stride = span
    hoist = limits.first + row * stride
    return hoist, max(first, hoist), min(last, hoist + limits.columns)


@lean_inner_kernel
def _plane(position, corner, limits, contact, span):
    """
    Return the unit normal of the plane of a corner's cell, which is found once in a step.

    Cells of the band before are not this one's to note, and are found anew.
    """
    first, _, stride = span
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
def _planes_of(position, i, limits, contact, span):
    """Return the planes of the cells around node i; the first also for each that there is not."""
    n, zero = i - span[2], type(limits.rounding)(0.0)
    found = 0
    a = b = c = d = (zero, zero)
    for corner in (n - ONE, n, i - ONE, i):
        if limits.cell[corner] > zero:
            plane = _plane(position, corner, limits, contact, span)
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
def _ahead(position, x, y, i, limits, contact, span):
    """Return how far beyond the last of the planes of the cells around node i a place is [m]."""
    n, number = i - span[2], type(limits.rounding)
    least = number(FAR)
    for corner in (n - ONE, n, i - ONE, i):
        if limits.cell[corner] > number(0.0):
            nx, ny = _plane(position, corner, limits, contact, span)
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
def _hold(position, position_out, velocity, limits, contact, i, hoist, span):
    """Put node i of the row that begins at the node hoist where it may be."""
    x, y, z = position
    x_out, y_out, z_out = position_out
    vx, vy, vz = velocity
    center_x, center_y, radius = limits.pole
    longest = limits.reach * type(radius)(np.int64(i - hoist))
    start = x[hoist], y[hoist], z[hoist]
    old = x[i], y[i], z[i]
    new, v, excess = bring_back((x_out[i], y_out[i], z_out[i]), (vx[i], vy[i], vz[i]), start,
                                longest)
    if excess > limits.rounding:
        contact.held[i] = type(radius)(1.0)
    planes = _planes_of(position, i, limits, contact, span)
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
def _hold_near(position, position_out, velocity, limits, contact, span):
    """Look at all nodes that have no room, and put those that need it where they may be."""
    room, zero = contact.room, type(limits.rounding)(0.0)
    center_x, center_y, _ = limits.pole
    x_out, y_out, _ = position_out
    for row in range(*_rows(limits, span)):
        hoist, begin, end = _row(limits, row, span)
        near = 0
        for i in range(begin, end):
            near += room[i] < zero
        if near > 0:
            for i in range(begin, end):
                if (room[i] < zero and limits.free[i] > zero and
                        (room[i] == -math.inf or
                         _ahead(position, x_out[i] - center_x, y_out[i] - center_y, i, limits,
                                contact, span) < zero)):
                    _hold(position, position_out, velocity, limits, contact, i, hoist, span)


@lean_kernel
def collide(position, position_out, velocity, limits, contact, span):
    """
    Put every node that a step has taken from position to position_out where it may be.

    Changes position_out and velocity, of nodes of span alone; reads position, of all. contact: to
    work in. Where there is no pole, nothing is done.
    """
    if not limits.pole[2] > 0.0:
        return
    _set_room(position, position_out, limits.cell, limits.pole, contact, span)
    if limits.reach < math.inf:
        _find_far(position_out, limits, contact.room, span)
    _hold_near(position, position_out, velocity, limits, contact, span)
