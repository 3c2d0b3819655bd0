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

"""The pass over pixels of a segment that takes the sun's light from those in its shadow."""
from flag_sim.drawing.pixels import POSITIVE
from flag_sim.drawing.segment import ADDED, AT_U, AT_V, AT_Z, COLUMN, DEPTH, ROW, SUNLIGHT
from flag_sim.drawing.surfaces import BIAS, Z_DU, Z_DV
from flag_sim.drawing.visibility import triangle_of
from flag_sim.jit.kernels import wide_kernel

import numpy as np


@wide_kernel
def place_in_map(pixels, faces, is_perspective, fields, planes, shadows):
    """Write AT_U, AT_V and AT_Z of pixels; planes: see Surfaces.fields."""
    begin, first, end = pixels
    one, rounding = np.float32(1.0), np.float32(shadows.rounding)
    (u_0, u_u, u_v, u_z, u_1), (v_0, v_u, v_v, v_z, v_1), (z_0, z_u, z_v, z_z, z_1) = shadows.ways
    for i in range(first, end):
        u, v, z = fields[COLUMN + i], fields[ROW + i], fields[DEPTH + i]
        t = triangle_of(faces[begin + i])
        scale = z if is_perspective else one
        bias = planes[BIAS, t] + planes[BIAS + 1, t] * u + planes[BIAS + 2, t] * v
        fields[AT_U + i] = scale * (u_0 + u_u * u + u_v * v) + (u_z * z + u_1)
        fields[AT_V + i] = scale * (v_0 + v_u * u + v_v * v) + (v_z * z + v_1)
        fields[AT_Z + i] = (scale * (z_0 + z_u * u + z_v * v - bias)
                            + (z_z * z + z_1 - rounding))


@wide_kernel
def shade_by_map(pixels, faces, fields, planes, depth):
    """
    Take from the sun's light of pixels what they have not in its shadow.

    pixels: see pixel_pass; planes: see Surfaces.fields; depth: the map. The share of the light is
    an average over 3 x 3 texels about the place: over 4 x 4 texels' centres, of which the outer
    ones count by how much of them is within.
    """
    begin, first, end = pixels
    height, width = depth.shape
    texels, stride = depth.reshape(-1), np.int32(width)
    one, zero = np.float32(1.0), np.float32(0.0)
    # Where there is no number, the comparisons make 1.
    last_u, last_v = np.float32(width - 3), np.float32(height - 3)
    for i in range(first, end):
        t = triangle_of(faces[begin + i])
        u, v, z = fields[AT_U + i], fields[AT_V + i], fields[AT_Z + i]
        du, dv = planes[Z_DU, t], planes[Z_DV, t]
        u = min(u, last_u) if u > one else one
        v = min(v, last_v) if v > one else one
        column, line = np.int32(u), np.int32(v)
        right, down = u - np.float32(column), v - np.float32(line)
        corner = np.int32(np.int32(np.int32(line - np.int32(1)) * stride)
                          + np.int32(column - np.int32(1)))
        share = zero
        for down_by in range(4):
            of_row = zero
            for right_by in range(4):
                # Reversed Z, as the map has it.
                z_here = -(z + du * (np.float32(right_by - 1) - right)
                           + dv * (np.float32(down_by - 1) - down))
                place = np.int32(corner + np.int32(right_by))
                is_lit = texels[np.uint32(place) & POSITIVE] <= z_here
                weight = (one - right if right_by == 0 else right if right_by == 3 else one)
                of_row += weight if is_lit else zero
            corner = np.int32(corner + stride)
            share += of_row * (one - down if down_by == 0 else down if down_by == 3 else one)
        share *= np.float32(1.0 / 9.0)
        fields[SUNLIGHT + i] *= share
        fields[ADDED + i] *= share
