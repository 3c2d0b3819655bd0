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
from flag_sim.kernels import inner_kernel, kernel

import numpy as np

# Pixels in a vector of 256 bits, and the mask that rounds down to whole vectors.
LANES = 8
WHOLE = np.uint64(2 ** 64 - LANES)


@kernel
def span_linear(words, depths, first, count, least, most, s, ds, r, dr, g, dg, b, db):
    """
    Draw pixels first .. first + count - 1 where they are nearer than what is there.

    words: packed colours uint32, red lowest; depths: reversed Z float32; least, most: (4,) between
    which reversed Z, red, green and blue are held; s, r, g, b: the same at the first pixel, ds,
    dr, dg, db: their change a pixel, all float32.
    """
    s_least, r_least, g_least, b_least = least[0], least[1], least[2], least[3]
    s_most, r_most, g_most, b_most = most[0], most[1], most[2], most[3]
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = hold(s + ds * i, s_least, s_most)
        if i < end and here > depths[first + j]:
            depths[first + j] = here
            words[first + j] = pack(
                hold(r + dr * i, r_least, r_most), hold(g + dg * i, g_least, g_most),
                hold(b + db * i, b_least, b_most))


@kernel
def span_perspective_correct(words, depths, first, count, least, most,
                             s, ds, r, dr, g, dg, b, db):
    """Draw as span_linear, but colours come times reversed Z, 1 / depth (Heckbert, 1989)."""
    s_least, r_least, g_least, b_least = least[0], least[1], least[2], least[3]
    s_most, r_most, g_most, b_most = most[0], most[1], most[2], most[3]
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = hold(s + ds * i, s_least, s_most)
        if i < end and here > depths[first + j]:
            depths[first + j] = here
            depth = np.float32(1.0) / here
            words[first + j] = pack(
                hold((r + dr * i) * depth, r_least, r_most),
                hold((g + dg * i) * depth, g_least, g_most),
                hold((b + db * i) * depth, b_least, b_most))


@kernel
def empty(depths, first, count):
    """Take away what covers pixels first .. first + count - 1: then any span is nearer."""
    for j in range(count):
        depths[first + j] = -np.inf


@inner_kernel
def hold(value, least, most):
    """
    Return what lies nearest to `value` from `least` to `most`.

    Within a triangle no value leaves the range of its corners but by rounding; where it is so
    thin that it changes by thousands from pixel to pixel, that rounding is as large as it.
    """
    return min(max(value, least), most)


@inner_kernel
def pack(r, g, b):
    """Round colours within 0..255 to whole levels and put them in one word."""
    return _level(r) | (_level(g) << np.uint32(8)) | (_level(b) << np.uint32(16))


@inner_kernel
def _level(value):
    return np.uint32(np.int32(value + np.float32(0.5)))
