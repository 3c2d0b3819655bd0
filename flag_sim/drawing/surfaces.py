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
Surfaces whose pixels are shaded one by one, from what each of them sees.

Most surfaces need none of this: colours of their vertices are interpolated while triangles are
drawn. A texture has no colours at vertices. Where there is one, pixels store the primitive that
they see (see visibility), and when a band is drawn, or a further sample of its tiles, a pass over
it shades them: texture x (ambient light + light of the sun) + the mirrored sun. The light is still
that of the vertices, interpolated as the style says.
"""
from typing import NamedTuple

from flag_sim.drawing.multisample import TILE
from flag_sim.drawing.outline import DARKENING
from flag_sim.drawing.pixels import clamp, pack_rgb
from flag_sim.drawing.texture import encode, log2, TEXEL, trilinear
from flag_sim.drawing.visibility import NO_PRIMITIVE, OUTLINE
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel

import numpy as np

# Of a primitive: weights of its second and third vertex, as in Primitives.planes; texture
# coordinates [texel of the largest mipmap]: at the first vertex, and what the others have more;
B, C, X, Y = 0, 3, 6, 9
# changes a column and a row of x s and y s, and of s;
X_DU, X_DV, Y_DU, Y_DV, S_DU, S_DV = range(12, 18)
# the sun's light and the mirrored sun: at the first vertex, and what the others have more;
# whether light is linear on the screen; whether pixels are shaded.
SUN, MIRRORED, ON_SCREEN, IS_SHADED = 18, 21, 24, 25
FIELDS = 32
# Of a pixel: where in the texture, in which mipmap, its light, whether it is shaded.
AT_X, AT_Y, LOD, LIGHT, ADDED, MASK = range(6)
DARKER = np.float32(1.0 / DARKENING)


class Surfaces(NamedTuple):
    """
    How pixels of textured triangles are shaded, for the kernels.

    textures: (k, 2) int64, of each texture its first mipmap among `levels` and how many it has;
    levels, texels: see Texture, those of all textures; texture_of: (m,) int32, of each triangle,
    -1 where it has none; coordinates: (n, 2) of vertices; sun, mirrored: (n, 2, 3) of both sides
    of vertices, or of triangles where is_flat, see shading.light_levels; ambient: light from
    everywhere; encode: see texture.ENCODE; is_on_screen: whether light is linear on the screen.
    """

    textures: np.ndarray
    levels: np.ndarray
    texels: np.ndarray
    texture_of: np.ndarray
    coordinates: np.ndarray
    sun: np.ndarray
    mirrored: np.ndarray
    ambient: float
    encode: np.ndarray
    is_flat: bool
    is_on_screen: bool


class Shading(NamedTuple):
    """
    A thread's memory for this.

    texture: (n,) int32, of primitives; values: flat, FIELDS float32 of each; pixels: (6, stride)
    float32, of a row; linear: flat, TEXEL float32 of each, red, green and blue in linear light.
    """

    texture: np.ndarray
    values: np.ndarray
    pixels: np.ndarray
    linear: np.ndarray


def new_shading(count: int, stride: int) -> Shading:
    """Make the arrays for so many primitives, and for rows of `stride` pixels."""
    return Shading(np.full(count, -1, np.int32), np.zeros(count * FIELDS, np.float32),
                   np.empty((6, stride), np.float32), np.empty(stride * TEXEL, np.float32))


@lean_kernel
def prepare(geometry, surfaces, primitives, end_id, shading):
    """Write into `shading` what the pixels of the primitives 1 .. end_id - 1 are shaded with."""
    view, is_perspective = geometry.vertices.view_space, geometry.transform.is_perspective
    coordinates, values = surfaces.coordinates, shading.values
    for p in range(1, end_id):
        t, side = np.int64(primitives.faces[p] >> 1), np.int64(primitives.faces[p] & 1)
        texture = surfaces.texture_of[t]
        at = p * FIELDS
        shading.texture[p], values[at + IS_SHADED] = texture, np.float32(texture >= 0)
        if texture < 0:
            continue
        planes = primitives.planes
        for k in range(6):
            values[at + B + k] = planes[p, k]
        a, b, c = geometry.triangles[t, 0], geometry.triangles[t, 1], geometry.triangles[t, 2]
        largest = surfaces.textures[texture, 0]
        for axis in range(2):
            size = float(surfaces.levels[largest, 1 + axis])
            at_a = coordinates[a, axis]
            of_b = size * (coordinates[b, axis] - at_a)
            of_c = size * (coordinates[c, axis] - at_a)
            field = at + X + 3 * axis
            values[field] = size * at_a
            values[field + 1], values[field + 2] = of_b, of_c
            for way in range(2):
                values[at + X_DU + 2 * axis + way] = (
                    of_b * planes[p, 1 + way] + of_c * planes[p, 4 + way])
        depths = view[a, 2], view[b, 2], view[c, 2]
        # Weights on the screen are those in space times depth, over that of the pixel.
        is_on_screen = surfaces.is_on_screen and is_perspective and min(depths) > 0.0
        scales = (depths[1], depths[2]) if is_on_screen else (1.0, 1.0)
        values[at + ON_SCREEN] = np.float32(is_on_screen)
        lit = (t, t, t) if surfaces.is_flat else (a, b, c)
        _light(surfaces.sun, lit, side, scales, values, at + SUN)
        _light(surfaces.mirrored, lit, side, scales, values, at + MIRRORED)
        values[at + S_DU], values[at + S_DV] = (_slopes(view, a, b, c) if is_perspective
                                                else (0.0, 0.0))


@lean_inner_kernel
def _light(light, lit, side, scales, values, field):
    at_a = light[lit[0], side, 0]
    values[field] = at_a
    values[field + 1] = scales[0] * (light[lit[1], side, 0] - at_a)
    values[field + 2] = scales[1] * (light[lit[2], side, 0] - at_a)


@lean_inner_kernel
def _slopes(view, a, b, c):
    """
    Return the changes of reversed Z a column and a row, on the plane of three points in space.

    On the plane n . (X, Y, z) = d, with X and Y in pixels at depth 1, s = n . (u, v, 1) / d.
    """
    px, py, pz = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1], view[b, 2] - view[a, 2]
    qx, qy, qz = view[c, 0] - view[a, 0], view[c, 1] - view[a, 1], view[c, 2] - view[a, 2]
    nx, ny, nz = py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx
    d = nx * view[a, 0] + ny * view[a, 1] + nz * view[a, 2]
    return nx / d, ny / d


@lean_kernel
def shade_region(buffers, region, is_perspective, surfaces):
    """Shade the pixels of a Region of a band's buffers."""
    texture, primitive_ids = buffers.shading.texture, buffers.primitive_ids
    for row in range(region.rows):
        first, end = row * region.stride + region.left, row * region.stride + region.right
        while first < end and texture[primitive_ids[first] & ~OUTLINE] < 0:
            first += 1
        while first < end and texture[primitive_ids[end - 1] & ~OUTLINE] < 0:
            end -= 1
        if first < end:
            _shade_row((buffers.colour, buffers.depth, primitive_ids), (first, end),
                       (first - row * region.stride, region.top + row), is_perspective,
                       buffers.shading, surfaces)


@lean_kernel
def shade_tiles(tiles, buffers, region, is_perspective, surfaces):
    """Shade a sample of the marked tiles of a Region, and clear their IDs for the next one."""
    mask, primitive_ids = tiles.mask, buffers.primitive_ids
    for row in range(region.rows):
        for tile in range(mask.shape[1]):
            if mask[row // TILE, tile]:
                first = row * region.stride + tile * TILE
                _shade_row((tiles.colour, tiles.depth, primitive_ids), (first, first + TILE),
                           (tile * TILE, region.top + row), is_perspective, buffers.shading,
                           surfaces)
                for i in range(first, first + TILE):
                    primitive_ids[i] = NO_PRIMITIVE


@lean_kernel
def _shade_row(images, span, place, is_perspective, shading, surfaces):
    """
    Shade pixels of a row: where they are, texels, colours; the first and the last in vectors.

    images: colour, depth and primitive IDs, flat; span: the first of the pixels and the end;
    place: the column and the row of the first one.
    """
    if is_perspective:
        _locate(images, span, place, True, shading, surfaces)
    else:
        _locate(images, span, place, False, shading, surfaces)
    _fetch(images[2], span, shading, surfaces)
    _colour(images[0], span, shading, surfaces.encode)


@lean_inner_kernel
def _locate(images, span, place, is_perspective, shading, surfaces):
    """Write AT_X to MASK of pixels."""
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
        pixels[LIGHT, i] = share * (ambient + max(light, zero))
        pixels[ADDED, i] = share * max(added, zero)
        pixels[MASK, i] = values[p + np.uint64(IS_SHADED)]


@lean_inner_kernel
def _plane(values, p, field, u, v):
    """Return what is linear on the screen at column u and row v."""
    p += np.uint64(field)
    return values[p] + values[p + np.uint64(1)] * u + values[p + np.uint64(2)] * v


@lean_inner_kernel
def _more(values, p, field, of_b, of_c):
    """Return what is linear in the weights, beyond that of the first vertex."""
    p += np.uint64(field)
    return values[p + np.uint64(1)] * of_b + values[p + np.uint64(2)] * of_c


@lean_inner_kernel
def _fetch(primitive_ids, span, shading, surfaces):
    """Write red, green and blue of pixels in linear light."""
    pixels, textures, levels = shading.pixels, surfaces.textures, surfaces.levels
    linear = shading.linear
    begin = np.uint64(span[0])
    for i in range(np.uint64(span[1]) - begin):
        if pixels[MASK, i] > np.float32(0.0):
            k = np.uint64(shading.texture[np.uint64(primitive_ids[begin + i] & ~OUTLINE)])
            trilinear(surfaces.texels, levels, (textures[k, 0], textures[k, 1]),
                      (pixels[AT_X, i], pixels[AT_Y, i], pixels[LOD, i]), linear,
                      np.uint64(TEXEL) * i)


@lean_inner_kernel
def _colour(colour, span, shading, table):
    """Write the colours of pixels; see texture.ENCODE."""
    pixels, linear = shading.pixels, shading.linear.reshape(-1)
    begin, most = np.uint64(span[0]), np.float32(255.0)
    for i in range(np.uint64(span[1]) - begin):
        light, added, p = pixels[LIGHT, i], pixels[ADDED, i], np.uint64(TEXEL) * i
        shaded = pack_rgb(
            min(encode(linear[p], table) * light + added, most),
            min(encode(linear[p + np.uint64(1)], table) * light + added, most),
            min(encode(linear[p + np.uint64(2)], table) * light + added, most))
        is_shaded = pixels[MASK, i] > np.float32(0.0)
        colour[begin + i] = shaded if is_shaded else colour[begin + i]
