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
Visibility: which triangle each pixel sees, and how deep it is.

Hidden surfaces are removed by a Z-buffer of float32 in reversed Z, where greater is nearer,
cleared to 0 in perspective and to -inf in orthographic projection. In painter's algorithm later
triangles cover earlier ones instead. What a pixel shows is not known here: it keeps the number of
a slot, whose planes (see attributes) are written when its triangle is drawn.
"""
from typing import NamedTuple

from flag_sim.drawing.batched import BATCH, draw_batch
from flag_sim.drawing.clipping import MOST_CORNERS
from flag_sim.drawing.culling import LARGE
from flag_sim.drawing.large import cut_out, draw_large
from flag_sim.drawing.outline import draw_outline
from flag_sim.kernels import kernel

import numpy as np


class Pass(NamedTuple):
    """
    How triangles are drawn.

    shift_u, shift_v: where in the pixel its sample lies, from the centre (int32) [subpixel];
    ceiling: what is drawn counts as no nearer than this float32 in reversed Z: inf, or -inf for the
    painter, whose triangles cover whatever is there; is_outlined: draw their edges, too; groups:
    so many groups of attributes are wanted.
    """

    shift_u: int
    shift_v: int
    ceiling: float
    is_outlined: bool
    groups: int


class Target(NamedTuple):
    """
    What is drawn into: rows top .. end - 1 of an image, `width` pixels wide.

    depths: reversed Z float32, slots: uint32, flat, `stride` pixels a row, a multiple of LANES.
    """

    depths: np.ndarray
    slots: np.ndarray
    top: int
    end: int
    width: int
    stride: int


@kernel
def rasterize(geometry, numbers, how, values, table, target, batch, polygon):
    """
    Draw the triangles with `numbers`, none of which may have an INVALID vertex.

    table: planes of attributes, PLANE groups for each slot (see slots_for); batch, polygon: for
    the work in between.
    """
    sizes, count = geometry.sizes, np.uint64(numbers.size)
    slot, k = np.int64(1), np.uint64(0)
    while k < count:
        first, size = k, sizes[numbers[k]]
        if size != LARGE and not how.is_outlined:
            while k < count and k - first < BATCH and sizes[numbers[k]] == size:
                k += np.uint64(1)
            slot = draw_batch(geometry, numbers[np.int64(first):np.int64(k)], how, values, table, slot, target, batch)
            continue
        triangle = np.uint64(numbers[k])
        k += np.uint64(1)
        corners, side = cut_out(geometry, triangle, how, polygon)
        triangles = geometry.triangles
        source = (np.uint64(triangles[triangle, 0]), np.uint64(triangles[triangle, 1]),
                  np.uint64(triangles[triangle, 2]), triangle, np.uint64(side))
        before = slot
        for corner in range(2, corners):
            if draw_large(polygon, corner, source, how, values, table, slot, target):
                slot += 1
        if how.is_outlined and slot > before:
            slot = draw_outline(polygon, corners, how, table, slot, target)


def slots_for(triangles: int, clipped: int, is_outlined: bool) -> int:
    """Return how many slots so many triangles take at most, of which some are clipped."""
    pieces = triangles + (MOST_CORNERS - 3) * clipped
    return 1 + (2 if is_outlined else 1) * pieces
