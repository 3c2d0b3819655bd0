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
triangles cover earlier ones instead. Red, green and blue go with the depth, span by span, and
pixels keep which triangle they see where other attributes are asked for (see attributes): to
resolve the colours from triangles, too, took 1.2 to 1.5 times as long for the whole frame, for
hardly a pixel of a flag is hidden, and its colour is three sums.
"""
from typing import NamedTuple

from flag_sim.drawing.attributes import Slots
from flag_sim.drawing.batched import BATCH
from flag_sim.drawing.blocks import draw_batch
from flag_sim.drawing.clipping import INSIDE, MOST_CORNERS
from flag_sim.drawing.culling import LARGE
from flag_sim.drawing.large import cut_out, draw_large
from flag_sim.drawing.outline import draw_outline
from flag_sim.jit.kernels import kernel

import numpy as np


class Colours(NamedTuple):
    """Colours 0..255 of both sides: values (n, 2, 3) at vertices, or of triangles if is_flat."""

    values: np.ndarray
    is_flat: bool


class Pass(NamedTuple):
    """
    How triangles are drawn.

    shift_u, shift_v: where in the pixel its sample lies, from the centre (int32) [subpixel];
    ceiling: what is there counts as no nearer than this float32 in reversed Z: inf, or -inf for
    the painter, whose triangles cover whatever is there; is_outlined: draw their edges, too;
    is_perspective_correct: how colours are interpolated, else linearly on the screen.
    """

    shift_u: int
    shift_v: int
    ceiling: float
    is_outlined: bool
    is_perspective_correct: bool


class Target(NamedTuple):
    """
    What is drawn into: rows top .. end - 1 of an image, `width` pixels wide.

    words: colours, red lowest, uint32, depths: reversed Z float32, and numbers: of slots uint32,
    of size 0 if they are not wanted; flat, `stride` pixels a row, a multiple of LANES; slots: see
    attributes.
    """

    words: np.ndarray
    depths: np.ndarray
    numbers: np.ndarray
    slots: Slots
    top: int
    end: int
    width: int
    stride: int


@kernel
def rasterize(geometry, colours, numbers, how, target, batch, polygon):
    """
    Draw the triangles with `numbers`, none of which may have an INVALID vertex.

    batch, polygon: for the work in between. Slots are taken from 1 on (see slots_for).
    """
    sizes, count = geometry.sizes, np.uint64(numbers.size)
    slot, k = np.int64(1), np.uint64(0)
    while k < count:
        first, size = k, sizes[numbers[k]]
        if size != LARGE and not how.is_outlined:
            while k < count and k - first < BATCH and sizes[numbers[k]] == size:
                k += np.uint64(1)
            slot = draw_batch(geometry, colours, numbers[np.int64(first):np.int64(k)], how, slot,
                              target, batch)
            continue
        triangle = np.int64(numbers[k])
        k += np.uint64(1)
        corners, side = cut_out(geometry, colours, triangle, how, polygon)
        face = 2 * triangle + side
        for corner in range(2, corners):
            if draw_large(polygon, corner, face, how, slot, target):
                slot += 1
        if how.is_outlined and corners > 0:
            draw_outline(polygon, corners, how, slot - 1, target)


def slots_for(geometry) -> int:
    """Return how many slots a Geometry's triangles take at most, some of which are clipped."""
    states = geometry.vertices.outcodes[geometry.triangles]
    clipped = np.count_nonzero((states != INSIDE).any(axis=1))
    return 1 + len(geometry.triangles) + (MOST_CORNERS - 3) * clipped
