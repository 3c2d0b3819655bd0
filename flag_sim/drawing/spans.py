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
def span_linear(words, nearness, first, count, s, ds, r, dr, g, dg, b, db):
    """
    Draw pixels first .. first + count - 1 where they are nearer than what is there.

    words: packed colours uint32, red lowest; nearness: float32, greater is nearer; s, r, g, b:
    nearness and colour at the first pixel, ds, dr, dg, db: their change a pixel, all float32.
    """
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = s + ds * i
        if i < end and here > nearness[first + j]:
            nearness[first + j] = here
            words[first + j] = _pack(r + dr * i, g + dg * i, b + db * i)


@kernel
def span_correct(words, nearness, first, count, s, ds, r, dr, g, dg, b, db):
    """Draw as span_linear, but r, g, b are colour times s, s being 1 / depth (Heckbert, 1989)."""
    end = np.float32(np.int32(count))
    for j in range((count + np.uint64(LANES - 1)) & WHOLE):
        i = np.float32(np.int32(j))
        here = s + ds * i
        if i < end and here > nearness[first + j]:
            nearness[first + j] = here
            depth = np.float32(1.0) / here
            words[first + j] = _pack(
                (r + dr * i) * depth, (g + dg * i) * depth, (b + db * i) * depth)


@kernel
def _pack(r, g, b):
    """Round colours to whole levels, hold them in 0..255 and put them in one word."""
    return _level(r) | (_level(g) << np.uint32(8)) | (_level(b) << np.uint32(16))


@kernel
def _level(value):
    return np.uint32(np.int32(
        min(max(value + np.float32(0.5), np.float32(0.0)), np.float32(255.0))))


@kernel
def unpack(words, out, width, top, bottom, left, right):
    """
    Turn a rectangle's words of colour into red, green, blue bytes.

    words: (4 n,), out: (3 n,) uint32: four pixels fill three words. Rows top .. bottom - 1 and
    columns left .. right - 1 of an image of that width are written, and up to three pixels more
    at both ends of a row, so that whole groups of four are. The bytes are in order where the
    lowest byte of a word stands first, as on all machines that ROS 2 supports.
    """
    for row in range(top, bottom):
        begin = np.uint64((row * width + left) // 4)
        end = np.uint64((row * width + right + 3) // 4)
        for k in range(begin, end):
            p, q = np.uint64(4) * k, np.uint64(3) * k
            a, b = words[p], words[p + np.uint64(1)]
            c, d = words[p + np.uint64(2)], words[p + np.uint64(3)]
            out[q] = a | (b << np.uint32(24))
            out[q + np.uint64(1)] = (b >> np.uint32(8)) | (c << np.uint32(16))
            out[q + np.uint64(2)] = (c >> np.uint32(16)) | (d << np.uint32(8))
