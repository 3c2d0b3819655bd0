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
Samples at edges: the idea of the A-buffer (Carpenter, 1984), with coverage held per sample.

The frame is drawn once with a sample at each pixel's centre. Only tiles in which neighbouring
pixels then differ are drawn again, once for each sample, and averaged: elsewhere the colour is
smooth, and the centre's is the average already. What is so thin that it slips between all pixel
centres of a tile and of its rim is not found, and stays as it is with one sample.
"""
from flag_sim.drawing.bands import next_row
from flag_sim.drawing.clipping import INSIDE, NOWHERE
from flag_sim.kernels import kernel

import numpy as np

# Pixels along a tile's side: one vector, and a whole number to a band.
TILE = 8
# Neighbours that differ by more levels than this in a channel have an edge between them.
CONTRAST = 6


def _centred(cells):
    """Put a sample in row cells[k] of column k, about the pixel's centre: (n, 2) [pixel]."""
    count = len(cells)
    points = (np.column_stack([np.arange(count), cells]) + 0.5) / count - 0.5
    points.flags.writeable = False
    return points


# Rooks, of which none attacks another, so that edges along rows and columns have all levels.
# 4 is the rotated grid, 8 the lattice that misses the area beside edges of random direction least,
# 16 the pattern of Direct3D 11.1 (functional specification, 19.2.4.1).
PATTERNS = {
    1: _centred([0]),
    4: _centred([2, 0, 3, 1]),
    8: _centred([4, 1, 6, 3, 0, 5, 2, 7]),
    16: _centred([8, 0, 12, 6, 2, 10, 14, 5, 1, 9, 13, 3, 7, 11, 15, 4]),
}


def no_marks():
    """Give marks that no tile has: then all of the image is drawn."""
    return np.empty((0, 0), np.bool_)


def marks_for(width, height):
    """Make marks for an image's tiles: (rows of tiles, columns of tiles) bool."""
    return np.zeros((-(-height // TILE), -(-width // TILE)), np.bool_)


@kernel
def mark_edges(words, width, height, band, bands, worst, marks):
    """
    Mark the tiles of some bands where neighbours differ, within them or across their rim.

    words: (height width,) at least, uint32; worst: (width + TILE,) uint32, for the work in
    between.
    """
    top = next_row(0, band, bands)
    while top < height:
        first, last = max(top - 1, 0), min(top + TILE, height - 1)
        worst[:] = 0
        for row in range(first, last + 1):
            here = np.uint64(row * width)
            # The last row is its own neighbour below.
            below = np.uint64(width if row < last else 0)
            for j in range(np.uint64(width - 1)):
                word = words[here + j]
                worst[j] |= (_differs(word, words[here + j + np.uint64(1)])
                             | _differs(word, words[here + j + below]))
            here += np.uint64(width - 1)
            worst[width - 1] |= _differs(words[here], words[here + below])
        for tile in range(marks.shape[1]):
            # A difference belongs to both neighbours, so the pixel before counts too.
            found = worst[max(tile * TILE - 1, 0)]
            for j in range(TILE):
                found |= worst[tile * TILE + j]
            marks[top // TILE, tile] = found != 0
        top = next_row(top + TILE, band, bands)


@kernel
def touching(triangles, order, screen, where, marks, width, height, band, bands, found):
    """
    Collect in `found` those of `order` that can touch a marked tile of the bands; count them.

    All but triangles that are INSIDE are taken to touch.
    """
    count = 0
    for t in order:
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        state = where[a] | where[b] | where[c]
        if state >= NOWHERE:
            continue
        is_found = state != INSIDE
        if not is_found:
            # Samples lie within half a pixel of the centre, and outlines half a pixel farther.
            left = min(screen[a, 0], screen[b, 0], screen[c, 0]) - 1.0
            right = max(screen[a, 0], screen[b, 0], screen[c, 0]) + 1.0
            top = min(screen[a, 1], screen[b, 1], screen[c, 1]) - 1.0
            bottom = max(screen[a, 1], screen[b, 1], screen[c, 1]) + 1.0
            if right < 0.0 or bottom < 0.0 or left > width - 1.0 or top > height - 1.0:
                continue
            row = next_row(int(max(top, 0.0)), band, bands)
            last = int(min(bottom, height - 1.0))
            tile_first = int(max(left, 0.0)) // TILE
            tile_last = int(min(right, width - 1.0)) // TILE
            while row <= last and not is_found:
                for tile in range(tile_first, tile_last + 1):
                    is_found |= marks[row // TILE, tile]
                row = next_row((row // TILE + 1) * TILE, band, bands)
        if is_found:
            found[count] = t
            count += 1
    return count


@kernel
def clear_marked(marks, width, height, band, bands, word, farthest, words, nearness, sums):
    """Empty the marked tiles of the bands before the first sample is drawn."""
    top = next_row(0, band, bands)
    while top < height:
        for tile in range(marks.shape[1]):
            if not marks[top // TILE, tile]:
                continue
            for row in range(top, min(top + TILE, height)):
                begin = row * width + tile * TILE
                for i in range(begin, begin + min(TILE, width - tile * TILE)):
                    words[i] = word
                    nearness[i] = farthest
                    sums[0, i] = sums[1, i] = 0
        top = next_row(top + TILE, band, bands)


@kernel
def add_sample(marks, width, height, band, bands, word, farthest, words, nearness, sums):
    """
    Add a sample's colours to the sums and empty its tiles for the next.

    sums: (2, height width) uint32: [0] red and blue, [1] green, 16 bits each.
    """
    top = next_row(0, band, bands)
    while top < height:
        for tile in range(marks.shape[1]):
            if not marks[top // TILE, tile]:
                continue
            for row in range(top, min(top + TILE, height)):
                begin = row * width + tile * TILE
                for i in range(begin, begin + min(TILE, width - tile * TILE)):
                    sums[0, i] += words[i] & np.uint32(0xff00ff)
                    sums[1, i] += words[i] >> np.uint32(8) & np.uint32(0xff)
                    words[i] = word
                    nearness[i] = farthest
        top = next_row(top + TILE, band, bands)


@kernel
def resolve(marks, width, height, band, bands, samples, sums, words):
    """Write the sums of `samples` (4, 8 or 16) samples, averaged and rounded, as colours."""
    half = np.uint32(samples // 2)
    top = next_row(0, band, bands)
    while top < height:
        for tile in range(marks.shape[1]):
            if not marks[top // TILE, tile]:
                continue
            for row in range(top, min(top + TILE, height)):
                begin = row * width + tile * TILE
                for i in range(begin, begin + min(TILE, width - tile * TILE)):
                    red = ((sums[0, i] & np.uint32(0xffff)) + half) // np.uint32(samples)
                    green = (sums[1, i] + half) // np.uint32(samples)
                    blue = ((sums[0, i] >> np.uint32(16)) + half) // np.uint32(samples)
                    words[i] = red | green << np.uint32(8) | blue << np.uint32(16)
        top = next_row(top + TILE, band, bands)


@kernel
def _differs(one, other):
    """Give a word that is not 0 where two colours differ by more than CONTRAST in a channel."""
    found = np.uint32(0)
    for place in (np.uint32(0), np.uint32(8), np.uint32(16)):
        p = one >> place & np.uint32(0xff)
        q = other >> place & np.uint32(0xff)
        # In unsigned arithmetic what is below -CONTRAST is large, like what is above it.
        found |= np.uint32(p - q + np.uint32(CONTRAST) > np.uint32(2 * CONTRAST))
    return found
