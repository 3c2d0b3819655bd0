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

"""The pass over pixels of a row that looks their colours up in a texture, in three steps."""
from flag_sim.drawing.surfaces import S_DU, S_DV, SEGMENT, X, Y
from flag_sim.drawing.texture import bilinear, encode, log2, STEPS
from flag_sim.drawing.visibility import triangle_of
from flag_sim.jit.kernels import late_kernel, wide_kernel

import numpy as np

# Of pixels: the colour that light is multiplied to; where in the texture, in which mipmap; and
# red, green and blue in linear light.
RED, GREEN, BLUE, AT_X, AT_Y, LOD, LINEAR_RED, LINEAR_GREEN, LINEAR_BLUE = (
    np.uint64(k * SEGMENT) for k in range(5, 14))


@late_kernel
def shade_by_texture(row, depth, faces, is_perspective, pixels, surfaces, k):
    """
    Write RED to BLUE of pixels that see object k, which has a texture; see texture.ENCODE.

    row: the first pixel in `depth` and `faces`, their number and place.
    """
    first = surfaces.textures[k, 0]
    size = (np.int32(surfaces.levels[first, 1]), np.int32(surfaces.levels[first, 2]),
            np.int32(surfaces.textures[k, 1] - 1))
    if _place(row, depth, faces, is_perspective, pixels, surfaces, (np.int32(k), size)) > 0:
        _fetch(row[1], pixels, surfaces.texels, surfaces.starts[first:], size)
        _encode(row, faces, pixels, surfaces.object_of, np.int32(k), surfaces.encode)


@wide_kernel
def _place(row, depth, faces, is_perspective, pixels, surfaces, texture):
    """Write AT_X, AT_Y and LOD of pixels; return how many see the object."""
    begin, count, place = row
    k, (width, height, last) = texture
    fields, object_of = surfaces.fields, surfaces.object_of
    wide, high, last = np.float32(width), np.float32(height), np.float32(last)
    column, v = place
    half, one, zero = np.float32(0.5), np.float32(1.0), np.float32(0.0)
    seen = np.int32(0)
    for i in range(count):
        u = column + np.float32(np.int32(i))
        t = triangle_of(faces[begin + i])
        z = one / depth[begin + i] if is_perspective else one
        of_u, of_v = fields[X + 1, t], fields[X + 2, t]
        x = z * (fields[X, t] + of_u * u + of_v * v)
        # With x / z and 1 / z linear on the screen, the change of x is that of x / z, minus x
        # times that of 1 / z, times z.
        s_du, s_dv = fields[S_DU, t], fields[S_DV, t]
        x_du, x_dv = wide * (of_u - x * s_du), wide * (of_v - x * s_dv)
        of_u, of_v = fields[Y + 1, t], fields[Y + 2, t]
        y = z * (fields[Y, t] + of_u * u + of_v * v)
        y_du, y_dv = high * (of_u - y * s_du), high * (of_v - y * s_dv)
        # How many texels a pixel is wide where it is wider, squared.
        square = max(x_du * x_du + y_du * y_du, x_dv * x_dv + y_dv * y_dv) * (z * z)
        # Of what is no number, here and below, the comparisons make a limit.
        lod = half * log2(square) if square > one else zero
        pixels[LOD + i] = lod if lod < last else last
        pixels[AT_X + i] = min(x, one) if x > zero else zero
        pixels[AT_Y + i] = min(y, one) if y > zero else zero
        seen += np.int32(1) if object_of[t] == k else np.int32(0)
    return seen


@wide_kernel
def _fetch(count, pixels, texels, starts, size):
    """Write LINEAR_RED to LINEAR_BLUE of pixels: between texels, and between two mipmaps."""
    width, height, last = size
    one, scale = np.int32(1), np.float32(1.0 / STEPS)
    for i in range(count):
        x, y, lod = pixels[AT_X + i], pixels[AT_Y + i], pixels[LOD + i]
        level = np.int32(lod)
        after = min(np.int32(level + one), last)
        share = lod - np.float32(level)
        red, green, blue = bilinear(
            texels, starts[np.uint32(level)], max(width >> level, one), max(height >> level, one),
            (x, y))
        next_red, next_green, next_blue = bilinear(
            texels, starts[np.uint32(after)], max(width >> after, one), max(height >> after, one),
            (x, y))
        pixels[LINEAR_RED + i] = (red + share * (next_red - red)) * scale
        pixels[LINEAR_GREEN + i] = (green + share * (next_green - green)) * scale
        pixels[LINEAR_BLUE + i] = (blue + share * (next_blue - blue)) * scale


@wide_kernel
def _encode(row, faces, pixels, object_of, k, table):
    begin, count, _ = row
    for i in range(count):
        is_own = object_of[triangle_of(faces[begin + i])] == k
        red, green = encode(pixels[LINEAR_RED + i], table), encode(pixels[LINEAR_GREEN + i], table)
        blue = encode(pixels[LINEAR_BLUE + i], table)
        pixels[RED + i] = red if is_own else pixels[RED + i]
        pixels[GREEN + i] = green if is_own else pixels[GREEN + i]
        pixels[BLUE + i] = blue if is_own else pixels[BLUE + i]
