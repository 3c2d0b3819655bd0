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

from flag_sim.drawing.attributes import Area, new_slots, NOTHING, Slots, write_visibility
from flag_sim.drawing.batched import Batch, new_batch
from flag_sim.drawing.culling import collect
from flag_sim.drawing.framebuffer import write_depth, write_rgb
from flag_sim.drawing.large import new_polygon, Polygon
from flag_sim.drawing.multisample import (
    add_sample, average, begin_samples, mark_edges, TILE, Tiles, touching)
from flag_sim.drawing.pixels import LANES
from flag_sim.drawing.visibility import Pass, rasterize, Target
from flag_sim.jit.kernels import kernel
from flag_sim.parallel.atomics import fetch_add

import numpy as np

BAND = 32


class Buffers(NamedTuple):
    """
    One thread's buffers, which it draws one band after another in.

    words, depths, numbers: colour, depth and slot buffer of a band's rows and of one more above
    and below, `stride` pixels each; numbers and slots are of size 0 if they are not wanted; found,
    touched: triangles' numbers; tiles: see multisample; batch, polygon: for the rasterizer's work
    in between.
    """

    words: np.ndarray
    depths: np.ndarray
    numbers: np.ndarray
    slots: Slots
    found: np.ndarray
    touched: np.ndarray
    tiles: Tiles
    batch: Batch
    polygon: Polygon
    stride: int


def new_buffers(width: int, triangles: int, has_samples: bool, slots: int) -> Buffers:
    """Make Buffers for an image `width` pixels wide, so many triangles and slots, 0 for none."""
    stride = -(-width // LANES) * LANES
    pixels, samples = (BAND + 2) * stride, BAND * stride * has_samples
    tiles = Tiles(
        np.zeros((BAND // TILE, stride // TILE), np.bool_), np.empty(stride, np.uint32),
        np.empty(samples, np.uint32), np.empty(samples, np.float32),
        np.empty((2, samples), np.uint32))
    return Buffers(np.empty(pixels, np.uint32), np.empty(pixels, np.float32),
                   np.empty(pixels if slots else 0, np.uint32), new_slots(slots),
                   *np.empty((2, triangles + 1), np.int32), tiles, new_batch(), new_polygon(),
                   stride)


class Plan(NamedTuple):
    """
    How a frame is drawn.

    how: of the centres' pass; pattern: (samples, 2) int32 [subpixel], the centre first;
    clear_colour, clear_depth: packed colour and reversed Z where nothing is; width, height: of
    the image.
    """

    how: Pass
    pattern: np.ndarray
    clear_colour: int
    clear_depth: float
    width: int
    height: int


@kernel
def draw_bands(taken, geometry, colours, order, plan, buffers, images):
    """
    Draw bands of an image as long as there are any.

    taken: (1,) int64, how many bands were taken by this and other threads; order: see culling;
    colours: see visibility; images: of a Framebuffer.
    """
    drawn, height = images.drawn, plan.height
    # Edges are looked for across the band's rim.
    rim = 1 if plan.pattern.shape[0] > 1 else 0
    while True:
        number = fetch_add(taken, 0, 1)
        if number >= drawn.shape[1]:
            break
        begin, end = number * BAND, min((number + 1) * BAND, height)
        count, left, right = collect(order, begin - rim, end + rim, buffers.found)
        last_left, last_right = drawn[0, number], drawn[1, number]
        drawn[0, number], drawn[1, number] = left, right
        left, right = min(left, last_left), max(right, last_right)
        if left < right:
            if rim:
                # Neighbours are compared over the whole width.
                left, right = np.int64(0), np.int64(plan.width)
            area = Area(begin - rim, 0, end - begin + 2 * rim, left, right, buffers.stride)
            draw_band(geometry, colours, buffers.found[:np.int64(count)], plan, area, buffers,
                      images)


@kernel
def draw_band(geometry, colours, numbers, plan, area, buffers, images):
    """Draw one band: an Area, with a row more above and below if there are samples."""
    words, depths, slots = buffers.words, buffers.depths, buffers.numbers
    clear(buffers, plan, area)
    rasterize(geometry, colours, numbers, plan.how,
              Target(words, depths, slots, buffers.slots, area.top, area.top + area.rows,
                     plan.width, area.stride), buffers.batch, buffers.polygon)
    rim = 1 if plan.pattern.shape[0] > 1 else 0
    own = Area(area.top, rim, area.rows - 2 * rim, area.left, area.right, area.stride)
    if images.depth.size > 0:
        write_depth(depths, own, geometry.lens.is_perspective, images.depth)
    if slots.size > 0:
        write_visibility(slots, depths, own, geometry.lens.is_perspective, buffers.slots,
                         images.seen)
    if rim:
        draw_samples(geometry, colours, numbers, plan, own, buffers)
    write_rgb(words, own, plan.width, images.rgb, images.rgb_words)


@kernel
def draw_samples(geometry, colours, numbers, plan, own, buffers):
    """Average the colours of tiles with edges in them over the samples of the pattern."""
    tiles, samples, stride = buffers.tiles, plan.pattern.shape[0], own.stride
    top, rows, none = own.top + 1, own.rows, buffers.numbers[:0]
    area = Area(top, 0, rows, 0, plan.width, stride)
    words = buffers.words[stride:]
    mark_edges(buffers.words, area, plan.height, tiles)
    count = touching(geometry, numbers, area, tiles.marks, buffers.touched)
    begin_samples(tiles, area, plan.clear_colour, plan.clear_depth, words)
    # The first sample is the centre.
    for k in range(1, samples):
        how = Pass(plan.pattern[k, 0], plan.pattern[k, 1], plan.how.ceiling,
                   plan.how.is_outlined, plan.how.is_perspective_correct)
        rasterize(geometry, colours, buffers.touched[:np.int64(count)], how,
                  Target(tiles.words, tiles.depths, none, buffers.slots, top, top + rows,
                         plan.width, stride), buffers.batch, buffers.polygon)
        add_sample(tiles, area, plan.clear_colour, plan.clear_depth)
    average(tiles, area, samples, words)


@kernel
def clear(buffers, plan, area):
    """Empty an Area."""
    words, depths, numbers = buffers.words, buffers.depths, buffers.numbers
    clear_colour, clear_depth = plan.clear_colour, plan.clear_depth
    for row in range(area.rows):
        first, last = np.uint64(row * area.stride + area.left), np.uint64(
            row * area.stride + area.right)
        for i in range(first, last):
            words[i] = clear_colour
            depths[i] = clear_depth
        if numbers.size > 0:
            numbers[first:last] = NOTHING
