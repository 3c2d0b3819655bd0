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
Depth: reversed Z, the depth test, and the way back to metres.

The depth buffer holds reversed Z as float32: s = 1 / z in perspective and s = -z in orthographic
projection, where z is the depth along the optical axis [m]. Greater is nearer. Both are affine on
the screen along any plane, so they are interpolated exactly, and 1 / z uses float32 where it is
finest: it tells surfaces apart that a conventional Z-buffer confuses (Lapidous and Jiao, 1999).
"""
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np


def clear_depth(is_perspective: bool) -> np.float32:
    """Return the reversed Z of what is infinitely far away: nothing is drawn there yet."""
    return np.float32(0.0 if is_perspective else -np.inf)


@late_inner_kernel
def to_reversed_z(z, is_perspective):
    """Return the reversed Z of a point at depth z [m]."""
    return 1.0 / z if is_perspective else -z


@late_inner_kernel
def is_nearer(s, stored):
    """
    Whether a fragment of reversed Z `s` hides what the depth buffer has stored.

    The painter's algorithm, whose later triangles hide all earlier ones, passes -inf as `stored`
    (see RasterizerState.depth_ceiling).
    """
    return s > stored


@late_kernel
def write_depth(depth, region, is_perspective, image):
    """Write the depth buffer of a Region into an image (height, width) of metres."""
    top, begin, rows, left, right, stride = region
    for row in range(begin, begin + rows):
        source, target = np.uint64(row * stride), np.uint64(top + row)
        if is_perspective:
            for i in range(np.uint64(left), np.uint64(right)):
                image[target, i] = np.float32(1.0) / depth[source + i]
        else:
            for i in range(np.uint64(left), np.uint64(right)):
                image[target, i] = -depth[source + i]
