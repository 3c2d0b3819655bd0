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
of one away from the edge; there it has the reversed Z of the triangle's plane, held within that
of its corners, so that the triangle does not hide its own edges.
"""
from flag_sim.drawing.geometry import SUBPIXEL_BITS, SUBPIXELS
from flag_sim.drawing.pixels import pack
from flag_sim.jit.kernels import inner_kernel, kernel

import numpy as np

# The source darkens by 120 %, which is a division by 1.2.
DARKER = 1.2
# A line lies before what is nearer by no more than this share: rounding in float32, and the
# neighbour's plane where the cloth is nearly flat.
BEFORE = 1e-4


@kernel
def draw_outline(polygon, count, how, slot, target):
    """
    Draw the edges of a polygon of `count` corners.

    how, target: see visibility; slot: what its pixels show beside the colour.
    """
    plane = _plane(polygon, count)
    for k in range(count):
        _draw_edge(polygon, k, k + 1 if k + 1 < count else 0, plane, how, slot, target)


@kernel
def _draw_edge(polygon, a, b, plane, how, slot, target):
    _, u, v, values, _ = polygon
    s_u, s_v, lowest, highest = plane
    top, end, width, stride = target.top, target.end, target.width, target.stride
    # Both triangles of an edge draw it in the same direction, into the same pixels.
    if (u[b], v[b]) < (u[a], v[a]):
        a, b = b, a
    au, av, bu, bv = _nearest(u[a]), _nearest(v[a]), _nearest(u[b]), _nearest(v[b])
    is_steep = abs(bv - av) > abs(bu - au)
    length, rise = (bv - av, bu - au) if is_steep else (bu - au, bv - av)
    start, other_start, least, limit = (av, au, top, end) if is_steep else (au, av, 0, width)
    way = 1 if length >= 0 else -1
    length = abs(length)
    # The steps i with start + i way inside the rows or columns.
    first = max(0, least - start if way > 0 else start - limit + 1)
    last = min(length, limit - 1 - start if way > 0 else start - least)
    for i in range(first, last + 1):
        # Bresenham's decision in closed form, so that a line may begin at the image's rim.
        other = other_start + (2 * rise * i + length) // max(2 * length, 1)
        column, row = (other, start + i * way) if is_steep else (start + i * way, other)
        if column < 0 or column >= width or row < top or row >= end:
            continue
        s = values[a, 0] + (s_u * (column - u[a] / SUBPIXELS) + s_v * (row - v[a] / SUBPIXELS))
        s = min(max(s, lowest), highest)
        pixel = (row - top) * stride + column
        there = min(target.depths[pixel], how.ceiling)
        if s + BEFORE * abs(s) >= there:
            along = i / max(length, 1)
            # Perspective-correct colours come multiplied by 1 / z.
            divisor = DARKER
            if how.is_perspective_correct:
                divisor *= values[a, 0] + along * (values[b, 0] - values[a, 0])
            target.depths[pixel] = max(np.float32(s), there)
            target.words[pixel] = pack(_between(values, a, b, 1, along, divisor),
                                       _between(values, a, b, 2, along, divisor),
                                       _between(values, a, b, 3, along, divisor))
            if target.numbers.size > 0:
                target.numbers[pixel] = np.uint32(slot)


@inner_kernel
def _between(values, a, b, q, along, divisor):
    return np.float32((values[a, q] + along * (values[b, q] - values[a, q])) / divisor)


@inner_kernel
def _nearest(coordinate):
    """Return the pixel whose centre is nearest to a coordinate [subpixel]."""
    return (coordinate + SUBPIXELS // 2) >> SUBPIXEL_BITS


@kernel
def _plane(polygon, count):
    """
    Return the slopes of reversed Z along u and v [1 / pixel], its least and its most.

    The slopes are those of the polygon's widest fan triangle.
    """
    u, v, values = polygon.u, polygon.v, polygon.values
    best, s_u, s_v = 0.0, 0.0, 0.0
    lowest, highest = values[0, 0], values[0, 0]
    for k in range(1, count):
        lowest, highest = min(lowest, values[k, 0]), max(highest, values[k, 0])
    for k in range(2, count):
        pu, pv = float(u[k - 1] - u[0]), float(v[k - 1] - v[0])
        qu, qv = float(u[k] - u[0]), float(v[k] - v[0])
        ps, qs = values[k - 1, 0] - values[0, 0], values[k, 0] - values[0, 0]
        area = pu * qv - qu * pv
        if abs(area) > best:
            best = abs(area)
            s_u = SUBPIXELS * (ps * qv - qs * pv) / area
            s_v = SUBPIXELS * (pu * qs - qu * ps) / area
    return s_u, s_v, lowest, highest
