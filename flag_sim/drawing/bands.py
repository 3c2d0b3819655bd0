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
from flag_sim.atomics import fetch_add
from flag_sim.drawing.canvas import write_reversed_z, write_rgb
from flag_sim.drawing.culling import collect
from flag_sim.drawing.rasterizer import fill
from flag_sim.drawing.spans import LANES
from flag_sim.drawing.tiles import (
    add_sample, clear_marked, mark_edges, resolve, TILE, touching)
from flag_sim.kernels import kernel

import numpy as np

BAND = 32


class Buffers:
    """
    One thread's buffers, which it draws one band after another in.

    words, depths: colours and reversed Z of a band's rows and of one more above and below,
    `stride` pixels each; sample_words, sample_depths, sums, marks, worst: see tiles; found,
    touching: triangles' numbers.
    """

    def __init__(self, width, triangles, has_samples):
        """Make buffers for an image `width` pixels wide and that number of triangles."""
        self.kind = width, triangles, has_samples
        self.stride = -(-width // LANES) * LANES
        pixels = (BAND + 2) * self.stride
        samples = BAND * self.stride * has_samples
        self.arrays = (
            np.empty(pixels, np.uint32), np.empty(pixels, np.float32),
            np.empty(triangles + 1, np.int32), np.empty(triangles + 1, np.int32),
            np.empty(samples, np.uint32), np.empty(samples, np.float32),
            np.empty((2, samples), np.uint32), np.empty(self.stride, np.uint32),
            np.zeros((BAND // TILE, self.stride // TILE), np.bool_))


# So many arguments, and not a few tuples of them: those made the whole 4 to 6 % slower. It is not
# the call, which tuples of the same arrays lengthen by 0.1 us (named ones by 1 us); what else it
# is was not found.
@kernel
def draw_bands(taken, triangles, order, spans, boxes, kinds, closed, view, u, v, reversed_z,
               outcodes, colours, is_flat, cu, cv, near, is_perspective, is_perspective_correct,
               is_painter, is_outlined, pattern, clear_colour, clear_depth, width, height, stride,
               words, depths, found, touched, sample_words, sample_depths, sums, worst, marks,
               drawn, rgb, rgb_words, reversed_z_image):
    """
    Draw bands of an image as long as there are any.

    taken: (1,) int64, how many bands were taken by this and other threads; order, spans, boxes,
    kinds: see culling; from view to is_outlined: see rasterizer.fill;
    pattern: (samples, 2) int32 [subpixel], the centre first; clear_colour, clear_depth: colour and
    reversed Z where nothing is; from stride to marks: of Buffers; drawn: (2, bands of the image)
    int32, first column and end of what the last frame drew, renewed; rgb, rgb_words,
    reversed_z_image: a Canvas's.
    """
    samples = pattern.shape[0]
    no_marks = marks[:0]
    while True:
        number = fetch_add(taken, 0, 1)
        if number >= drawn.shape[1]:
            break
        begin, end = number * BAND, min((number + 1) * BAND, height)
        # Edges are looked for across the band's rim.
        rim = 1 if samples > 1 else 0
        top = begin - rim
        count, left, right = collect(order, spans, boxes, top, end + rim, found)
        last_left, last_right = drawn[0, number], drawn[1, number]
        drawn[0, number], drawn[1, number] = left, right
        last_left, last_right = min(left, last_left), max(right, last_right)
        if last_left >= last_right:
            continue
        rows = end - begin
        if samples > 1:
            # Neighbours are compared over the whole width.
            last_left, last_right = np.int32(0), np.int32(width)
        clear(words, depths, clear_colour, clear_depth, last_left, last_right, rows + 2 * rim,
              stride)
        fill(triangles, found, count, kinds, closed, view, u, v, reversed_z, outcodes, colours,
             is_flat, cu, cv, near, is_perspective, is_perspective_correct, is_painter,
             is_outlined, np.int32(0), np.int32(0), no_marks, top, end + rim, width, stride,
             depths, words)
        if reversed_z_image.size > 0:
            write_reversed_z(depths[rim * stride:], begin, rows, last_left, last_right, width,
                             stride, reversed_z_image)
        own = words[rim * stride:]
        if samples > 1:
            mark_edges(words, begin, end, width, height, stride, worst, marks)
            count = touching(triangles, found, count, u, v, outcodes, marks, begin, end, width,
                             touched)
            clear_marked(marks, rows, stride, clear_colour, clear_depth, own, sample_words,
                         sample_depths, sums)
            # The first sample is the centre.
            for k in range(1, samples):
                fill(triangles, touched, count, kinds, closed, view, u, v, reversed_z, outcodes,
                     colours, is_flat, cu, cv, near, is_perspective, is_perspective_correct,
                     is_painter, is_outlined, pattern[k, 0], pattern[k, 1], marks, begin, end,
                     width, stride, sample_depths, sample_words)
                add_sample(marks, rows, stride, clear_colour, clear_depth, sample_words,
                           sample_depths, sums)
            resolve(marks, rows, stride, samples, sums, own)
        write_rgb(own, begin, rows, last_left, last_right, width, stride, rgb, rgb_words)


@kernel
def clear(words, depths, clear_colour, clear_depth, left, right, rows, stride):
    """Empty columns left .. right - 1 of all rows."""
    for row in range(rows):
        first = np.uint64(row * stride)
        for i in range(first + np.uint64(left), first + np.uint64(right)):
            words[i] = clear_colour
            depths[i] = clear_depth
