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

from flag_sim.drawing.attributes import keep_slot
from flag_sim.drawing.clipping import clip, CORNER_FIELDS, INSIDE, MOST_CORNERS
from flag_sim.drawing.coverage import edge_function, end_inside, first_inside
from flag_sim.drawing.geometry import next_centre, SUBPIXELS, to_screen
from flag_sim.drawing.pixels import hold, LANES, pack, WHOLE
from flag_sim.jit.kernels import inner_kernel, kernel

import numpy as np

PLACES = MOST_CORNERS + 1


class Polygon(NamedTuple):
    """
    What is seen of a triangle.

    corners: (2, PLACES, CORNER_FIELDS), see clipping; u, v: (PLACES,) int64 [subpixel]; values:
    (PLACES, 6): reversed Z, red, green, blue, the last three times it where they are interpolated
    so, and the weights of the triangle's second and third vertex, in perspective times it;
    planes: (6, 5): of each value at corner 0, its changes a column and a row, its least and its
    most (of colours: not times reversed Z).
    """

    corners: np.ndarray
    u: np.ndarray
    v: np.ndarray
    values: np.ndarray
    planes: np.ndarray


def new_polygon() -> Polygon:
    """Make a polygon's arrays."""
    return Polygon(np.empty((2, PLACES, CORNER_FIELDS)), *np.empty((2, PLACES), np.int64),
                   np.empty((PLACES, 6)), np.empty((6, 5)))


@kernel
def cut_out(geometry, colours, triangle, how, polygon):
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
    corners, u, v, values, _ = polygon
    for k in range(3):
        vertex = triangles[triangle, k]
        for axis in range(3):
            corners[0, k, axis] = vertices.seen[vertex, axis]
        for half in range(2):
            corners[half, k, 3], corners[half, k, 4] = np.float64(k == 1), np.float64(k == 2)
        u[k], v[k] = vertices.u[vertex], vertices.v[vertex]
        values[k, 0] = vertices.reversed_z[vertex]
    count = 3 if is_whole else clip(corners, lens.near, lens.is_perspective)
    colour = colours.values
    if colours.is_flat:
        a = b = c = triangle
    for k in range(count):
        if not is_whole:
            u[k], v[k], values[k, 0] = to_screen(
                corners[1, k, 0], corners[1, k, 1], corners[1, k, 2], lens.cu, lens.cv,
                lens.is_perspective)
        u[k] -= how.shift_u
        v[k] -= how.shift_v
        of_b, of_c = corners[1, k, 3], corners[1, k, 4]
        times = values[k, 0] if how.is_perspective_correct else 1.0
        for channel in range(3):
            at_a = colour[a, side, channel]
            values[k, 1 + channel] = times * (
                at_a + of_b * (colour[b, side, channel] - at_a)
                + of_c * (colour[c, side, channel] - at_a))
        times = values[k, 0] if lens.is_perspective else 1.0
        values[k, 4], values[k, 5] = times * of_b, times * of_c
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
def draw_large(polygon, last, face, how, slot, target):
    """
    Draw the triangle of a polygon's corners 0, last - 1 and last.

    face: twice the number of the triangle that it is of, and the side; how, target: see
    visibility. Returns whether slot `slot` is taken now.
    """
    _, u, v, values, planes = polygon
    b, c = last - 1, last
    au, av = u[0], v[0]
    pu, pv, qu, qv = u[b] - au, v[b] - av, u[c] - au, v[c] - av
    area = pu * qv - qu * pv
    left = max(next_centre(au + min(pu, qu, 0)), 0)
    right = min(next_centre(au + max(pu, qu, 0)), target.width)
    top, end = max(next_centre(av + min(pv, qv, 0)), 0), next_centre(av + max(pv, qv, 0))
    begin, stop = max(top, target.top), min(end, target.end)
    # Lines of an outline may lie in other pixels than the triangle.
    if area == 0 or (not how.is_outlined and (left >= right or begin >= stop)):
        return False
    share = SUBPIXELS / area
    bu, bv, cu, cv = qv * share, -qu * share, -pv * share, pu * share
    for q in range(4):
        _plane(polygon, (0, b, c), q, (bu, bv, cu, cv),
               q > 0 and how.is_perspective_correct)
    if target.numbers.size > 0:
        for q in range(4, 6):
            _plane(polygon, (0, b, c), q, (bu, bv, cu, cv), False)
        keep_slot(target.slots, slot, face, (planes[4, 0], planes[4, 1], planes[4, 2]),
                  (planes[5, 0], planes[5, 1], planes[5, 2]), (au / SUBPIXELS, av / SUBPIXELS))
    sign = 1 if area > 0 else -1
    du, dv = left * SUBPIXELS - au, top * SUBPIXELS - av
    edges = ((edge_function(-pv * sign, pu * sign, du, dv), -pv * sign, pu * sign),
             (edge_function(qv * sign, -qu * sign, du, dv), qv * sign, -qu * sign),
             (edge_function((pv - qv) * sign, (qu - pu) * sign, du - pu, dv - pv),
              (pv - qv) * sign, (qu - pu) * sign))
    for row in range(begin, stop):
        first, end_of_row = np.int64(0), np.int64(right - left)
        for edge in edges:
            here = edge[0] + (row - top) * edge[2]
            first = first_inside(first, here, edge[1])
            end_of_row = end_inside(end_of_row, here, edge[1])
        if first < end_of_row:
            pixel = (row - target.top) * target.stride + left + first
            way = left + first - au / SUBPIXELS, row - av / SUBPIXELS
            draw_span(np.uint64(pixel), np.uint64(end_of_row - first), planes, way, how, slot,
                      target)
    return True


@inner_kernel
def _plane(polygon, places, q, slopes, is_times_s):
    """Write the plane of value q over three corners at `places`, and its bounds."""
    values, planes = polygon.values, polygon.planes
    a, b, c = places
    bu, bv, cu, cv = slopes
    at_a, at_b, at_c = values[a, q], values[b, q], values[c, q]
    planes[q, 0] = at_a
    planes[q, 1] = (at_b - at_a) * bu + (at_c - at_a) * cu
    planes[q, 2] = (at_b - at_a) * bv + (at_c - at_a) * cv
    if is_times_s:
        at_a, at_b, at_c = at_a / values[a, 0], at_b / values[b, 0], at_c / values[c, 0]
    planes[q, 3], planes[q, 4] = min(at_a, at_b, at_c), max(at_a, at_b, at_c)


@inner_kernel
def draw_span(first, count, planes, way, how, slot, target):
    """
    Draw pixels first .. first + count - 1 where they are nearer than what is there.

    planes: of a Polygon; way: to the first pixel from where they begin. Rounded up to whole
    vectors, of which the lanes beyond the end are masked. What never changes in the loop is told
    by literals: each then has a loop of its own.
    """
    run = (first, count, np.uint32(slot), how.ceiling)
    if target.numbers.size > 0:
        _draw_pixels(run, planes, way, target, how.is_perspective_correct, True)
    elif how.is_perspective_correct:
        _draw_pixels(run, planes, way, target, True, False)
    else:
        _draw_pixels(run, planes, way, target, False, False)


@inner_kernel
def _draw_pixels(run, planes, way, target, is_perspective_correct, keeps_slots):
    first, count, slot, ceiling = run
    depths, words, numbers = target.depths, target.words, target.numbers
    s, ds, s_least, s_most = _value(planes, 0, way)
    red, dr, r_least, r_most = _value(planes, 1, way)
    green, dg, g_least, g_most = _value(planes, 2, way)
    blue, db, b_least, b_most = _value(planes, 3, way)
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = hold(s + ds * i, s_least, s_most)
        if i < end and here > min(depths[first + j], ceiling):
            depths[first + j] = here
            # Perspective-correct colours come times 1 / z (Heckbert, 1989).
            depth = np.float32(1.0) / here if is_perspective_correct else np.float32(1.0)
            words[first + j] = pack(hold((red + dr * i) * depth, r_least, r_most),
                                    hold((green + dg * i) * depth, g_least, g_most),
                                    hold((blue + db * i) * depth, b_least, b_most))
            if keeps_slots:
                numbers[first + j] = slot


@inner_kernel
def _value(planes, q, way):
    """Return value q some way from where planes begin, its change a column, its least and most."""
    du, dv = way
    return (np.float32(planes[q, 0] + planes[q, 1] * du + planes[q, 2] * dv),
            np.float32(planes[q, 1]), np.float32(planes[q, 3]), np.float32(planes[q, 4]))
