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
Bands of rows: what a thread draws at a time.

A band's pixels fit in a processor's own cache, where they are cleared, drawn, averaged and turned
into bytes before the next band's turn. A thread takes the next band when it is done with one, so
that all end at about the same time, and one that comes late, for its processor was busy, finds
less to do.
"""
from typing import NamedTuple

from flag_sim.drawing.culling import triangles_in_rows
from flag_sim.drawing.depth import write_depth
from flag_sim.drawing.framebuffer import write_rgb
from flag_sim.drawing.multisample import (
    add_sample, average, begin_samples, mark_edges, TILE, Tiles, triangles_in_tiles)
from flag_sim.drawing.pixel_pass import shade_band, shade_sample
from flag_sim.drawing.pixels import BAND, LANES, Region
from flag_sim.drawing.polygon import new_polygon, Polygon
from flag_sim.drawing.rasterizer import rasterize, RasterizerState, Target
from flag_sim.drawing.segment import new_segment, Segment
from flag_sim.drawing.surfaces import Surfaces
from flag_sim.drawing.triangle_setup import Batch, new_batch
from flag_sim.drawing.visibility import NO_FACE, write_faces
from flag_sim.jit.kernels import late_kernel
from flag_sim.parallel.atomics import fetch_add

import numpy as np


class Buffers(NamedTuple):
    """
    One thread's buffers, in which it draws one band after another.

    colour, depth, faces: see rasterizer.Target, of a band's rows and one more above and below,
    `stride` pixels each; faces and segment are of size 0 if they are not wanted; in_band,
    in_tiles: indices of triangles; tiles: see multisample; batch, polygon: memory for the
    rasterizer.
    """

    colour: np.ndarray
    depth: np.ndarray
    faces: np.ndarray
    segment: Segment
    in_band: np.ndarray
    in_tiles: np.ndarray
    tiles: Tiles
    batch: Batch
    polygon: Polygon
    stride: int


def new_buffers(width: int, triangles: int, has_samples: bool, has_faces: bool,
                is_shaded: bool = False) -> Buffers:
    """Make Buffers for an image `width` pixels wide, and for so many triangles."""
    stride = -(-width // LANES) * LANES
    pixels, samples = (BAND + 2) * stride, BAND * stride * has_samples
    tiles = Tiles(
        np.zeros((BAND // TILE, stride // TILE), np.bool_), np.empty(stride, np.uint32),
        np.empty(samples, np.uint32), np.empty(samples, np.float32),
        np.empty((2, samples), np.uint32))
    return Buffers(np.empty(pixels, np.uint32), np.empty(pixels, np.float32),
                   np.empty(pixels * has_faces, np.uint32), new_segment(is_shaded),
                   *np.empty((2, triangles + 1), np.int32), tiles, new_batch(), new_polygon(),
                   stride)


class RenderSettings(NamedTuple):
    """
    How a frame is drawn, for the kernels.

    state: for the samples at the centres; pattern: (samples, 2) int32, where samples lie from the
    centre [subpixel], the centre first; clear_colour: packed, clear_depth: reversed Z, where
    nothing is; width, height: of the image; has_sky: whether what shows nothing is drawn too.
    """

    state: RasterizerState
    pattern: np.ndarray
    clear_colour: int
    clear_depth: float
    width: int
    height: int
    has_sky: bool


class Rare(NamedTuple):
    """What few pictures need; surfaces: None where no pixels are shaded one by one."""

    surfaces: Surfaces | None


@late_kernel
def draw_bands(taken, geometry, colours, order, settings, buffers, images, rare):
    """
    Draw bands of an image as long as there are any.

    taken: (1,) int64, how many bands were taken by this and other threads; colours: see
    rasterizer; order: see culling; settings: RenderSettings; images: of a Framebuffer; rare: Rare,
    or None where there are neither outlines, nor visibility, nor pixels that are shaded one by
    one, for which a smaller kernel is compiled.
    """
    dirty, height = images.dirty, settings.height
    # Edges are looked for across the band's border.
    border = 1 if settings.pattern.shape[0] > 1 else 0
    while True:
        band = fetch_add(taken, 0, 1)
        if band >= dirty.shape[1]:
            break
        begin, end = band * BAND, min((band + 1) * BAND, height)
        count, left, right = triangles_in_rows(order, begin - border, end + border,
                                               buffers.in_band)
        # The sky is everywhere.
        left = np.int64(0) if settings.has_sky else np.int64(left)
        right = np.int64(settings.width) if settings.has_sky else np.int64(right)
        last_left, last_right = dirty[0, band], dirty[1, band]
        dirty[0, band], dirty[1, band] = left, right
        left, right = min(left, last_left), max(right, last_right)
        if left < right:
            if border:
                # Neighbours are compared over the whole width.
                left, right = np.int64(0), np.int64(settings.width)
            region = Region(begin - border, 0, end - begin + 2 * border, left, right,
                            buffers.stride)
            _draw_band(geometry, colours, buffers.in_band[:np.int64(count)], settings, region,
                       buffers, images, rare)


@late_kernel
def _draw_band(geometry, colours, indices, settings, region, buffers, images, rare):
    """Draw a band: a Region with a row more above and below if there are several samples."""
    colour, depth, faces = buffers.colour, buffers.depth, buffers.faces
    is_perspective = geometry.transform.is_perspective
    clear(buffers, settings, region)
    target = Target(colour, depth, faces, region.top, region.top + region.rows, settings.width,
                    region.stride)
    # Two calls, for it is the same kernel whatever else is rare.
    if rare is None:
        rasterize(geometry, colours, indices, settings.state, target, buffers.batch,
                  buffers.polygon, None)
    else:
        rasterize(geometry, colours, indices, settings.state, target, buffers.batch,
                  buffers.polygon, True)
    border = 1 if settings.pattern.shape[0] > 1 else 0
    own = Region(region.top, border, region.rows - 2 * border, region.left, region.right,
                 region.stride)
    if images.depth.size > 0:
        write_depth(depth, own, is_perspective, images.depth)
    if rare is not None:
        if images.faces.size > 0:
            write_faces(faces, own, images.faces)
        shade_band(buffers, region, is_perspective, rare.surfaces)
    if border:
        _draw_samples(geometry, colours, indices, settings, own, buffers, rare)
    write_rgb(colour, own, settings.width, images.rgb, images.rgb_words)


@late_kernel
def _draw_samples(geometry, colours, indices, settings, own, buffers, rare):
    """Average the colours of tiles with edges in them over the samples of the pattern."""
    tiles, samples, stride = buffers.tiles, settings.pattern.shape[0], own.stride
    top, rows = own.top + 1, own.rows
    faces = buffers.faces[:0]
    if buffers.segment.fields.size > 0:
        faces = buffers.faces
    region = Region(top, 0, rows, 0, settings.width, stride)
    colour = buffers.colour[stride:]
    mark_edges(buffers.colour, region, settings.height, tiles)
    count = triangles_in_tiles(geometry, indices, region, tiles.mask, buffers.in_tiles)
    begin_samples(tiles, region, settings.clear_colour, settings.clear_depth, colour)
    faces[:] = NO_FACE
    # The first sample is the centre.
    for k in range(1, samples):
        state = RasterizerState(settings.pattern[k, 0], settings.pattern[k, 1],
                                settings.state.depth_ceiling, settings.state.is_outlined,
                                settings.state.is_perspective_correct)
        target = Target(tiles.colour, tiles.depth, faces, top, top + rows, settings.width, stride)
        in_tiles = buffers.in_tiles[:np.int64(count)]
        if rare is None:
            rasterize(geometry, colours, in_tiles, state, target, buffers.batch, buffers.polygon,
                      None)
        else:
            rasterize(geometry, colours, in_tiles, state, target, buffers.batch, buffers.polygon,
                      True)
            shade_sample(buffers, region, geometry.transform.is_perspective, rare.surfaces, state)
        add_sample(tiles, region, settings.clear_colour, settings.clear_depth)
    average(tiles, region, samples, colour)


@late_kernel
def clear(buffers, settings, region):
    """Clear a Region of the buffers."""
    colour, depth, faces = buffers.colour, buffers.depth, buffers.faces
    clear_colour, clear_depth = settings.clear_colour, settings.clear_depth
    for row in range(region.rows):
        first, last = np.uint64(row * region.stride + region.left), np.uint64(
            row * region.stride + region.right)
        for i in range(first, last):
            colour[i] = clear_colour
            depth[i] = clear_depth
        if faces.size > 0:
            faces[first:last] = NO_FACE
