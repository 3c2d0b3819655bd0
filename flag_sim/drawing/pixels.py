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

"""Pixels side by side, and how their values are held and packed."""
from flag_sim.jit.kernels import inner_kernel

import numpy as np

# Pixels in a vector of 256 bits, and the mask that rounds down to whole vectors.
LANES = 8
WHOLE = np.uint64(2 ** 64 - LANES)


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
    """Round colours within 0..255 to whole levels and put them in one word, red lowest."""
    return _level(r) | (_level(g) << np.uint32(8)) | (_level(b) << np.uint32(16))


@inner_kernel
def _level(value):
    return np.uint32(np.int32(value + np.float32(0.5)))
