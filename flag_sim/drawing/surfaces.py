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
these, pixels store the face that they see (see visibility), and when a band is drawn, or a further
sample of its tiles, a pass over it shades them (see pixel_pass). Here is what it needs of each
triangle, as planes (see planes).
"""
from typing import NamedTuple

from flag_sim.drawing.planes import plane, solver
from flag_sim.drawing.shadows import bias_at, Shadows, slopes_of
from flag_sim.drawing.sky import Sky
from flag_sim.jit.kernels import late_kernel

import numpy as np

# Of triangles: planes of the texture coordinates, changes of 1 / z a column and a row, whether
# light is linear on the screen, the plane of the bias [m], and the slopes of the depth in the
# shadow map. A plane takes three fields.
X, Y, S_DU, S_DV, ON_SCREEN, BIAS, Z_DU, Z_DV = 0, 3, 6, 7, 8, 9, 12, 13
FIELDS = 14
# Of faces: planes of the sun's light and of the mirrored sun.
SUN, MIRRORED = 0, 3
FACE_FIELDS = 6


class Surfaces(NamedTuple):
    """
    How pixels are shaded one by one, for the kernels.

    colours: (3, k) float32 of each object; textures: (k, 4) int64, of each object the first mipmap
    among `levels` and how many it has, 0 for one without a texture, and where among `flats` its
    own begin and end; levels, texels: see Texture,
    those of all textures; object_of: (m,) int32, of each triangle, -1 where pixels are not shaded;
    starts: (levels,) int32, where each level begins among the texels; flats: see flat_tiles, of
    all textures; flat_starts: (levels,) int32, where each level begins among its texture's own;
    coordinates: (n, 2) of
    vertices; sun, mirrored: (n, 2, 3) of both sides of vertices, or of triangles where is_flat,
    see shading.light_levels; ambient: light from everywhere; encode: see texture.ENCODE;
    is_on_screen: whether light is linear on the screen; has_textures, has_plain, is_specular:
    whether any object has a texture, has none but is shaded, or mirrors the sun; fields: (FIELDS,
    m) float32 of triangles; of_faces: (FACE_FIELDS, 2 m) float32, by twice the triangle's index
    plus the side; shadows, sky: see there.
    """

    colours: np.ndarray
    textures: np.ndarray
    levels: np.ndarray
    texels: np.ndarray
    starts: np.ndarray
    flats: np.ndarray
    flat_starts: np.ndarray
    object_of: np.ndarray
    coordinates: np.ndarray
    sun: np.ndarray
    mirrored: np.ndarray
    ambient: float
    encode: np.ndarray
    is_flat: bool
    is_on_screen: bool
    has_textures: bool
    has_plain: bool
    is_specular: bool
    fields: np.ndarray
    of_faces: np.ndarray
    shadows: Shadows
    sky: Sky


@late_kernel
def set_surfaces(geometry, surfaces, fields, of_faces, first, end):
    """Write the fields of triangles first .. end - 1, and of their faces."""
    view, transform = geometry.vertices.view_space, geometry.transform
    triangles, is_perspective = geometry.triangles, transform.is_perspective
    for t in range(np.uint64(first), np.uint64(end)):
        owner = surfaces.object_of[t]
        if owner < 0:
            continue
        solve = solver(geometry, t)
        a, b = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1])
        c = np.uint64(triangles[t, 2])
        # The depth at vertices: light that is linear on the screen is so times depth in space.
        z_a, z_b, z_c = view[a, 2], view[b, 2], view[c, 2]
        is_on_screen = surfaces.is_on_screen and is_perspective and min(z_a, z_b, z_c) > 0.0
        if not is_on_screen:
            z_a = z_b = z_c = 1.0
        fields[ON_SCREEN, t] = np.float32(is_on_screen)
        _set_light(surfaces, transform, solve, t, (z_a, z_b, z_c), geometry.triangles, of_faces)
        if surfaces.has_textures:
            # Of 1 at all vertices, divided by depth.
            fields[S_DU, t] = solve[0] + solve[3] + solve[6] if is_perspective else 0.0
            fields[S_DV, t] = solve[1] + solve[4] + solve[7] if is_perspective else 0.0
            coordinates = surfaces.coordinates
            for axis in range(2):
                _set(fields, X + 3 * axis, t, plane(
                    transform, solve, coordinates[a, axis], coordinates[b, axis],
                    coordinates[c, axis]))
        if surfaces.shadows.depth.size > 0:
            shadows = surfaces.shadows
            du, dv, side = slopes_of(shadows.places, a, b, c, shadows.texel)
            fields[Z_DU, t], fields[Z_DV, t] = du, dv
            _set(fields, BIAS, t, plane(
                transform, solve, bias_at(shadows, a, du, dv, side),
                bias_at(shadows, b, du, dv, side), bias_at(shadows, c, du, dv, side)))


@late_kernel
def _set_light(surfaces, transform, solve, t, depths, triangles, of_faces):
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    if surfaces.is_flat:
        a = b = c = np.int32(t)
    for side in range(2):
        face = 2 * np.int64(t) + side
        for field, light in ((SUN, surfaces.sun), (MIRRORED, surfaces.mirrored)):
            if field == SUN or surfaces.is_specular:
                _set(of_faces, field, face, plane(
                    transform, solve, depths[0] * light[a, side, 0],
                    depths[1] * light[b, side, 0], depths[2] * light[c, side, 0]))


@late_kernel
def _set(fields, field, k, values):
    fields[field, k], fields[field + 1, k], fields[field + 2, k] = values
