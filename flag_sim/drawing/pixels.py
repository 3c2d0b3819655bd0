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

"""Pixels in a row: vectors of them, regions of a buffer, and how a colour is packed."""
from typing import NamedTuple

from flag_sim.jit.kernels import late_inner_kernel

import numpy as np

# Rows of a band: what a thread draws at a time.
BAND = 32
# Pixels in a vector of 256 bits, and the mask that rounds a number down to whole vectors.
LANES = 8
WHOLE_VECTORS = np.uint64(2 ** 64 - LANES)
# By this LLVM knows that an index of 32 bits is not negative, so that it can fetch a vector of
# elements with a vector of 32-bit indices: twice as many at a time as with 64 bits.
POSITIVE = np.uint32(2 ** 31 - 1)


class Region(NamedTuple):
    """
    Pixels of a band: columns left .. right - 1 of `rows` rows from row `first` of its buffers on.

    Buffers have `stride` pixels a row; their row 0 is row `top` of the image.
    """

    top: int
    first: int
    rows: int
    left: int
    right: int
    stride: int


@late_inner_kernel
def clamp(value, least, most):
    """
    Return `value`, or `least` or `most` if it lies beyond them.

    Within a triangle no value leaves the range of its corners but by rounding; where the triangle
    is so thin that the value changes by thousands from pixel to pixel, rounding is as large.
    """
    return min(max(value, least), most)


@late_inner_kernel
def pack_rgb(red, green, blue):
    """Round channels within 0..255 to whole levels and pack them in a uint32, red lowest."""
    return _level(red) | (_level(green) << np.uint32(8)) | (_level(blue) << np.uint32(16))


@late_inner_kernel
def _level(value):
    return np.uint32(np.int32(value + np.float32(0.5)))
