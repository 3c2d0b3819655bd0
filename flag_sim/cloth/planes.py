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
Planes that keep the cloth and the pole apart, one for each cell of the grid.

A cell is the hull of its four nodes: its edges, its diagonals and the faces that are drawn are all
in it. Seen from above, the upright pole is a disc, and a cell that is outside of it lies wholly
beyond one of the disc's tangents: the one at right angles to the shortest way from the pole's
axis to the hull. Whatever each of its nodes does beyond that tangent, the cell does not come into
the pole, at no moment of a straight way.
"""
import math

from flag_sim.cloth.mesh import LEAST_LENGTH2
from flag_sim.cloth.records import Field, NEXT, Vector
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel
import numpy as np


@lean_inner_kernel
def separation(x: tuple, y: tuple, radius: float) -> float:
    """
    Return how far the box of four points is from a box of that radius about the origin [m].

    x, y: of the points [m], four each.
    """
    x0, x1, x2, x3 = x
    y0, y1, y2, y3 = y
    return max(max(min(min(x0, x1), min(x2, x3)), -max(max(x0, x1), max(x2, x3))),
               max(min(min(y0, y1), min(y2, y3)), -max(max(y0, y1), max(y2, y3)))) - radius


@lean_inner_kernel
def _nearer(a, b, best, length2, side):
    """
    Return (best, length2, side), of the line from a to b if that passes the origin nearer.

    best / length2: the least squared distance so far [m2], of a side (x, y) [m] that goes around
    the origin counter-clockwise and is as long as the root of length2. No root, no division.
    """
    (ax, ay), (bx, by) = a, b
    ux, uy = bx - ax, by - ay
    squared = ux * ux + uy * uy
    along = -(ax * ux + ay * uy)
    cross = ux * ay - uy * ax
    if (type(ax)(0.0) < along < squared and squared > type(ax)(LEAST_LENGTH2)
            and cross * cross * length2 < best * squared):
        if cross < type(ax)(0.0):
            ux, uy = -ux, -uy
        return cross * cross, squared, (ux, uy)
    return best, length2, side


@lean_kernel
def _nearest_side(corners, nearest):
    """
    Return the direction from the origin to the nearest side or diagonal of a cell's corners.

    corners: four points (x, y) [m]. nearest: the one of them that is nearest to the origin.
    """
    a, b, c, d = corners
    px, py = nearest
    zero, one = type(px)(0.0), type(px)(1.0)
    least = px * px + py * py
    best, length2, side = _nearer(a, b, least, one, (zero, zero))
    best, length2, side = _nearer(c, d, best, length2, side)
    best, length2, side = _nearer(a, c, best, length2, side)
    best, length2, side = _nearer(b, d, best, length2, side)
    best, length2, side = _nearer(a, d, best, length2, side)
    best, length2, side = _nearer(b, c, best, length2, side)
    ux, uy = side
    if ux != zero or uy != zero:
        # At right angles to the side: exact where it passes close by.
        scale = one / math.sqrt(length2)
        return -uy * scale, ux * scale
    if least > zero:
        scale = one / math.sqrt(least)
        return px * scale, py * scale
    return one, zero


@lean_inner_kernel
def _beside_pin(nx, ny, px, py, radius):
    """Turn a tangent's normal as little as puts a pin on the outer side too, or nearest to it."""
    if nx * px + ny * py >= radius:
        return nx, ny
    zero, one = type(nx)(0.0), type(nx)(1.0)
    distance = math.sqrt(px * px + py * py)
    if distance == zero:
        return nx, ny
    px, py = px / distance, py / distance
    cosine = min(radius / distance, one)
    sine = math.sqrt(one - cosine * cosine)
    if nx * py - ny * px > zero:
        sine = -sine
    return cosine * px - sine * py, cosine * py + sine * px


@lean_inner_kernel
def cell_plane(position: Field, corner: np.uint64, stride: np.uint64, free: np.ndarray,
               pole: Vector) -> tuple[float, float]:
    """
    Return the unit normal (x, y) of the tangent that parts the cell of a corner from the pole.

    corner: its first node. Of a cell that is in the pole it is the tangent on its nearest side.
    The hoist does not move: the tangent is one that has it on the outer side.
    """
    center_x, center_y, radius = pole
    x, y, _ = position
    i, j = corner, corner + NEXT
    k, m = i + stride, j + stride
    ax, bx, cx, dx = x[i] - center_x, x[j] - center_x, x[k] - center_x, x[m] - center_x
    ay, by, cy, dy = y[i] - center_y, y[j] - center_y, y[k] - center_y, y[m] - center_y
    px, py, least, nearest = ax, ay, ax * ax + ay * ay, i
    for qx, qy, node in ((bx, by, j), (cx, cy, k), (dx, dy, m)):
        distance2 = qx * qx + qy * qy
        if distance2 < least:
            px, py, least, nearest = qx, qy, distance2, node
    ahead = min(min(px * ax + py * ay, px * bx + py * by),
                min(px * cx + py * cy, px * dx + py * dy))
    if ahead >= least > type(least)(0.0):
        # The nearest of the hull is a node: the usual case, and the cheapest.
        scale = type(least)(1.0) / math.sqrt(least)
        nx, ny = px * scale, py * scale
        if least >= radius * radius or not free[nearest] > 0.0:
            return nx, ny
    else:
        nx, ny = _nearest_side(((ax, ay), (bx, by), (cx, cy), (dx, dy)), (px, py))
    for node, px, py in ((i, ax, ay), (j, bx, by), (k, cx, cy), (m, dx, dy)):
        if not free[node] > 0.0:
            nx, ny = _beside_pin(nx, ny, px, py, radius)
    return nx, ny


@lean_kernel
def project(px: float, py: float, planes: tuple, radius: float,
            tolerance: float) -> tuple[bool, float, float]:
    """
    Return (found, x, y) of the point beyond all planes, n x >= radius, that is nearest to p.

    planes: four unit normals (x, y). The nearest is p, or on one of the lines, or where two meet.
    """
    one = type(radius)(1.0)
    least, bx, by = type(radius)(-1.0), px, py
    for j in range(4):
        nx, ny = planes[j]
        depth = radius - (nx * px + ny * py)
        if depth <= type(radius)(0.0):
            continue
        for k in range(4):
            # With itself: the foot on the line.
            mx, my = planes[k]
            cross = nx * my - ny * mx
            if k == j or cross == type(radius)(0.0):
                qx, qy = px + depth * nx, py + depth * ny
            else:
                scale = one / cross
                other = radius - (mx * px + my * py)
                qx = px + scale * (depth * my - other * ny)
                qy = py + scale * (other * nx - depth * mx)
            if is_beyond(qx, qy, planes, radius - tolerance):
                distance2 = (qx - px)**2 + (qy - py)**2
                if least < type(radius)(0.0) or distance2 < least:
                    least, bx, by = distance2, qx, qy
    return least >= type(radius)(0.0) or is_beyond(px, py, planes, radius), bx, by


@lean_inner_kernel
def is_beyond(x: float, y: float, planes: tuple, radius: float) -> bool:
    """Return whether a point is beyond all four planes."""
    least = planes[0][0] * x + planes[0][1] * y
    for k in range(1, 4):
        least = min(least, planes[k][0] * x + planes[k][1] * y)
    return least >= radius
