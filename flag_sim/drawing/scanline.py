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
Scanlines: LARGE triangles, drawn one by one and row by row.

LARGE are those that are wide, and those that the near plane or the guard band cuts. In each row
the edge functions tell the first and the last pixel inside, so that no others are looked at.
"""
from flag_sim.drawing.coverage import edge_function, end_inside, first_inside
from flag_sim.drawing.depth import is_nearer
from flag_sim.drawing.geometry import next_centre, SUBPIXELS
from flag_sim.drawing.pixels import clamp, LANES, pack_rgb, WHOLE_VECTORS
from flag_sim.drawing.visibility import face_mark
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np


@late_kernel
def draw_large(polygon, last, face, state, target, rare):
    """
    Draw the triangle of a polygon's corners 0, last - 1 and last.

    face: twice the index of the triangle that it is part of, plus the side; state, target, rare:
    see rasterizer.
    """
    _, u, v, values, planes = polygon
    b, c = last - 1, last
    a_u, a_v = u[0], v[0]
    ab_u, ab_v, ac_u, ac_v = u[b] - a_u, v[b] - a_v, u[c] - a_u, v[c] - a_v
    area = ab_u * ac_v - ac_u * ab_v
    left = max(next_centre(a_u + min(ab_u, ac_u, 0)), 0)
    right = min(next_centre(a_u + max(ab_u, ac_u, 0)), target.width)
    top = max(next_centre(a_v + min(ab_v, ac_v, 0)), 0)
    end = next_centre(a_v + max(ab_v, ac_v, 0))
    begin, stop = max(top, target.top), min(end, target.end)
    if area == 0 or left >= right or begin >= stop:
        return
    scale = SUBPIXELS / area
    # Changes a column and a row of the barycentric weights of b and c.
    slopes = ac_v * scale, -ac_u * scale, -ab_v * scale, ab_u * scale
    for q in range(4):
        _plane(polygon, (0, b, c), q, slopes, q > 0 and state.is_perspective_correct)
    sign = 1 if area > 0 else -1
    du, dv = left * SUBPIXELS - a_u, top * SUBPIXELS - a_v
    # From a to b, from c to a and from b to c, inside to the left.
    edges = ((edge_function(-ab_v * sign, ab_u * sign, du, dv), -ab_v * sign, ab_u * sign),
             (edge_function(ac_v * sign, -ac_u * sign, du, dv), ac_v * sign, -ac_u * sign),
             (edge_function((ab_v - ac_v) * sign, (ac_u - ab_u) * sign, du - ab_u, dv - ab_v),
              (ab_v - ac_v) * sign, (ac_u - ab_u) * sign))
    for row in range(begin, stop):
        first, end_of_row = np.int64(0), np.int64(right - left)
        for edge in edges:
            here = edge[0] + (row - top) * edge[2]
            first = first_inside(first, here, edge[1])
            end_of_row = end_inside(end_of_row, here, edge[1])
        if first < end_of_row:
            pixel = (row - target.top) * target.stride + left + first
            offset = left + first - a_u / SUBPIXELS, row - a_v / SUBPIXELS
            draw_span(np.uint64(pixel), np.uint64(end_of_row - first), planes, offset, state,
                      face, target, rare)


@late_inner_kernel
def _plane(polygon, corners, q, slopes, is_times_s):
    """
    Write polygon.planes[q]: value q at the first of three corners, its changes, its range.

    These are its changes a column and a row, its least and its most at the corners; of a value
    that is_times_s, multiplied by reversed Z, the least and most are those without it.
    """
    values, planes = polygon.values, polygon.planes
    a, b, c = corners
    b_du, b_dv, c_du, c_dv = slopes
    at_a, at_b, at_c = values[a, q], values[b, q], values[c, q]
    planes[q, 0] = at_a
    planes[q, 1] = (at_b - at_a) * b_du + (at_c - at_a) * c_du
    planes[q, 2] = (at_b - at_a) * b_dv + (at_c - at_a) * c_dv
    if is_times_s:
        at_a, at_b, at_c = at_a / values[a, 0], at_b / values[b, 0], at_c / values[c, 0]
    planes[q, 3], planes[q, 4] = min(at_a, at_b, at_c), max(at_a, at_b, at_c)


@late_inner_kernel
def draw_span(first, count, planes, offset, state, face, target, rare):
    """
    Draw pixels first .. first + count - 1 where they are nearer than what is stored.

    planes: of a Polygon; offset: of the first pixel from the planes' corner, columns and rows;
    face, state, target, rare: see draw_large.
    The loop runs over whole vectors, with the lanes beyond the end masked. What never changes in
    it is passed as literals, so that each case gets a loop of its own.
    """
    span = (first, count, face_mark(face), state.depth_ceiling)
    if rare is not None:
        if target.faces.size > 0:
            _draw_pixels(span, planes, offset, target, state.is_perspective_correct, True)
            return
    if state.is_perspective_correct:
        _draw_pixels(span, planes, offset, target, True, False)
    else:
        _draw_pixels(span, planes, offset, target, False, False)


@late_inner_kernel
def _draw_pixels(span, planes, offset, target, is_perspective_correct, has_faces):
    first, count, face, ceiling = span
    depth, colour, faces = target.depth, target.colour, target.faces
    s, ds, s_least, s_most = _value(planes, 0, offset)
    red, dr, r_least, r_most = _value(planes, 1, offset)
    green, dg, g_least, g_most = _value(planes, 2, offset)
    blue, db, b_least, b_most = _value(planes, 3, offset)
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE_VECTORS):
        i = np.float32(np.int32(j))
        here = clamp(s + ds * i, s_least, s_most)
        if i < end and is_nearer(here, min(depth[first + j], ceiling)):
            depth[first + j] = here
            # Perspective-correct colours are carried times 1 / z (Heckbert, 1989).
            z = np.float32(1.0) / here if is_perspective_correct else np.float32(1.0)
            colour[first + j] = pack_rgb(clamp((red + dr * i) * z, r_least, r_most),
                                         clamp((green + dg * i) * z, g_least, g_most),
                                         clamp((blue + db * i) * z, b_least, b_most))
            if has_faces:
                faces[first + j] = face


@late_inner_kernel
def _value(planes, q, offset):
    """Return value q at an offset from the planes' corner, its change a column, least and most."""
    du, dv = offset
    return (np.float32(planes[q, 0] + planes[q, 1] * du + planes[q, 2] * dv),
            np.float32(planes[q, 1]), np.float32(planes[q, 3]), np.float32(planes[q, 4]))
