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
from flag_sim.drawing.spans import pack
from flag_sim.drawing.tiles import TILE
from flag_sim.kernels import kernel

import numpy as np

# The source darkens by 120 %, which is a division by 1.2.
DARKER = 1.2
# A line lies before what is nearer by no more than this share: rounding in float32, and the
# neighbour's plane where the cloth is nearly flat.
BEFORE = 1e-4


@kernel
def draw_outline(corners, count, is_perspective_correct, is_painter, marks,
                 top, end, width, stride, depths, words):
    """Draw the edges of the polygon corners[1, :count]: u, v, reversed Z, red, green, blue."""
    for k in range(count):
        k_next = k + 1 if k + 1 < count else 0
        _draw_edge(corners, k, k_next, count, is_perspective_correct, is_painter, marks,
                   top, end, width, stride, depths, words)


@kernel
def _draw_edge(corners, a, b, count, is_perspective_correct, is_painter, marks,
               top, end, width, stride, depths, words):
    # Both triangles of an edge draw it in the same direction, into the same pixels.
    if (corners[1, b, 0], corners[1, b, 1]) < (corners[1, a, 0], corners[1, a, 1]):
        a, b = b, a
    au, av = int(np.floor(corners[1, a, 0] + 0.5)), int(np.floor(corners[1, a, 1] + 0.5))
    bu, bv = int(np.floor(corners[1, b, 0] + 0.5)), int(np.floor(corners[1, b, 1] + 0.5))
    s_u, s_v = _slopes(corners, count)
    lowest, highest = corners[1, 0, 2], corners[1, 0, 2]
    for k in range(1, count):
        lowest, highest = min(lowest, corners[1, k, 2]), max(highest, corners[1, k, 2])
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
        u, v = (other, start + i * way) if is_steep else (start + i * way, other)
        if u < 0 or u >= width or v < top or v >= end:
            continue
        if marks.size > 0 and not marks[(v - top) // TILE, u // TILE]:
            continue
        s = corners[1, a, 2] + s_u * (u - corners[1, a, 0]) + s_v * (v - corners[1, a, 1])
        s = min(max(s, lowest), highest)
        pixel = (v - top) * stride + u
        there = depths[pixel]
        if is_painter or s + BEFORE * abs(s) >= there:
            along = i / max(length, 1)
            # Perspective-correct colours come multiplied by 1 / z.
            divisor = DARKER
            if is_perspective_correct:
                divisor *= corners[1, a, 2] + along * (corners[1, b, 2] - corners[1, a, 2])
            depths[pixel] = np.float32(s) if is_painter else max(np.float32(s), there)
            words[pixel] = pack(
                _between(corners, a, b, 3, along, divisor),
                _between(corners, a, b, 4, along, divisor),
                _between(corners, a, b, 5, along, divisor))


@kernel
def _between(corners, a, b, channel, along, divisor):
    value = corners[1, a, channel] + along * (corners[1, b, channel] - corners[1, a, channel])
    return np.float32(value / divisor)


@kernel
def _slopes(corners, count):
    """Return the slopes of reversed Z along u and v, from the polygon's widest fan triangle."""
    best, s_u, s_v = 0.0, 0.0, 0.0
    for k in range(2, count):
        pu, pv = corners[1, k - 1, 0] - corners[1, 0, 0], corners[1, k - 1, 1] - corners[1, 0, 1]
        qu, qv = corners[1, k, 0] - corners[1, 0, 0], corners[1, k, 1] - corners[1, 0, 1]
        ps, qs = corners[1, k - 1, 2] - corners[1, 0, 2], corners[1, k, 2] - corners[1, 0, 2]
        area = pu * qv - qu * pv
        if abs(area) > best:
            best = abs(area)
            s_u, s_v = (ps * qv - qs * pv) / area, (pu * qs - qu * ps) / area
    return s_u, s_v
