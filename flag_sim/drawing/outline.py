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
Outlines: the triangles' edges as lines of Bresenham (1965), depth-tested.

The colour is the triangle's own in a darker shade. A line is drawn into whole pixels, up to half
of one away from the edge; there it has the reversed Z of the triangle's plane, clamped to that of
its corners, so that the triangle does not hide its own edges.
"""
from flag_sim.drawing.depth import is_nearer
from flag_sim.drawing.geometry import SUBPIXEL_BITS, SUBPIXELS
from flag_sim.drawing.pixels import clamp, pack_rgb
from flag_sim.drawing.visibility import OUTLINE
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# The source darkens by 120 %, which is a division by 1.2.
DARKENING = 1.2
# A line is drawn over what is nearer by no more than this part of its reversed Z: the rounding of
# float32, and the neighbouring triangle's plane where the cloth is nearly flat.
DEPTH_BIAS = 1e-4


@late_kernel
def draw_outline(polygon, count, state, primitive_id, target):
    """
    Draw the edges of a polygon of `count` corners.

    state, target: see rasterizer; primitive_id: what its pixels store if IDs are wanted.
    """
    plane = _plane(polygon, count)
    for k in range(count):
        _draw_edge(polygon, (k, k + 1 if k + 1 < count else 0), plane, state, primitive_id, target)


@late_kernel
def _draw_edge(polygon, edge, plane, state, primitive_id, target):
    _, u, v, values, _ = polygon
    s_du, s_dv, s_least, s_most = plane
    top, end, width, stride = target.top, target.end, target.width, target.stride
    # Both triangles of an edge draw it in the same direction, into the same pixels.
    a, b = edge
    if (u[b], v[b]) < (u[a], v[a]):
        a, b = b, a
    a_u, a_v = _nearest_pixel(u[a]), _nearest_pixel(v[a])
    b_u, b_v = _nearest_pixel(u[b]), _nearest_pixel(v[b])
    is_steep = abs(b_v - a_v) > abs(b_u - a_u)
    length, rise = (b_v - a_v, b_u - a_u) if is_steep else (b_u - a_u, b_v - a_v)
    start, other_start, least, limit = (a_v, a_u, top, end) if is_steep else (a_u, a_v, 0, width)
    direction = 1 if length >= 0 else -1
    length = abs(length)
    # The steps i with start + i direction inside the rows or columns.
    first = max(0, least - start if direction > 0 else start - limit + 1)
    last = min(length, limit - 1 - start if direction > 0 else start - least)
    for i in range(first, last + 1):
        # Bresenham's decision in closed form, so that a line may begin at the image's border.
        other = other_start + (2 * rise * i + length) // max(2 * length, 1)
        column, row = start + i * direction, other
        if is_steep:
            column, row = row, column
        if column < 0 or column >= width or row < top or row >= end:
            continue
        s = values[a, 0] + (s_du * (column - u[a] / SUBPIXELS) + s_dv * (row - v[a] / SUBPIXELS))
        s = clamp(s, s_least, s_most)
        pixel = (row - top) * stride + column
        stored = min(target.depth[pixel], state.depth_ceiling)
        if not is_nearer(stored, s + DEPTH_BIAS * abs(s)):
            along = i / max(length, 1)
            # Perspective-correct colours come multiplied by 1 / z.
            divisor = DARKENING
            if state.is_perspective_correct:
                divisor *= values[a, 0] + along * (values[b, 0] - values[a, 0])
            target.depth[pixel] = max(np.float32(s), stored)
            target.colour[pixel] = pack_rgb(_between(values, (a, b), 1, along, divisor),
                                            _between(values, (a, b), 2, along, divisor),
                                            _between(values, (a, b), 3, along, divisor))
            if target.primitive_ids.size > 0:
                target.primitive_ids[pixel] = np.uint32(primitive_id) | OUTLINE


@late_inner_kernel
def _between(values, edge, q, along, divisor):
    a, b = edge
    return np.float32((values[a, q] + along * (values[b, q] - values[a, q])) / divisor)


@late_inner_kernel
def _nearest_pixel(coordinate):
    """Return the pixel whose centre is nearest to a coordinate [subpixel]."""
    return (coordinate + SUBPIXELS // 2) >> SUBPIXEL_BITS


@late_kernel
def _plane(polygon, count):
    """
    Return the changes of reversed Z a column and a row, its least and its most.

    The changes are those of the fan's triangle with the largest area.
    """
    u, v, values = polygon.u, polygon.v, polygon.values
    largest, s_du, s_dv = 0.0, 0.0, 0.0
    s_least, s_most = values[0, 0], values[0, 0]
    for k in range(1, count):
        s_least, s_most = min(s_least, values[k, 0]), max(s_most, values[k, 0])
    for k in range(2, count):
        ab_u, ab_v = float(u[k - 1] - u[0]), float(v[k - 1] - v[0])
        ac_u, ac_v = float(u[k] - u[0]), float(v[k] - v[0])
        ab_s, ac_s = values[k - 1, 0] - values[0, 0], values[k, 0] - values[0, 0]
        area = ab_u * ac_v - ac_u * ab_v
        if abs(area) > largest:
            largest = abs(area)
            s_du = SUBPIXELS * (ab_s * ac_v - ac_s * ab_v) / area
            s_dv = SUBPIXELS * (ab_u * ac_s - ac_u * ab_s) / area
    return s_du, s_dv, s_least, s_most
