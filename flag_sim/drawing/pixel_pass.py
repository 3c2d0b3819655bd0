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
The pass over a band, or over a sample of its tiles, that shades pixels one by one.

A pixel is colour x (ambient light + light of the sun) + the mirrored sun, where the colour is that
of a texture or of the surface, and the sun's part is less in its shadows. The light is that of the
vertices, interpolated as the style says. A row is shaded in steps, of which all but the fetching
of texels are vectors of pixels.
"""
from flag_sim.drawing.multisample import TILE
from flag_sim.drawing.outline import DARKENING
from flag_sim.drawing.pixels import clamp, pack_rgb
from flag_sim.drawing.sky import sky_colour
from flag_sim.drawing.surfaces import (
    B, C, FIELDS, IS_SHADED, IS_TEXTURED, MAP_U, MAP_V, MAP_Z, MIRRORED, ON_SCREEN, PLAIN, prepare,
    S_DU, S_DV, SUN, X, X_DU, X_DV, Y, Y_DU, Y_DV, Z_DU, Z_DV)
from flag_sim.drawing.texture import encode, log2, TEXEL, trilinear
from flag_sim.drawing.visibility import NO_PRIMITIVE, OUTLINE
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# Of a pixel: where in the texture, in which mipmap; ambient light, that of the sun, the mirrored
# sun; whether it is shaded, and has a texture; where in the shadow map, how deep, and the slopes.
AT_X, AT_Y, LOD, AMBIENT, SUNLIGHT, ADDED, MASK, TEXTURED, AT_U, AT_V, AT_Z = range(11)
AT_Z_DU, AT_Z_DV = 11, 12
DARKER = np.float32(1.0 / DARKENING)


@late_kernel
def shade_band(geometry, buffers, end_id, region, surfaces):
    """
    Shade the pixels of a Region of a band's buffers.

    end_id: of the primitives; surfaces: Surfaces, or None, for which nothing is compiled.
    """
    if surfaces is not None:
        prepare(geometry, surfaces, buffers.primitives, end_id, buffers.shading)
        _shade_region(buffers, region, geometry.transform.is_perspective, surfaces)


@late_kernel
def shade_sample(geometry, buffers, end_id, region, surfaces):
    """Shade a sample of the marked tiles of a Region; the others: see shade_band."""
    if surfaces is not None:
        prepare(geometry, surfaces, buffers.primitives, end_id, buffers.shading)
        _shade_tiles(buffers.tiles, buffers, region, geometry.transform.is_perspective, surfaces)


@late_kernel
def _shade_region(buffers, region, is_perspective, surfaces):
    """Shade the pixels of a Region of a band's buffers."""
    owner, primitive_ids = buffers.shading.owner, buffers.primitive_ids
    for row in range(region.rows):
        first, end = row * region.stride + region.left, row * region.stride + region.right
        if surfaces.sky.is_seen:
            _shade_sky(buffers.colour, primitive_ids, (first, end),
                       (region.left, region.top + row), surfaces.sky)
        while first < end and owner[primitive_ids[first] & ~OUTLINE] < 0:
            first += 1
        while first < end and owner[primitive_ids[end - 1] & ~OUTLINE] < 0:
            end -= 1
        if first < end:
            _shade_row((buffers.colour, buffers.depth, primitive_ids), (first, end),
                       (first - row * region.stride, region.top + row), is_perspective,
                       buffers.shading, surfaces)


@late_kernel
def _shade_tiles(tiles, buffers, region, is_perspective, surfaces):
    """Shade a sample of the marked tiles of a Region, and clear their IDs for the next one."""
    mask, primitive_ids = tiles.mask, buffers.primitive_ids
    for row in range(region.rows):
        for tile in range(mask.shape[1]):
            if mask[row // TILE, tile]:
                first = row * region.stride + tile * TILE
                if surfaces.sky.is_seen:
                    _shade_sky(tiles.colour, primitive_ids, (first, first + TILE),
                               (tile * TILE, region.top + row), surfaces.sky)
                _shade_row((tiles.colour, tiles.depth, primitive_ids), (first, first + TILE),
                           (tile * TILE, region.top + row), is_perspective, buffers.shading,
                           surfaces)
                for i in range(first, first + TILE):
                    primitive_ids[i] = NO_PRIMITIVE


@late_kernel
def _shade_sky(colour, primitive_ids, span, place, sky):
    """Write the colours of pixels that see nothing; see _shade_row."""
    begin, v = np.uint64(span[0]), np.float32(place[1])
    for i in range(np.uint64(span[1]) - begin):
        seen = sky_colour(sky, np.float32(np.int32(place[0]) + np.int32(i)), v)
        is_sky = primitive_ids[begin + i] == NO_PRIMITIVE
        colour[begin + i] = seen if is_sky else colour[begin + i]


@late_kernel
def _shade_row(images, span, place, is_perspective, shading, surfaces):
    """
    Shade pixels of a row.

    images: colour, depth and primitive IDs, flat; span: the first of the pixels and the end;
    place: the column and the row of the first one.
    """
    if is_perspective:
        _locate(images, span, place, True, shading, surfaces)
    else:
        _locate(images, span, place, False, shading, surfaces)
    if surfaces.shadows.depth.size > 0:
        _shade_by_map(np.uint64(span[1] - span[0]), shading.pixels, surfaces.shadows.depth)
    _fetch(images[2], span, shading, surfaces)
    _colour(images, span, shading, surfaces.encode)


@late_inner_kernel
def _locate(images, span, place, is_perspective, shading, surfaces):
    """Write AT_X to AT_Z_DV of pixels."""
    _, depth, primitive_ids = images
    values, pixels = shading.values, shading.pixels
    one, zero = np.float32(1.0), np.float32(0.0)
    begin, ambient, v = np.uint64(span[0]), np.float32(surfaces.ambient), np.float32(place[1])
    for i in range(np.uint64(span[1]) - begin):
        stored = primitive_ids[begin + i]
        p = np.uint64(stored & ~OUTLINE) * np.uint64(FIELDS)
        u, s = np.float32(np.int32(place[0]) + np.int32(i)), depth[begin + i]
        z = one / s if is_perspective else one
        of_b, of_c = _plane(values, p, B, u, v) * z, _plane(values, p, C, u, v) * z
        of_b = clamp(of_b, zero, one)
        of_c = clamp(of_c, zero, one - of_b)
        x, y = _more(values, p, X, of_b, of_c), _more(values, p, Y, of_b, of_c)
        # With x s and s linear on the screen, the change of x is that of x s, minus x times that
        # of s, over s.
        s_du, s_dv = values[p + np.uint64(S_DU)], values[p + np.uint64(S_DV)]
        x_du, x_dv = (values[p + np.uint64(X_DU)] - x * s_du,
                      values[p + np.uint64(X_DV)] - x * s_dv)
        y_du, y_dv = (values[p + np.uint64(Y_DU)] - y * s_du,
                      values[p + np.uint64(Y_DV)] - y * s_dv)
        # How many texels a pixel is wide where it is wider, squared.
        square = max(x_du * x_du + y_du * y_du, x_dv * x_dv + y_dv * y_dv) * (z * z)
        pixels[AT_X, i], pixels[AT_Y, i] = (values[p + np.uint64(X)] + x,
                                            values[p + np.uint64(Y)] + y)
        pixels[LOD, i] = np.float32(0.5) * log2(square) if square > one else zero
        factor = s if values[p + np.uint64(ON_SCREEN)] > zero else one
        light = values[p + np.uint64(SUN)] + factor * _more(values, p, SUN, of_b, of_c)
        added = values[p + np.uint64(MIRRORED)] + factor * _more(values, p, MIRRORED, of_b, of_c)
        share = DARKER if stored & OUTLINE else one
        pixels[AMBIENT, i] = share * ambient
        pixels[SUNLIGHT, i] = share * max(light, zero)
        pixels[ADDED, i] = share * max(added, zero)
        pixels[MASK, i] = values[p + np.uint64(IS_SHADED)]
        pixels[TEXTURED, i] = values[p + np.uint64(IS_TEXTURED)]
        pixels[AT_U, i] = values[p + np.uint64(MAP_U)] + _more(values, p, MAP_U, of_b, of_c)
        pixels[AT_V, i] = values[p + np.uint64(MAP_V)] + _more(values, p, MAP_V, of_b, of_c)
        pixels[AT_Z, i] = values[p + np.uint64(MAP_Z)] + _more(values, p, MAP_Z, of_b, of_c)
        pixels[AT_Z_DU, i] = values[p + np.uint64(Z_DU)]
        pixels[AT_Z_DV, i] = values[p + np.uint64(Z_DV)]


@late_inner_kernel
def _plane(values, p, field, u, v):
    """Return what is linear on the screen at column u and row v."""
    p += np.uint64(field)
    return values[p] + values[p + np.uint64(1)] * u + values[p + np.uint64(2)] * v


@late_inner_kernel
def _more(values, p, field, of_b, of_c):
    """Return what is linear in the weights, beyond that of the first vertex."""
    p += np.uint64(field)
    return values[p + np.uint64(1)] * of_b + values[p + np.uint64(2)] * of_c


@late_inner_kernel
def _shade_by_map(count, pixels, depth):
    """
    Take from the sun's light of pixels what they have not in its shadow.

    The share of the light is an average over 3 x 3 texels about the place: over 4 x 4 texels'
    centres, of which the outer ones count by how much of them is within.
    """
    height, width = depth.shape
    one, zero = np.float32(1.0), np.float32(0.0)
    # Where there is no number, the comparisons make 1.
    last_u, last_v = np.float32(width - 3), np.float32(height - 3)
    for i in range(count):
        u, v, z = pixels[AT_U, i], pixels[AT_V, i], pixels[AT_Z, i]
        du, dv = pixels[AT_Z_DU, i], pixels[AT_Z_DV, i]
        u = min(u, last_u) if u > one else one
        v = min(v, last_v) if v > one else one
        column, row = np.int32(u), np.int32(v)
        right, down = u - np.float32(column), v - np.float32(row)
        share = zero
        for down_by in range(4):
            of_row = zero
            for right_by in range(4):
                z_here = (z + du * (np.float32(right_by - 1) - right)
                          + dv * (np.float32(down_by - 1) - down))
                is_lit = depth[np.uint32(row + down_by - 1),
                               np.uint32(column + right_by - 1)] >= z_here
                weight = (one - right if right_by == 0 else right if right_by == 3 else one)
                of_row += weight if is_lit else zero
            share += of_row * (one - down if down_by == 0 else down if down_by == 3 else one)
        share *= np.float32(1.0 / 9.0)
        pixels[SUNLIGHT, i] *= share
        pixels[ADDED, i] *= share


@late_inner_kernel
def _fetch(primitive_ids, span, shading, surfaces):
    """Write red, green and blue of pixels in linear light."""
    pixels, textures, levels = shading.pixels, surfaces.textures, surfaces.levels
    linear = shading.linear
    begin = np.uint64(span[0])
    for i in range(np.uint64(span[1]) - begin):
        if pixels[TEXTURED, i] > np.float32(0.0):
            k = np.uint64(shading.owner[np.uint64(primitive_ids[begin + i] & ~OUTLINE)])
            trilinear(surfaces.texels, levels, (textures[k, 0], textures[k, 1]),
                      (pixels[AT_X, i], pixels[AT_Y, i], pixels[LOD, i]), linear,
                      np.uint64(TEXEL) * i)


@late_inner_kernel
def _colour(images, span, shading, table):
    """Write the colours of pixels; see texture.ENCODE."""
    colour, _, primitive_ids = images
    pixels, linear, values = shading.pixels, shading.linear, shading.values
    begin, most, zero = np.uint64(span[0]), np.float32(255.0), np.float32(0.0)
    for i in range(np.uint64(span[1]) - begin):
        light, added = pixels[AMBIENT, i] + pixels[SUNLIGHT, i], pixels[ADDED, i]
        p = np.uint64(TEXEL) * i
        q = np.uint64(primitive_ids[begin + i] & ~OUTLINE) * np.uint64(FIELDS) + np.uint64(PLAIN)
        red, green = encode(linear[p], table), encode(linear[p + np.uint64(1)], table)
        blue = encode(linear[p + np.uint64(2)], table)
        is_textured = pixels[TEXTURED, i] > zero
        red = red if is_textured else values[q]
        green = green if is_textured else values[q + np.uint64(1)]
        blue = blue if is_textured else values[q + np.uint64(2)]
        shaded = pack_rgb(min(red * light + added, most), min(green * light + added, most),
                          min(blue * light + added, most))
        is_shaded = pixels[MASK, i] > zero
        colour[begin + i] = shaded if is_shaded else colour[begin + i]
