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
Triangles that are wide, or cut by the near plane or the guard band, one by one, row by row.

Of each row the edge functions tell the first and the last pixel inside, so that none is looked at
beside it.
"""
from typing import NamedTuple

from flag_sim.drawing.attributes import write_planes
from flag_sim.drawing.clipping import clip, CORNER_FIELDS, INSIDE, MOST_CORNERS
from flag_sim.drawing.coverage import edge_function, end_inside, first_inside
from flag_sim.drawing.geometry import next_centre, SUBPIXELS, to_screen
from flag_sim.kernels import inner_kernel, kernel

import numpy as np

LANES = 8
WHOLE = np.uint64(2 ** 64 - LANES)
# Corners in polygons: u, v [subpixel], reversed Z, and the weights of the triangle's second and
# third vertex, linear in space.
PLACES = MOST_CORNERS + 1


class Polygon(NamedTuple):
    """
    What is seen of a triangle.

    corners: (2, PLACES, CORNER_FIELDS), for clipping; u, v: (PLACES,) int64 [subpixel];
    reversed_z: (PLACES,).
    """

    corners: np.ndarray
    u: np.ndarray
    v: np.ndarray
    reversed_z: np.ndarray


def new_polygon() -> Polygon:
    """Make a polygon's arrays."""
    return Polygon(np.empty((2, PLACES, CORNER_FIELDS)), *np.empty((2, PLACES), np.int64),
                   np.empty(PLACES))


@kernel
def cut_out(geometry, triangle, how, polygon):
    """
    Put what is seen of a triangle in the polygon; return its number of corners and its side.

    Backs of closed bodies have no corners.
    """
    triangles, vertices, lens = geometry.triangles, geometry.vertices, geometry.lens
    a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
    outcodes = vertices.outcodes
    is_whole = (outcodes[a] | outcodes[b] | outcodes[c]) == INSIDE
    if is_whole:
        side = _side(vertices, a, b, c)
    else:
        side = _side_of_view(vertices.seen, a, b, c, lens.is_perspective)
    if side < 0 or (side == 1 and geometry.is_closed[triangle]):
        return 0, 0
    corners, u, v, reversed_z = polygon
    for k in range(3):
        vertex = triangles[triangle, k]
        for axis in range(3):
            corners[0, k, axis] = vertices.seen[vertex, axis]
        for half in range(2):
            corners[half, k, 3], corners[half, k, 4] = np.float64(k == 1), np.float64(k == 2)
        u[k], v[k] = vertices.u[vertex] - how.shift_u, vertices.v[vertex] - how.shift_v
        reversed_z[k] = vertices.reversed_z[vertex]
    if is_whole:
        return 3, side
    count = clip(corners, lens.near, lens.is_perspective)
    for k in range(count):
        sub_u, sub_v, reversed_z[k] = to_screen(corners[1, k, 0], corners[1, k, 1],
                                                corners[1, k, 2], lens.cu, lens.cv,
                                                lens.is_perspective)
        u[k], v[k] = sub_u - how.shift_u, sub_v - how.shift_v
    return count, side


@inner_kernel
def _side(vertices, a, b, c):
    """Return which side a triangle shows: 0 front (counterclockwise), 1 back, -1 its edge."""
    u, v = vertices.u, vertices.v
    area = (np.int64(u[b] - u[a]) * np.int64(v[c] - v[a])
            - np.int64(u[c] - u[a]) * np.int64(v[b] - v[a]))
    # v points down, which turns the sign.
    return 0 if area < 0 else 1 if area > 0 else -1


@kernel
def _side_of_view(view, a, b, c, is_perspective):
    """Return the same from the points in space: perspective asks where the eye is."""
    px, py, pz = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1], view[b, 2] - view[a, 2]
    qx, qy, qz = view[c, 0] - view[a, 0], view[c, 1] - view[a, 1], view[c, 2] - view[a, 2]
    toward = px * qy - py * qx
    if is_perspective:
        toward = (view[a, 0] * (py * qz - pz * qy) + view[a, 1] * (pz * qx - px * qz)
                  + view[a, 2] * toward)
    return 0 if toward < 0.0 else 1 if toward > 0.0 else -1


@kernel
def draw_large(polygon, last, source, how, values, table, slot, target):
    """
    Draw the triangle of a polygon's corners 0, last - 1 and last.

    source: see attributes; how, target: see visibility; table: planes of slot `slot` are written.
    Returns whether it does that, as it does if anything of the triangle can be seen.
    """
    corners, u, v, reversed_z = polygon
    b, c = last - 1, last
    au, av = u[0], v[0]
    pu, pv, qu, qv = u[b] - au, v[b] - av, u[c] - au, v[c] - av
    area = pu * qv - qu * pv
    left = max(next_centre(au + min(pu, qu, 0)), 0)
    right = min(next_centre(au + max(pu, qu, 0)), target.width)
    top, end = next_centre(av + min(pv, qv, 0)), next_centre(av + max(pv, qv, 0))
    top = max(top, 0)
    begin, stop = max(top, target.top), min(end, target.end)
    # Lines of an outline may lie in other pixels than the triangle.
    if area == 0 or (not how.is_outlined and (left >= right or begin >= stop)):
        return False
    share = SUBPIXELS / area
    bu, bv, cu, cv = qv * share, -qu * share, -pv * share, pu * share
    du, dv = left * SUBPIXELS - au, top * SUBPIXELS - av
    x, y = du / SUBPIXELS, dv / SUBPIXELS
    slopes = bu, bv, cu, cv, x, y
    of_b = _plane(corners[1, 0, 3], corners[1, b, 3], corners[1, c, 3], slopes)
    of_c = _plane(corners[1, 0, 4], corners[1, b, 4], corners[1, c, 4], slopes)
    of_a = 1.0 - of_b[0] - of_c[0], -of_b[1] - of_c[1], -of_b[2] - of_c[2]
    sa, sb, sc = reversed_z[0], reversed_z[b], reversed_z[c]
    s = _plane(sa, sb, sc, slopes)
    s_b = _plane(sa * corners[1, 0, 3], sb * corners[1, b, 3], sc * corners[1, c, 3], slopes)
    s_c = _plane(sa * corners[1, 0, 4], sb * corners[1, b, 4], sc * corners[1, c, 4], slopes)
    s_a = s[0] - s_b[0] - s_c[0], s[1] - s_b[1] - s_c[1], s[2] - s_b[2] - s_c[2]
    write_planes(values, how.groups, table, slot, source, (np.float32(left), np.float32(top)),
                 (of_a + of_b + of_c, s_a + s_b + s_c))

    sign = 1 if area > 0 else -1
    edges = ((edge_function(-pv * sign, pu * sign, du, dv), -pv * sign, pu * sign),
             (edge_function(qv * sign, -qu * sign, du, dv), qv * sign, -qu * sign),
             (edge_function((pv - qv) * sign, (qu - pu) * sign, du - pu, dv - pv),
              (pv - qv) * sign, (qu - pu) * sign))
    bounds = np.float32(min(sa, sb, sc)), np.float32(max(sa, sb, sc)), how.ceiling
    for row in range(begin, stop):
        first, last_one = np.int64(0), np.int64(right - left)
        for edge in edges:
            here = edge[0] + (row - top) * edge[2]
            first = first_inside(first, here, edge[1])
            last_one = end_inside(last_one, here, edge[1])
        if first < last_one:
            _draw_span(np.uint64((row - target.top) * target.stride + left + first),
                       np.uint64(last_one - first),
                       (np.float32(s[0] + s[1] * first + s[2] * (row - top)), np.float32(s[1])),
                       bounds, np.uint32(slot), target)
    return True


@inner_kernel
def _plane(a, b, c, slopes):
    """Return a value at the first pixel and its changes a column and a row, of three corners'."""
    bu, bv, cu, cv, x, y = slopes
    change_u, change_v = (b - a) * bu + (c - a) * cu, (b - a) * bv + (c - a) * cv
    return a + change_u * x + change_v * y, change_u, change_v


@inner_kernel
def _draw_span(first, count, ramp, bounds, slot, target):
    """
    Draw pixels first .. first + count - 1 where they are nearer than what is there.

    ramp: reversed Z at the first, and its change a pixel; bounds: the least and the most of it,
    and the ceiling. Rounded up to whole vectors, of which the lanes beyond the end are masked.
    """
    depths, slots = target.depths, target.slots
    s, s_u = ramp
    least, most, ceiling = bounds
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = min(max(s + s_u * i, least), most)
        if i < end and here > min(depths[first + j], ceiling):
            depths[first + j] = here
            slots[first + j] = slot
