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
The innermost loops: one row of one triangle, pixel after pixel.

Values are affine in an unsigned index cast to float32: LLVM vectorises that, while a signed index
or a running sum keeps it scalar. Most spans of a fine mesh are shorter than a vector, so a span is
rounded up to whole vectors, and the lanes beyond its end are masked.
"""
from flag_sim.kernels import kernel

import numpy as np

# Pixels in a vector of 256 bits, and the mask that rounds down to whole vectors.
LANES = 8
WHOLE = np.uint64(2 ** 64 - LANES)


@kernel
def span_linear(words, depths, first, count, s, ds, r, dr, g, dg, b, db):
    """
    Draw pixels first .. first + count - 1 where they are nearer than what is there.

    words: packed colours uint32, red lowest; depths: reversed Z float32; s, r, g, b: reversed Z
    and colour at the first pixel, ds, dr, dg, db: their change a pixel, all float32.
    """
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = s + ds * i
        if i < end and here > depths[first + j]:
            depths[first + j] = here
            words[first + j] = pack(r + dr * i, g + dg * i, b + db * i)


@kernel
def span_perspective_correct(words, depths, first, count, s, ds, r, dr, g, dg, b, db):
    """Draw as span_linear, but colours come times reversed Z, 1 / depth (Heckbert, 1989)."""
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = s + ds * i
        if i < end and here > depths[first + j]:
            depths[first + j] = here
            depth = np.float32(1.0) / here
            words[first + j] = pack(
                (r + dr * i) * depth, (g + dg * i) * depth, (b + db * i) * depth)


@kernel
def empty(depths, first, count):
    """Take away what covers pixels first .. first + count - 1: then any span is nearer."""
    for j in range(count):
        depths[first + j] = -np.inf


@kernel
def pack(r, g, b):
    """Round colours to whole levels, hold them in 0..255 and put them in one word."""
    return _level(r) | (_level(g) << np.uint32(8)) | (_level(b) << np.uint32(16))


@kernel
def _level(value):
    return np.uint32(np.int32(
        min(max(value + np.float32(0.5), np.float32(0.0)), np.float32(255.0))))
