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
Multisampling: several samples a pixel, where there are edges.

The frame is drawn once with a sample at each pixel's centre. Only tiles in which neighbouring
pixels then differ are drawn again, once for each further sample of the pattern, with coverage and
depth held per sample, as in the A-buffer (Carpenter, 1984). All samples are averaged, the
centre's too, for it is there already: elsewhere the colour is smooth, and the centre's is the
average. What is so thin that it slips between all pixel centres of a tile and its border is not
found, and stays as it is with one sample.
"""
from typing import NamedTuple

from flag_sim.drawing.clipping import INSIDE
from flag_sim.drawing.geometry import SUBPIXEL_BITS, SUBPIXELS
from flag_sim.jit.kernels import late_kernel

import numpy as np

# Pixels along a tile's side: one vector, and a whole number to a band.
TILE = 8
# Neighbours that differ by more levels than this in a channel have an edge between them.
CONTRAST = 6


def _about_the_centre(*offsets):
    """Return the centre, `offsets` [subpixel] and their mirror images: (n, 2) [pixel]."""
    half = np.array(offsets).reshape(-1, 2)
    points = np.concatenate([np.zeros((1, 2)), half, -half]) / SUBPIXELS
    points.flags.writeable = False
    return points


# By the number of samples beside the centre. All are rooks, of which none attacks another, so that
# edges along rows and columns have all levels. Among these they miss the area beside a straight
# edge, squared and averaged over where it lies, least (test_samples.py): by equal parts for
# edges of all directions, for those that level cameras see, and for those of the default camera.
PATTERNS = {
    1: _about_the_centre(),
    4: _about_the_centre((-100, -59), (-52, 95)),
    8: _about_the_centre((-112, -39), (-85, 47), (-55, -88), (-31, 110)),
    16: _about_the_centre((-119, 18), (-104, -85), (-91, 80), (-75, -24),
                          (-60, 115), (-45, -109), (-31, 60), (-16, -45)),
}


class Tiles(NamedTuple):
    """
    Which tiles of a band are drawn with more samples, and what becomes of them.

    mask: (BAND / TILE, stride / TILE) bool, the tile mask; differences: (stride,) uint32, not 0
    in columns where neighbours differ, memory for mark_edges; colour, depth: the buffers of one
    sample, like those of the centres (see bands); sums: (2, pixels) uint32: [0] red and blue, [1]
    green, 16 bits each.
    """

    mask: np.ndarray
    differences: np.ndarray
    colour: np.ndarray
    depth: np.ndarray
    sums: np.ndarray


@late_kernel
def mark_edges(colour, region, height, tiles):
    """
    Mark the tiles of a Region where neighbours differ, in them or across their border.

    colour: of the rows from region.top - 1 on, one more than the region has above and below;
    height: of the image.
    """
    mask, differences, stride = tiles.mask, tiles.differences, region.stride
    begin, end, width = region.top, region.top + region.rows, region.right
    for tile_row in range((end - begin + TILE - 1) // TILE):
        first = max(begin + tile_row * TILE - 1, 0)
        last = min(begin + tile_row * TILE + TILE, height - 1)
        differences[:] = 0
        for row in range(first, last + 1):
            here = np.uint64((row - begin + 1) * stride)
            # The last row is its own neighbour below.
            below = np.uint64(stride if row < last else 0)
            for j in range(np.uint64(width - 1)):
                pixel = colour[here + j]
                differences[j] |= (_differs(pixel, colour[here + j + np.uint64(1)])
                                   | _differs(pixel, colour[here + j + below]))
            here += np.uint64(width - 1)
            differences[width - 1] |= _differs(colour[here], colour[here + below])
        for tile in range(mask.shape[1]):
            # A difference belongs to both neighbours, so the pixel before counts too.
            found = differences[max(tile * TILE - 1, 0)]
            for j in range(TILE):
                found |= differences[tile * TILE + j]
            mask[tile_row, tile] = found != 0


@late_kernel
def triangles_in_tiles(geometry, indices, region, mask, found):
    """
    Collect in `found` those of the triangles with `indices` that can touch a marked tile.

    Returns how many. Triangles that are not INSIDE are all taken to touch one.
    """
    triangles, vertices = geometry.triangles, geometry.vertices
    u, v, outcodes = vertices.u, vertices.v, vertices.outcodes
    begin, end, width = region.top, region.top + region.rows, region.right
    kept = np.uint64(0)
    for k in range(np.uint64(indices.size)):
        t = indices[k]
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        touches = (outcodes[a] | outcodes[b] | outcodes[c]) != INSIDE
        if not touches:
            # Samples lie within half a pixel of the centre, and outlines half a pixel farther.
            left = max((min(u[a], u[b], u[c]) >> SUBPIXEL_BITS) - 1, 0)
            right = min((max(u[a], u[b], u[c]) >> SUBPIXEL_BITS) + 2, width - 1)
            top = max((min(v[a], v[b], v[c]) >> SUBPIXEL_BITS) - 1, begin)
            bottom = min((max(v[a], v[b], v[c]) >> SUBPIXEL_BITS) + 2, end - 1)
            if left <= right and top <= bottom:
                for row in range((top - begin) // TILE, (bottom - begin) // TILE + 1):
                    for tile in range(left // TILE, right // TILE + 1):
                        touches |= mask[row, tile]
        found[kept] = t
        kept += np.uint64(touches)
    return kept


@late_kernel
def begin_samples(tiles, region, clear_colour, clear_depth, centres):
    """Clear the marked tiles, and begin the sums with the colours at the centres."""
    mask, sums = tiles.mask, tiles.sums
    for row in range(region.rows):
        for tile in range(mask.shape[1]):
            if mask[row // TILE, tile]:
                first = np.uint64(row * region.stride + tile * TILE)
                for i in range(first, first + np.uint64(TILE)):
                    tiles.colour[i] = clear_colour
                    tiles.depth[i] = clear_depth
                    sums[0, i] = centres[i] & np.uint32(0xff00ff)
                    sums[1, i] = centres[i] >> np.uint32(8) & np.uint32(0xff)


@late_kernel
def add_sample(tiles, region, clear_colour, clear_depth):
    """Add a sample's colours to the sums, and clear its tiles for the next one."""
    mask, colour, sums = tiles.mask, tiles.colour, tiles.sums
    for row in range(region.rows):
        for tile in range(mask.shape[1]):
            if mask[row // TILE, tile]:
                first = np.uint64(row * region.stride + tile * TILE)
                for i in range(first, first + np.uint64(TILE)):
                    sums[0, i] += colour[i] & np.uint32(0xff00ff)
                    sums[1, i] += colour[i] >> np.uint32(8) & np.uint32(0xff)
                    colour[i] = clear_colour
                    tiles.depth[i] = clear_depth


@late_kernel
def average(tiles, region, samples, colour):
    """Write the sums of `samples` samples, averaged and rounded, as colours."""
    mask, sums, half = tiles.mask, tiles.sums, np.uint32(samples // 2)
    for row in range(region.rows):
        for tile in range(mask.shape[1]):
            if mask[row // TILE, tile]:
                first = np.uint64(row * region.stride + tile * TILE)
                for i in range(first, first + np.uint64(TILE)):
                    red = ((sums[0, i] & np.uint32(0xffff)) + half) // np.uint32(samples)
                    green = (sums[1, i] + half) // np.uint32(samples)
                    blue = ((sums[0, i] >> np.uint32(16)) + half) // np.uint32(samples)
                    colour[i] = red | green << np.uint32(8) | blue << np.uint32(16)


@late_kernel
def _differs(one, other):
    """Return what is not 0 where two colours differ by more than CONTRAST in a channel."""
    found = np.uint32(0)
    for bits in (np.uint32(0), np.uint32(8), np.uint32(16)):
        p = one >> bits & np.uint32(0xff)
        q = other >> bits & np.uint32(0xff)
        # In unsigned arithmetic what is below -CONTRAST is large, like what is above it.
        found |= np.uint32(p - q + np.uint32(CONTRAST) > np.uint32(2 * CONTRAST))
    return found
