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
Whether the cloth passes through itself: exact tests of triangles, those that may meet alone.

The cloth does not collide with itself, so in hard flapping it may; a picture of it then shows
what no cloth does. The triangles are those that are drawn. A pair meets where an edge of one
passes through the other from one side to its other side. Signs are of determinants in float64
and, where their rounding could be wrong, of exact fractions.
"""
from fractions import Fraction

from flag_sim.jit.kernels import kernel
from flag_sim.parameters import checks
import numpy as np

ROUNDING = 1e-14
"""Bound of the error of a determinant of three differences, in parts of the sum of its terms."""


def is_self_intersecting(positions: np.ndarray) -> bool:
    """
    Return whether a cloth of nodes at positions (rows, columns, 3) [m] passes through itself.

    What only touches does not; nor do neighbours that are folded flat on one another. Raises
    ValueError for other shapes, and for numbers that are not finite.
    """
    positions = checks.grid('positions', positions)
    shape = positions.shape
    points = checks.array('positions', positions, shape).reshape(-1, 3)
    triangles = _triangles(*shape[:2])
    corners = points[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    axis = int(np.argmax(np.ptp(points, axis=0)))
    order = np.argsort(low[:, axis], kind='stable')
    undecided, begin = np.empty((len(order), 2), np.int64), 0  # of one triangle, at most all
    while begin < len(order):
        begin, count, meets = _sweep(points, triangles, (low, high), (order, axis, begin),
                                     undecided)
        if meets or any(_meet_exactly(points, triangles[a], triangles[b])
                        for a, b in undecided[:count]):
            return True
    return False


def _triangles(rows, columns):
    """Return the triangles of a grid, cut as the wind's faces and the picture's: (m, 3)."""
    node = np.arange(rows * columns).reshape(rows, columns)
    here, right, below, across = node[:-1, :-1], node[:-1, 1:], node[1:, :-1], node[1:, 1:]
    return np.stack([here, right, below, across, below, right], axis=-1).reshape(-1, 3)


@kernel
def _sweep(points, triangles, bounds, place, undecided):
    """
    Test triangles against those whose bounds they share, from `begin` of the order on.

    place: the order by the lower bound along an axis, that axis, and begin. Return where to go on,
    how many pairs are undecided, and whether one meets.
    """
    low, high = bounds
    order, axis, begin = place
    count = 0
    for i in range(begin, len(order)):
        a = order[i]
        # A triangle is finished as a whole, so there must be room for what it may add.
        start = count
        for j in range(i + 1, len(order)):
            b = order[j]
            if low[b, axis] > high[a, axis]:
                break
            # Those whose boxes only touch do not pass through one another.
            if (low[a, 0] >= high[b, 0] or high[a, 0] <= low[b, 0] or low[a, 1] >= high[b, 1]
                    or high[a, 1] <= low[b, 1] or low[a, 2] >= high[b, 2]
                    or high[a, 2] <= low[b, 2]):
                continue
            found = _meet(points, triangles[a], triangles[b])
            if found > 0:
                return i, count, True
            if found < 0:
                if count == len(undecided):
                    return i, start, False
                undecided[count, 0], undecided[count, 1] = a, b
                count += 1
    return len(order), count, False


@kernel
def _meet(points, a, b):
    """Return 1 where two triangles meet, 0 where not, -1 where rounding could be wrong."""
    found = 0
    for k in range(3):
        for one, other in ((a, b), (b, a)):
            passes = _passes(points, one[k], one[(k + 1) % 3], other)
            if passes > 0:
                return 1
            found = min(found, passes)
    return found


@kernel
def _passes(points, p, q, triangle):
    """Return 1 where the edge from p to q passes through a triangle, 0 where not, -1: unsure."""
    a, b, c = triangle[0], triangle[1], triangle[2]
    if p == a or p == b or p == c or q == a or q == b or q == c:
        return 0  # they have a node in common, and meet there alone or in a plane
    above, below = _side(points, a, b, c, p), _side(points, a, b, c, q)
    if above * below == 1:
        return 0
    first, second = _side(points, p, q, a, b), _side(points, p, q, b, c)
    third = _side(points, p, q, c, a)
    if first * second == -1 or second * third == -1 or first * third == -1:
        return 0
    if above * below == -1 and first != 0 and second != 0 and third != 0:
        return 1
    return -1


@kernel
def _side(points, a, b, c, d):
    """Return on which side of the triangle a b c the point d is: 1 or -1; 0: unsure, or in it."""
    x, y, z = points[d, 0], points[d, 1], points[d, 2]
    px, py, pz = points[a, 0] - x, points[a, 1] - y, points[a, 2] - z
    qx, qy, qz = points[b, 0] - x, points[b, 1] - y, points[b, 2] - z
    rx, ry, rz = points[c, 0] - x, points[c, 1] - y, points[c, 2] - z
    value = (px * (qy * rz - qz * ry) + py * (qz * rx - qx * rz) + pz * (qx * ry - qy * rx))
    size = (abs(px) * (abs(qy * rz) + abs(qz * ry)) + abs(py) * (abs(qz * rx) + abs(qx * rz))
            + abs(pz) * (abs(qx * ry) + abs(qy * rx)))
    if value > ROUNDING * size:
        return 1
    return -1 if value < -ROUNDING * size else 0


def _meet_exactly(points, a, b):
    """Return whether two triangles meet, in fractions."""
    exact = {int(i): [Fraction(float(x)) for x in points[i]] for i in (*a, *b)}

    def side(*nodes):
        p, q, r = ([x - y for x, y in zip(exact[n], exact[nodes[3]])] for n in nodes[:3])
        value = (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2])
                 + p[2] * (q[0] * r[1] - q[1] * r[0]))
        return (value > 0) - (value < 0)

    for one, other in ((a, b), (b, a)):
        x, y, z = map(int, other)
        for k in range(3):
            p, q = int(one[k]), int(one[(k + 1) % 3])
            if p not in (x, y, z) and q not in (x, y, z):
                around = {side(p, q, x, y), side(p, q, y, z), side(p, q, z, x)}
                if side(x, y, z, p) * side(x, y, z, q) == -1 and around in ({1}, {-1}):
                    return True
    return False
