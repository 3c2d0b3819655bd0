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
vertices, interpolated as the style says. Each step is a loop over the pixels of a segment.
"""
from flag_sim.drawing.geometry import SUBPIXELS
from flag_sim.drawing.multisample import TILE
from flag_sim.drawing.outline import DARKENING
from flag_sim.drawing.pixels import pack_rgb
from flag_sim.drawing.segment import (
    ADDED, BLUE, COLUMN, DEPTH, find_owners, GREEN, RED, ROW, sees, SEGMENT, set_places, SUNLIGHT)
from flag_sim.drawing.shadow_pass import place_in_map, shade_by_map
from flag_sim.drawing.sky import sky_colour
from flag_sim.drawing.surfaces import MIRRORED, ON_SCREEN, SUN
from flag_sim.drawing.texture_pass import shade_by_texture
from flag_sim.drawing.visibility import NO_FACE, OUTLINE
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
        images, segment = (buffers.colour, buffers.depth, buffers.faces), buffers.segment
        for row in range(region.first, region.first + region.rows):
            for left in range(region.left, region.right, SEGMENT):
                count = np.uint64(min(region.right - left, SEGMENT))
                set_places(segment.fields, np.uint64(0), count, np.float32(left),
                           np.float32(region.top + row))
                _shade(images, np.uint64(row * region.stride + left), count, is_perspective,
                       segment, surfaces)


@late_kernel
def shade_sample(buffers, region, is_perspective, surfaces, state):
    """
    Shade a sample of the marked tiles of a Region, and clear their faces for the next one.

    surfaces: see shade_band; state: of the rasterizer, which says where the sample is.
    """
    if surfaces is not None:
        right = np.float32(state.shift_u) / np.float32(SUBPIXELS)
        down = np.float32(state.shift_v) / np.float32(SUBPIXELS)
        tiles, faces, segment = buffers.tiles, buffers.faces, buffers.segment
        count = np.uint64(0)
        for row in range(region.rows):
            for tile in range(tiles.mask.shape[1]):
                if tiles.mask[row // TILE, tile]:
                    first = np.uint64(row * region.stride + tile * TILE)
                    set_places(segment.fields, count, TILE, np.float32(tile * TILE) + right,
                               np.float32(region.top + row) + down)
                    for i in range(np.uint64(TILE)):
                        segment.colour[count + i] = tiles.colour[first + i]
                        segment.depth[count + i] = tiles.depth[first + i]
                        segment.faces[count + i] = faces[first + i]
                        segment.sources[count + i] = first + i
                        faces[first + i] = NO_FACE
                    count += np.uint64(TILE)
                    if count == np.uint64(SEGMENT):
                        _shade_copies(count, is_perspective, segment, surfaces, tiles.colour)
                        count = np.uint64(0)
        _shade_copies(count, is_perspective, segment, surfaces, tiles.colour)


@late_kernel
def _shade_copies(count, is_perspective, segment, surfaces, colour):
    """Shade the pixels that were copied to a segment, and write their colours back."""
    _shade((segment.colour, segment.depth, segment.faces), np.uint64(0), count, is_perspective,
           segment, surfaces)
    for i in range(count):
        colour[segment.sources[i]] = segment.colour[i]


@late_kernel
def _shade(images, begin, count, is_perspective, segment, surfaces):
    """
    Shade pixels begin .. begin + count - 1 of images; COLUMN and ROW are written.

    images: colour, depth and faces, flat.
    """
    colour, depth, faces = images
    fields, owners = segment.fields, segment.owners
    if surfaces.sky.is_seen:
        _shade_sky(colour, faces, begin, count, fields, surfaces.sky)
    if (not (surfaces.has_textures or surfaces.has_plain)
            or not find_owners(begin, count, faces, surfaces.object_of, owners)):
        return
    first, end = np.uint64(0), count
    while first < end and owners[first] < 0:
        first += np.uint64(1)
    while first < end and owners[end - np.uint64(1)] < 0:
        end -= np.uint64(1)
    if first == end:
        return
    # The segment's pixels first .. end - 1, of which pixel i is begin + i of the images.
    pixels = begin, first, end
    _light(pixels, depth, faces, is_perspective, segment, surfaces)
    if surfaces.shadows.depth.size > 0:
        place_in_map(pixels, faces, is_perspective, fields, surfaces.fields, surfaces.shadows)
        shade_by_map(pixels, faces, fields, surfaces.fields, surfaces.shadows.depth)
    for k in range(surfaces.textures.shape[0]):
        if surfaces.textures[k, 1] > 0 and sees(pixels, owners, np.int32(k)):
            shade_by_texture(pixels, faces, is_perspective, segment, surfaces, k)
    _colour(pixels, colour, faces, segment, surfaces.ambient)


@wide_kernel
def _shade_sky(colour, faces, begin, count, fields, sky):
    """Write the colours of pixels that see nothing; see _shade."""
    for i in range(count):
        seen = sky_colour(sky, fields[COLUMN + i], fields[ROW + i])
        is_sky = faces[begin + i] == NO_FACE
        colour[begin + i] = seen if is_sky else colour[begin + i]


@wide_kernel
def _light(pixels, depth, faces, is_perspective, segment, surfaces):
    """Write DEPTH, SUNLIGHT and ADDED of pixels, and RED to BLUE of what has no texture."""
    begin, first, end = pixels
    fields, owners = segment.fields, segment.owners
    of_faces, on_screen = surfaces.of_faces, surfaces.fields
    is_specular, has_plain, colours = surfaces.is_specular, surfaces.has_plain, surfaces.colours
    one, zero = np.float32(1.0), np.float32(0.0)
    for i in range(first, end):
        u, v, s = fields[COLUMN + i], fields[ROW + i], depth[begin + i]
        mark = np.uint32(faces[begin + i] & ~OUTLINE)
        face = np.uint32(max(mark, np.uint32(1)) - np.uint32(1))
        z = one / s if is_perspective else -s
        fields[DEPTH + i] = z
        is_linear = on_screen[ON_SCREEN, face >> np.uint32(1)] > zero or not is_perspective
        scale = one if is_linear else z
        light = of_faces[SUN, face] + of_faces[SUN + 1, face] * u + of_faces[SUN + 2, face] * v
        fields[SUNLIGHT + i] = max(scale * light, zero)
        if is_specular:
            added = (of_faces[MIRRORED, face] + of_faces[MIRRORED + 1, face] * u
                     + of_faces[MIRRORED + 2, face] * v)
            fields[ADDED + i] = max(scale * added, zero)
        else:
            fields[ADDED + i] = zero
        if has_plain:
            k = np.uint32(max(owners[i], np.int32(0)))
            fields[RED + i], fields[GREEN + i] = colours[0, k], colours[1, k]
            fields[BLUE + i] = colours[2, k]


@wide_kernel
def _colour(pixels, colour, faces, segment, ambient):
    """Write the colours of pixels that are shaded."""
    begin, first, end = pixels
    fields, owners = segment.fields, segment.owners
    ambient, most = np.float32(ambient), np.float32(255.0)
    for i in range(first, end):
        share = DARKER if faces[begin + i] & OUTLINE else np.float32(1.0)
        light, added = share * (ambient + fields[SUNLIGHT + i]), share * fields[ADDED + i]
        shaded = pack_rgb(min(fields[RED + i] * light + added, most),
                          min(fields[GREEN + i] * light + added, most),
                          min(fields[BLUE + i] * light + added, most))
        colour[begin + i] = shaded if owners[i] >= 0 else colour[begin + i]
