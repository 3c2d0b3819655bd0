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

"""The pass over pixels of a segment that looks their colours up in a texture, step by step."""
from flag_sim.drawing.flat_tiles import NOT_FLAT, SHIFT, SIDE
from flag_sim.drawing.pixels import POSITIVE
from flag_sim.drawing.segment import (
    AT_X, AT_Y, BLUE, COLUMN, DEPTH, GREEN, IS_OPEN, LINEAR_BLUE, LINEAR_GREEN, LINEAR_RED, LOD,
    RED, ROW)
from flag_sim.drawing.surfaces import S_DU, S_DV, X, Y
from flag_sim.drawing.texture import bilinear, encode, half_to_the, log2, SCALE
from flag_sim.drawing.visibility import triangle_of
from flag_sim.jit.kernels import late_kernel, wide_kernel

import numpy as np


@late_kernel
def shade_by_texture(pixels, faces, is_perspective, segment, surfaces, k):
    """
    Write RED to BLUE of pixels that see object k, which has a texture; see texture.ENCODE.

    pixels: see pixel_pass.
    """
    first = surfaces.textures[k, 0]
    size = (np.float32(surfaces.levels[first, 1]), np.float32(surfaces.levels[first, 2]),
            np.int32(surfaces.textures[k, 1] - 1))
    _place(pixels, faces, is_perspective, segment.fields, surfaces.fields, size)
    flats = surfaces.flats[surfaces.textures[k, 2]:surfaces.textures[k, 3]]
    _find_flat(pixels, segment, np.int32(k), flats, surfaces.flat_starts[first:], size)
    count = _gather_rest(pixels, segment)
    _fetch(count, segment.fields, surfaces.texels, surfaces.starts[first:], size)
    _encode(count, segment.fields, surfaces.encode)
    _put_back(count, segment)


@wide_kernel
def _place(pixels, faces, is_perspective, fields, planes, size):
    """Write AT_X, AT_Y and LOD of pixels."""
    begin, first, end = pixels
    width, height, last = size
    last = np.float32(last)
    half, one, zero = np.float32(0.5), np.float32(1.0), np.float32(0.0)
    for i in range(first, end):
        u, v = fields[COLUMN + i], fields[ROW + i]
        t = triangle_of(faces[begin + i])
        z = fields[DEPTH + i] if is_perspective else one
        of_u, of_v = planes[X + 1, t], planes[X + 2, t]
        x = z * (planes[X, t] + of_u * u + of_v * v)
        # With x / z and 1 / z linear on the screen, the change of x is that of x / z, minus x
        # times that of 1 / z, times z.
        s_du, s_dv = planes[S_DU, t], planes[S_DV, t]
        x_du, x_dv = width * (of_u - x * s_du), width * (of_v - x * s_dv)
        of_u, of_v = planes[Y + 1, t], planes[Y + 2, t]
        y = z * (planes[Y, t] + of_u * u + of_v * v)
        y_du, y_dv = height * (of_u - y * s_du), height * (of_v - y * s_dv)
        # How many texels a pixel is wide where it is wider, squared.
        square = max(x_du * x_du + y_du * y_du, x_dv * x_dv + y_dv * y_dv) * (z * z)
        # Of what is no number, here and below, the comparisons make a limit.
        lod = half * log2(square) if square > one else zero
        fields[LOD + i] = lod if lod < last else last
        fields[AT_X + i] = min(x, one) if x > zero else zero
        fields[AT_Y + i] = min(y, one) if y > zero else zero


@wide_kernel
def _find_flat(pixels, segment, k, flats, starts, size):
    """
    Write RED to BLUE of pixels in flat tiles, and where texels are to be looked up, in IS_OPEN.

    flats: of the texture; starts: where the tiles of its mipmaps begin; both see flat_tiles.
    """
    _, first, end = pixels
    width, height, _ = size
    fields, owners = segment.fields, segment.owners
    half, one, zero = np.float32(0.5), np.float32(1.0), np.float32(0.0)
    if flats.size == 0:
        for i in range(first, end):
            fields[IS_OPEN + i] = one if owners[i] == k else zero
        return
    shift, least, padding = np.int32(SHIFT), np.int32(1), np.int32(SIDE + 1)
    for i in range(first, end):
        level = np.int32(fields[LOD + i])
        scale = half_to_the(level)
        wide, high = max(np.int32(width * scale), least), max(np.int32(height * scale), least)
        # As in bilinear.
        column = np.int32(fields[AT_X + i] * np.float32(wide) + half)
        row = np.int32(fields[AT_Y + i] * np.float32(high) + half)
        stride = np.int32(np.int32(wide + padding) >> shift)
        tile = np.int32(np.int32(starts[np.uint32(level) & POSITIVE]
                                 + np.int32(np.int32(row >> shift) * stride))
                        + np.int32(column >> shift))
        flat = flats[np.uint32(tile) & POSITIVE]
        is_own, is_flat = owners[i] == k, flat != NOT_FLAT
        fields[IS_OPEN + i] = one if is_own and not is_flat else zero
        red, green = flat & np.uint32(255), (flat >> np.uint32(8)) & np.uint32(255)
        blue = (flat >> np.uint32(16)) & np.uint32(255)
        is_written = is_own and is_flat
        fields[RED + i] = np.float32(np.int32(red)) if is_written else fields[RED + i]
        fields[GREEN + i] = np.float32(np.int32(green)) if is_written else fields[GREEN + i]
        fields[BLUE + i] = np.float32(np.int32(blue)) if is_written else fields[BLUE + i]


@late_kernel
def _gather_rest(pixels, segment):
    """Move the places of pixels with IS_OPEN to the segment's begin; return how many they are."""
    _, first, end = pixels
    fields, rest = segment.fields, segment.rest
    count = np.uint64(0)
    for i in range(first, end):
        # Always written, kept if it counts: a branch would be mispredicted too often.
        rest[count] = i
        fields[AT_X + count], fields[AT_Y + count] = fields[AT_X + i], fields[AT_Y + i]
        fields[LOD + count] = fields[LOD + i]
        count += np.uint64(fields[IS_OPEN + i] > np.float32(0.0))
    return count


@wide_kernel
def _fetch(count, fields, texels, starts, size):
    """Write LINEAR_RED to LINEAR_BLUE of gathered pixels: between texels, and two mipmaps."""
    width, height, last = size
    one, half, scale = np.int32(1), np.float32(0.5), np.float32(SCALE)
    for i in range(count):
        place, lod = (fields[AT_X + i], fields[AT_Y + i]), fields[LOD + i]
        level = np.int32(lod)
        after = min(np.int32(level + one), last)
        share = lod - np.float32(level)
        # A mipmap's sides are half of those before, rounded down, but no less than 1.
        wide, high = width * half_to_the(level), height * half_to_the(level)
        red, green, blue = bilinear(
            texels, starts[np.uint32(level) & POSITIVE],
            (max(np.int32(wide), one), max(np.int32(high), one)), place)
        next_red, next_green, next_blue = bilinear(
            texels, starts[np.uint32(after) & POSITIVE],
            (max(np.int32(half * wide), one), max(np.int32(half * high), one)), place)
        fields[LINEAR_RED + i] = (red + share * (next_red - red)) * scale
        fields[LINEAR_GREEN + i] = (green + share * (next_green - green)) * scale
        fields[LINEAR_BLUE + i] = (blue + share * (next_blue - blue)) * scale


@wide_kernel
def _encode(count, fields, table):
    """Write the encoded levels of gathered pixels over their light."""
    for i in range(count):
        fields[LINEAR_RED + i] = encode(fields[LINEAR_RED + i], table)
        fields[LINEAR_GREEN + i] = encode(fields[LINEAR_GREEN + i], table)
        fields[LINEAR_BLUE + i] = encode(fields[LINEAR_BLUE + i], table)


@late_kernel
def _put_back(count, segment):
    """Write RED to BLUE of gathered pixels where they belong."""
    fields, rest = segment.fields, segment.rest
    for i in range(count):
        own = np.uint64(rest[i])
        fields[RED + own] = fields[LINEAR_RED + i]
        fields[GREEN + own] = fields[LINEAR_GREEN + i]
        fields[BLUE + own] = fields[LINEAR_BLUE + i]
