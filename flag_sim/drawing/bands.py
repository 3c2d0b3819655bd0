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

A band's pixels fit in a processor's own cache, where they are emptied, drawn, averaged and turned
into bytes before the next band's turn. A thread takes the next band when it is done with one, so
that all end at about the same time, and one that comes late, for its processor was busy, finds
less to do.
"""
from typing import NamedTuple

from flag_sim.atomics import fetch_add
from flag_sim.drawing.attributes import (
    Area, NOTHING, PLANE, resolve_channels, resolve_colours, write_nothing)
from flag_sim.drawing.batched import Batch, LANES, new_batch
from flag_sim.drawing.culling import collect
from flag_sim.drawing.framebuffer import write_depth, write_rgb
from flag_sim.drawing.large import new_polygon, Polygon
from flag_sim.drawing.multisample import (
    add_sample, average, begin_samples, mark_edges, TILE, Tiles, touching)
from flag_sim.drawing.visibility import Pass, rasterize, Target
from flag_sim.kernels import kernel

import numpy as np

BAND = 32


class Buffers(NamedTuple):
    """
    One thread's buffers, which it draws one band after another in.

    words, depths, slots: colour, depth and slot buffer of a band's rows and of one more above and
    below, `stride` pixels each; table: see attributes; found, touched: triangles' numbers; tiles:
    see multisample; batch, polygon: for the rasterizer's work in between.
    """

    words: np.ndarray
    depths: np.ndarray
    slots: np.ndarray
    table: np.ndarray
    found: np.ndarray
    touched: np.ndarray
    tiles: Tiles
    batch: Batch
    polygon: Polygon


def new_buffers(width: int, triangles: int, planes: int, has_samples: bool) -> Buffers:
    """Make Buffers for an image `width` pixels wide, so many triangles, and planes in the table."""
    stride = stride_of(width)
    pixels, samples = (BAND + 2) * stride, BAND * stride * has_samples
    tiles = Tiles(
        np.zeros((BAND // TILE, stride // TILE), np.bool_), np.empty(stride, np.uint32),
        np.empty(samples, np.uint32), np.empty(samples, np.float32), np.empty(samples, np.uint32),
        np.empty((2, samples), np.uint32))
    return Buffers(np.empty(pixels, np.uint32), np.empty(pixels, np.float32),
                   np.empty(pixels, np.uint32), np.empty(planes * PLANE, np.float32),
                   *np.empty((2, triangles + 1), np.int32), tiles, new_batch(), new_polygon())


def stride_of(width: int) -> int:
    """Return how many pixels a row of buffers has: whole vectors."""
    return -(-width // LANES) * LANES


class Plan(NamedTuple):
    """
    How a frame is drawn.

    how: of the centres' pass; pattern: (samples, 2) int32 [subpixel], the centre first;
    clear_depth: reversed Z where nothing is, float32; width, height: of the image.
    """

    how: Pass
    pattern: np.ndarray
    clear_depth: float
    width: int
    height: int


@kernel
def draw_bands(taken, geometry, order, values, plan, buffers, images):
    """
    Draw bands of an image as long as there are any.

    taken: (1,) int64, how many bands were taken by this and other threads; order: see culling;
    values: see attributes; images: of a Framebuffer.
    """
    drawn, height = images.drawn, plan.height
    while True:
        number = fetch_add(taken, 0, 1)
        if number >= drawn.shape[1]:
            break
        begin, end = number * BAND, min((number + 1) * BAND, height)
        # Edges are looked for across the band's rim.
        rim = 1 if plan.pattern.shape[0] > 1 else 0
        count, left, right = collect(order, begin - rim, end + rim, buffers.found)
        last_left, last_right = drawn[0, number], drawn[1, number]
        drawn[0, number], drawn[1, number] = left, right
        left, right = min(left, last_left), max(right, last_right)
        if left < right:
            if rim:
                # Neighbours are compared over the whole width.
                left, right = np.int64(0), np.int64(plan.width)
            stride = buffers.words.size // (BAND + 2)
            area = Area(begin - rim, 0, end - begin + 2 * rim, left, right, stride)
            draw_band(geometry, buffers.found[:np.int64(count)], values, plan, area, buffers, images)


@kernel
def draw_band(geometry, numbers, values, plan, area, buffers, images):
    """Draw one band: an Area, with a row more above and below if there are samples."""
    words, depths, slots, table = buffers.words, buffers.depths, buffers.slots, buffers.table
    how, is_perspective = plan.how, geometry.lens.is_perspective
    clear(depths, slots, plan.clear_depth, area)
    write_nothing(values, how.groups, table)
    rasterize(geometry, numbers, how, values, table,
              Target(depths, slots, area.top, area.top + area.rows, plan.width, area.stride),
              buffers.batch, buffers.polygon)
    resolve_colours(slots, depths, area, values, how.groups, table, words)
    rim = 1 if plan.pattern.shape[0] > 1 else 0
    own = Area(area.top, rim, area.rows - 2 * rim, area.left, area.right, area.stride)
    if images.depth.size > 0:
        write_depth(depths, own, is_perspective, images.depth)
    for group in range(1, how.groups):
        resolve_channels(slots, depths, own, values, group, table, images.channels[group - 1])
    if rim:
        draw_samples(geometry, numbers, values, plan, own, buffers)
    write_rgb(words, own, plan.width, images.rgb, images.rgb_words)


@kernel
def draw_samples(geometry, numbers, values, plan, own, buffers):
    """Average the colours of tiles with edges in them over the samples of the pattern."""
    tiles, samples, stride = buffers.tiles, plan.pattern.shape[0], own.stride
    top, rows = own.top + 1, own.rows
    area = Area(top, 0, rows, 0, plan.width, stride)
    words = buffers.words[stride:]
    mark_edges(buffers.words, area, plan.height, tiles)
    count = touching(geometry, numbers, area, tiles.marks, buffers.touched)
    begin_samples(tiles, area, plan.clear_depth, words)
    # The first sample is the centre.
    for k in range(1, samples):
        how = Pass(plan.pattern[k, 0], plan.pattern[k, 1], plan.how.ceiling,
                   plan.how.is_outlined, 1)
        write_nothing(values, 1, buffers.table)
        rasterize(geometry, buffers.touched[:np.int64(count)], how, values, buffers.table,
                  Target(tiles.depths, tiles.slots, top, top + rows, plan.width, stride),
                  buffers.batch, buffers.polygon)
        add_sample(tiles, area, plan.clear_depth, values, buffers.table)
    average(tiles, area, samples, words)


@kernel
def clear(depths, slots, clear_depth, area):
    """Empty an Area."""
    for row in range(area.rows):
        first = np.uint64(row * area.stride)
        for i in range(first + np.uint64(area.left), first + np.uint64(area.right)):
            depths[i] = clear_depth
            slots[i] = NOTHING
