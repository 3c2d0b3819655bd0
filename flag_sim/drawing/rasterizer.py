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
The rasterizer: triangles in, pixels of a band out.

It decides which triangle covers a pixel (see coverage) and which of those is the nearest (see
depth). LARGE triangles are drawn one by one (see scanline), the others in batches (see batched).

Colours are interpolated in the depth loop. Deferring them to a primitive-ID pass was 1.2-1.5 times
slower: a flag has little overdraw. Pixels store the ID of the primitive that they see only where
other attributes are asked for (see visibility).
"""
from typing import NamedTuple

from flag_sim.drawing.batched import draw_batch
from flag_sim.drawing.clipping import INSIDE, MAX_CORNERS
from flag_sim.drawing.culling import LARGE
from flag_sim.drawing.outline import draw_outline
from flag_sim.drawing.polygon import assemble_polygon
from flag_sim.drawing.scanline import draw_large
from flag_sim.drawing.triangle_setup import BATCH
from flag_sim.drawing.visibility import Primitives
from flag_sim.jit.kernels import late_kernel

import numpy as np


class Colours(NamedTuple):
    """Colours 0..255 of both sides: values (n, 2, 3) at vertices, or of triangles if is_flat."""

    values: np.ndarray
    is_flat: bool


class RasterizerState(NamedTuple):
    """
    How triangles are drawn.

    shift_u, shift_v: int32, sample offset from the pixel centre [subpixel]; depth_ceiling: float32
    in reversed Z, stored depth is clamped to this before the test: inf changes nothing, -inf lets
    every triangle overwrite (painter); is_outlined: whether their
    edges are drawn too; is_perspective_correct: whether colours are interpolated linearly in
    space, else linearly on the screen.
    """

    shift_u: int
    shift_v: int
    depth_ceiling: float
    is_outlined: bool
    is_perspective_correct: bool


class Target(NamedTuple):
    """
    What is drawn into: rows top .. end - 1 of an image that is `width` pixels wide.

    colour: the colour buffer, uint32, see pack_rgb; depth: the depth buffer, float32, see depth;
    primitive_ids: uint32, of size 0 if they are not wanted; all flat, `stride` pixels a row, a
    multiple of LANES; primitives: see visibility.
    """

    colour: np.ndarray
    depth: np.ndarray
    primitive_ids: np.ndarray
    primitives: Primitives
    top: int
    end: int
    width: int
    stride: int


@late_kernel
def rasterize(geometry, colours, indices, state, target, batch, polygon, rare):
    """
    Draw the triangles with `indices`, none of which may have an INVALID vertex.

    batch, polygon: scratch memory. rare: None if there are neither outlines nor IDs, else True.
    Primitives get IDs from 1 on (see max_primitive_ids); returns the first one that is free.
    """
    sizes, count = geometry.sizes, np.uint64(indices.size)
    next_id, k = np.int64(1), np.uint64(0)
    while k < count:
        first, size = k, sizes[indices[k]]
        if size != LARGE and not state.is_outlined:
            while k < count and k - first < BATCH and sizes[indices[k]] == size:
                k += np.uint64(1)
            next_id = draw_batch(geometry, colours, indices[np.int64(first):np.int64(k)], state,
                                 next_id, target, batch, rare)
            continue
        triangle = np.int64(indices[k])
        k += np.uint64(1)
        corners, side = assemble_polygon(geometry, colours, triangle, state, polygon)
        face = 2 * triangle + side
        for corner in range(2, corners):
            if draw_large(polygon, corner, face, state, next_id, target, rare):
                next_id += 1
        if rare is not None:
            if state.is_outlined and corners > 0:
                draw_outline(polygon, corners, state, next_id - 1, target)
    return next_id


def max_primitive_ids(geometry) -> int:
    """Return an upper bound on the IDs of a Geometry's primitives, allowing for clipping."""
    outcodes = geometry.vertices.outcodes[geometry.triangles]
    clipped = np.count_nonzero((outcodes != INSIDE).any(axis=1))
    return 1 + len(geometry.triangles) + (MAX_CORNERS - 3) * clipped
