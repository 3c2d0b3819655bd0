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
drawn. A texture has no colours at vertices, and shadows end between them. Where there is one of
these, pixels store the primitive that they see (see visibility), and when a band is drawn, or a
further sample of its tiles, a pass over it shades them (see pixel_pass). Here is what it needs of
each primitive.
"""
from typing import NamedTuple

from flag_sim.drawing.shadows import bias_at, Shadows, slopes_of
from flag_sim.drawing.sky import Sky
from flag_sim.drawing.texture import TEXEL
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# Of a primitive: weights of its second and third vertex, as in Primitives.planes; texture
# coordinates [texel of the largest mipmap]: at the first vertex, and what the others have more;
B, C, X, Y = 0, 3, 6, 9
# changes a column and a row of x s and y s, and of s;
X_DU, X_DV, Y_DU, Y_DV, S_DU, S_DV = range(12, 18)
# the sun's light and the mirrored sun: at the first vertex, and what the others have more;
# whether light is linear on the screen; whether pixels are shaded, and have a texture; the colour
# of those that have none;
SUN, MIRRORED, ON_SCREEN, IS_SHADED, IS_TEXTURED, PLAIN = 18, 21, 24, 25, 26, 27
# column, row and depth in the shadow map, less the bias, as the light; slopes of the depth.
MAP_U, MAP_V, MAP_Z, Z_DU, Z_DV = 30, 33, 36, 39, 40
FIELDS = 48
PIXEL_FIELDS = 13  # see pixel_pass


class Surfaces(NamedTuple):
    """
    How pixels are shaded one by one, for the kernels.

    colours: (k, 3) of each object; textures: (k, 2) int64, of each object the first mipmap among
    `levels` and how many it has, 0 for one without a texture; levels, texels: see Texture, those
    of all textures; object_of: (m,) int32, of each triangle, -1 where pixels are not shaded;
    coordinates: (n, 2) of vertices; sun, mirrored: (n, 2, 3) of both sides of vertices, or of
    triangles where is_flat, see shading.light_levels; ambient: light from everywhere; encode: see
    texture.ENCODE; is_on_screen: whether light is linear on the screen; shadows, sky: see there.
    """

    colours: np.ndarray
    textures: np.ndarray
    levels: np.ndarray
    texels: np.ndarray
    object_of: np.ndarray
    coordinates: np.ndarray
    sun: np.ndarray
    mirrored: np.ndarray
    ambient: float
    encode: np.ndarray
    is_flat: bool
    is_on_screen: bool
    shadows: Shadows
    sky: Sky


class Shading(NamedTuple):
    """
    A thread's memory for this.

    owner: (n,) int32, of primitives the object, -1 for those whose pixels are not shaded; values:
    flat, FIELDS float32 of each; pixels: (PIXEL_FIELDS, stride) float32, of a row; linear: flat,
    TEXEL float32 of each, red, green and blue in linear light.
    """

    owner: np.ndarray
    values: np.ndarray
    pixels: np.ndarray
    linear: np.ndarray


def new_shading(count: int, stride: int) -> Shading:
    """Make the arrays for so many primitives, and for rows of `stride` pixels."""
    return Shading(np.full(count, -1, np.int32), np.zeros(count * FIELDS, np.float32),
                   np.zeros((PIXEL_FIELDS, stride), np.float32),
                   np.zeros(stride * TEXEL, np.float32))


@late_kernel
def prepare(geometry, surfaces, primitives, end_id, shading):
    """Write into `shading` what the pixels of the primitives 1 .. end_id - 1 are shaded with."""
    view, is_perspective = geometry.vertices.view_space, geometry.transform.is_perspective
    coordinates, values = surfaces.coordinates, shading.values
    for p in range(1, end_id):
        t, side = np.int64(primitives.faces[p] >> 1), np.int64(primitives.faces[p] & 1)
        owner = surfaces.object_of[t]
        at = p * FIELDS
        shading.owner[p], values[at + IS_SHADED] = owner, np.float32(owner >= 0)
        is_textured = owner >= 0 and surfaces.textures[owner, 1] > 0
        values[at + IS_TEXTURED] = np.float32(is_textured)
        if owner < 0:
            continue
        for channel in range(3):
            values[at + PLAIN + channel] = surfaces.colours[owner, channel]
        planes = primitives.planes
        for k in range(6):
            values[at + B + k] = planes[p, k]
        a, b, c = geometry.triangles[t, 0], geometry.triangles[t, 1], geometry.triangles[t, 2]
        for axis in range(2):
            size = float(surfaces.levels[surfaces.textures[owner, 0], 1 + axis]) * is_textured
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
        if surfaces.shadows.depth.size > 0:
            _place_in_map(surfaces.shadows, (a, b, c), values, at)
        values[at + S_DU], values[at + S_DV] = (_slopes(view, a, b, c) if is_perspective
                                                else (0.0, 0.0))


@late_inner_kernel
def _light(light, lit, side, scales, values, field):
    at_a = light[lit[0], side, 0]
    values[field] = at_a
    values[field + 1] = scales[0] * (light[lit[1], side, 0] - at_a)
    values[field + 2] = scales[1] * (light[lit[2], side, 0] - at_a)


@late_inner_kernel
def _place_in_map(shadows, corners, values, at):
    """Write MAP_U to Z_DV of a triangle."""
    places, slopes = shadows.places, shadows.slopes
    a, b, c = corners
    texel = shadows.texel
    du, dv, side = slopes_of(places, a, b, c, texel)
    values[at + Z_DU], values[at + Z_DV] = du, dv
    for axis in range(3):
        field = at + MAP_U + 3 * axis
        values[field] = places[a, axis]
        values[field + 1] = places[b, axis] - places[a, axis]
        values[field + 2] = places[c, axis] - places[a, axis]
    bias = bias_at(slopes, a, du, dv, side, texel)
    values[at + MAP_Z] -= bias + shadows.rounding
    values[at + MAP_Z + 1] -= bias_at(slopes, b, du, dv, side, texel) - bias
    values[at + MAP_Z + 2] -= bias_at(slopes, c, du, dv, side, texel) - bias


@late_inner_kernel
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
