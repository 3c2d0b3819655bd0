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

"""The pass over pixels of a row that takes the sun's light from those that are in its shadow."""
from flag_sim.drawing.surfaces import BIAS, SEGMENT, Z_DU, Z_DV
from flag_sim.drawing.visibility import triangle_of
from flag_sim.jit.kernels import wide_kernel

import numpy as np

# Of pixels: the sun's light and the mirrored sun; where in the shadow map, and how deep, less the
# bias.
SUNLIGHT, ADDED, AT_U, AT_V, AT_Z = (np.uint64(k * SEGMENT) for k in range(5))


@wide_kernel
def place_in_map(row, depth, faces, is_perspective, pixels, surfaces):
    """Write AT_U, AT_V and AT_Z of pixels."""
    begin, count, place = row
    fields, shadows = surfaces.fields, surfaces.shadows
    column, v = place
    one, rounding = np.float32(1.0), np.float32(shadows.rounding)
    (u_0, u_u, u_v, u_z, u_1), (v_0, v_u, v_v, v_z, v_1), (z_0, z_u, z_v, z_z, z_1) = shadows.ways
    for i in range(count):
        u = column + np.float32(np.int32(i))
        t, s = triangle_of(faces[begin + i]), depth[begin + i]
        z = one / s if is_perspective else -s
        scale = z if is_perspective else one
        bias = fields[BIAS, t] + fields[BIAS + 1, t] * u + fields[BIAS + 2, t] * v
        pixels[AT_U + i] = scale * (u_0 + u_u * u + u_v * v) + (u_z * z + u_1)
        pixels[AT_V + i] = scale * (v_0 + v_u * u + v_v * v) + (v_z * z + v_1)
        pixels[AT_Z + i] = (scale * (z_0 + z_u * u + z_v * v - bias)
                            + (z_z * z + z_1 - rounding))


@wide_kernel
def shade_by_map(row, faces, fields, pixels, depth):
    """
    Take from the sun's light of pixels what they have not in its shadow.

    row: the first pixel in `faces`, their number and place; fields: see surfaces; pixels: see
    pixel_pass; depth: the map. The share of the light is an average over 3 x 3 texels about the
    place: over 4 x 4 texels' centres, of which the outer ones count by how much of them is within.
    """
    begin, count, _ = row
    height, width = depth.shape
    one, zero = np.float32(1.0), np.float32(0.0)
    # Where there is no number, the comparisons make 1.
    last_u, last_v = np.float32(width - 3), np.float32(height - 3)
    for i in range(count):
        t = triangle_of(faces[begin + i])
        u, v, z = pixels[AT_U + i], pixels[AT_V + i], pixels[AT_Z + i]
        du, dv = fields[Z_DU, t], fields[Z_DV, t]
        u = min(u, last_u) if u > one else one
        v = min(v, last_v) if v > one else one
        column, line = np.int32(u), np.int32(v)
        right, down = u - np.float32(column), v - np.float32(line)
        share = zero
        for down_by in range(4):
            of_row = zero
            for right_by in range(4):
                z_here = (z + du * (np.float32(right_by - 1) - right)
                          + dv * (np.float32(down_by - 1) - down))
                is_lit = depth[np.uint32(line + down_by - 1),
                               np.uint32(column + right_by - 1)] >= z_here
                weight = (one - right if right_by == 0 else right if right_by == 3 else one)
                of_row += weight if is_lit else zero
            share += of_row * (one - down if down_by == 0 else down if down_by == 3 else one)
        share *= np.float32(1.0 / 9.0)
        pixels[SUNLIGHT + i] *= share
        pixels[ADDED + i] *= share
