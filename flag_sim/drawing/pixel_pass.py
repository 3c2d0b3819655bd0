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
from flag_sim.drawing.geometry import SUBPIXELS
from flag_sim.drawing.multisample import TILE
from flag_sim.drawing.outline import DARKENING
from flag_sim.drawing.pixels import pack_rgb
from flag_sim.drawing.shadow_pass import ADDED, place_in_map, shade_by_map, SUNLIGHT
from flag_sim.drawing.sky import sky_colour
from flag_sim.drawing.surfaces import MIRRORED, ON_SCREEN, SEGMENT, SUN
from flag_sim.drawing.texture_pass import BLUE, GREEN, RED, shade_by_texture
from flag_sim.drawing.visibility import NO_FACE, OUTLINE, triangle_of
from flag_sim.jit.kernels import late_kernel, wide_kernel

import numpy as np

DARKER = np.float32(1.0 / DARKENING)


@late_kernel
def shade_band(buffers, region, is_perspective, surfaces):
    """
    Shade the pixels of a Region of a band's buffers.

    surfaces: Surfaces, or None, for which nothing is compiled.
    """
    if surfaces is not None:
        for row in range(region.first, region.first + region.rows):
            start = row * region.stride
            _shade_row((buffers.colour, buffers.depth, buffers.faces),
                       (start + region.left, start + region.right),
                       (np.float32(region.left), np.float32(region.top + row)), is_perspective,
                       buffers.shading, surfaces)


@late_kernel
def shade_sample(buffers, region, is_perspective, surfaces, state):
    """
    Shade a sample of the marked tiles of a Region, and clear their faces for the next one.

    surfaces: see shade_band; state: of the rasterizer, which says where the sample is.
    """
    if surfaces is not None:
        right = np.float32(state.shift_u) / np.float32(SUBPIXELS)
        down = np.float32(state.shift_v) / np.float32(SUBPIXELS)
        tiles, faces = buffers.tiles, buffers.faces
        for row in range(region.rows):
            for tile in range(tiles.mask.shape[1]):
                if tiles.mask[row // TILE, tile]:
                    first = row * region.stride + tile * TILE
                    _shade_row((tiles.colour, tiles.depth, faces), (first, first + TILE),
                               (np.float32(tile * TILE) + right,
                                np.float32(region.top + row) + down), is_perspective,
                               buffers.shading, surfaces)
                    for i in range(first, first + TILE):
                        faces[i] = NO_FACE


@late_kernel
def _shade_row(images, span, place, is_perspective, shading, surfaces):
    """
    Shade pixels of a row.

    images: colour, depth and faces, flat; span: the first of the pixels and the end; place: column
    and row of the first one's sample.
    """
    colour, depth, faces = images
    begin, end = np.uint64(span[0]), np.uint64(span[1])
    if surfaces.sky.is_seen:
        _shade_sky(colour, faces, (begin, end), place, surfaces.sky)
    object_of, pixels = surfaces.object_of, shading.pixels
    first = begin
    while first < end and (faces[first] == NO_FACE or object_of[triangle_of(faces[first])] < 0):
        first += np.uint64(1)
    while first < end and (faces[end - np.uint64(1)] == NO_FACE
                           or object_of[triangle_of(faces[end - np.uint64(1)])] < 0):
        end -= np.uint64(1)
    if first >= end:
        return
    while first < end:
        row = (first, min(end - first, np.uint64(SEGMENT)),
               (place[0] + np.float32(np.int64(first - begin)), place[1]))
        first += np.uint64(SEGMENT)
        _light(row, depth, faces, is_perspective, pixels, surfaces)
        if surfaces.shadows.depth.size > 0:
            place_in_map(row, depth, faces, is_perspective, pixels, surfaces)
            shade_by_map(row, faces, surfaces.fields, pixels, surfaces.shadows.depth)
        for k in range(surfaces.textures.shape[0]):
            if surfaces.textures[k, 1] > 0:
                shade_by_texture(row, depth, faces, is_perspective, pixels, surfaces, k)
        _colour(row, colour, faces, pixels, surfaces)


@wide_kernel
def _shade_sky(colour, faces, span, place, sky):
    """Write the colours of pixels that see nothing; see _shade_row."""
    begin, (column, v) = span[0], place
    for i in range(span[1] - begin):
        seen = sky_colour(sky, column + np.float32(np.int32(i)), v)
        is_sky = faces[begin + i] == NO_FACE
        colour[begin + i] = seen if is_sky else colour[begin + i]


@wide_kernel
def _light(row, depth, faces, is_perspective, pixels, surfaces):
    """Write SUNLIGHT and ADDED of pixels, and RED to BLUE of what has no texture."""
    begin, count, place = row
    fields, of_faces, is_specular = surfaces.fields, surfaces.of_faces, surfaces.is_specular
    object_of, colours = surfaces.object_of, surfaces.colours
    column, v = place
    one, zero = np.float32(1.0), np.float32(0.0)
    for i in range(count):
        u = column + np.float32(np.int32(i))
        mark = np.uint32(faces[begin + i] & ~OUTLINE)
        face = np.uint32(max(mark, np.uint32(1)) - np.uint32(1))
        z = one / depth[begin + i] if is_perspective else one
        scale = one if fields[ON_SCREEN, face >> np.uint32(1)] > zero else z
        light = of_faces[SUN, face] + of_faces[SUN + 1, face] * u + of_faces[SUN + 2, face] * v
        pixels[SUNLIGHT + i] = max(scale * light, zero)
        if is_specular:
            added = (of_faces[MIRRORED, face] + of_faces[MIRRORED + 1, face] * u
                     + of_faces[MIRRORED + 2, face] * v)
            pixels[ADDED + i] = max(scale * added, zero)
        else:
            pixels[ADDED + i] = zero
        k = np.uint32(max(object_of[face >> np.uint32(1)], np.int32(0)))
        pixels[RED + i], pixels[GREEN + i] = colours[0, k], colours[1, k]
        pixels[BLUE + i] = colours[2, k]


@wide_kernel
def _colour(row, colour, faces, pixels, surfaces):
    """Write the colours of pixels that are shaded."""
    begin, count, _ = row
    object_of = surfaces.object_of
    ambient, most = np.float32(surfaces.ambient), np.float32(255.0)
    for i in range(count):
        mark = faces[begin + i]
        share = DARKER if mark & OUTLINE else np.float32(1.0)
        light, added = share * (ambient + pixels[SUNLIGHT + i]), share * pixels[ADDED + i]
        shaded = pack_rgb(min(pixels[RED + i] * light + added, most),
                          min(pixels[GREEN + i] * light + added, most),
                          min(pixels[BLUE + i] * light + added, most))
        is_shaded = (mark != NO_FACE) & (object_of[triangle_of(mark)] >= 0)
        colour[begin + i] = shaded if is_shaded else colour[begin + i]
