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
Bands of a depth map: what is drawn where no colours are wanted.

The map itself is what is drawn into, and holds reversed Z: no pixel is shaded, copied or turned
into bytes. Triangles are those of a picture (see rasterizer), and so are their depths.
"""
from typing import NamedTuple

from flag_sim.drawing.batched import along, bounds, needed_blocks, value_in_row
from flag_sim.drawing.culling import LARGE, MEDIUM, triangles_in_rows
from flag_sim.drawing.pixels import BAND, clamp, LANES, WHOLE_VECTORS
from flag_sim.drawing.polygon import assemble_polygon, new_polygon, Polygon
from flag_sim.drawing.rasterizer import RasterizerState, Target
from flag_sim.drawing.scanline import draw_large
from flag_sim.drawing.triangle_setup import (
    AB, BATCH, Batch, BC, CA, COLUMNS, EDGE, EDGE_DU, EDGE_DV, END, gather, LEFT, new_batch,
    set_up, TOP)
from flag_sim.jit.kernels import late_inner_kernel, late_kernel
from flag_sim.parallel.atomics import fetch_add

import numpy as np

STATE = RasterizerState(np.int32(0), np.int32(0), np.float32(np.inf), False, False)


class DepthBuffers(NamedTuple):
    """
    One thread's buffers; colour: a band's, which nobody reads; the others: see bands.Buffers.

    faces: of size 0, for the rasterizer.
    """

    colour: np.ndarray
    faces: np.ndarray
    in_band: np.ndarray
    batch: Batch
    polygon: Polygon


def new_depth_buffers(width: int, triangles: int) -> DepthBuffers:
    """Make DepthBuffers for a map `width` texels wide, and for so many triangles."""
    return DepthBuffers(np.empty(BAND * width, np.uint32), np.empty(0, np.uint32),
                        np.empty(triangles + 1, np.int32), new_batch(), new_polygon())


@late_kernel
def draw_depth_bands(taken, geometry, colours, order, clear_depth, buffers, depth, dirty):
    """
    Draw bands of a depth map as long as there are any.

    taken, dirty: see bands.draw_bands and framebuffer.Images; order: see culling; colours: any for
    the geometry; clear_depth: reversed Z where nothing is; depth: (height, width) float32 of
    reversed Z, a multiple of LANES wide.
    """
    height, width = depth.shape
    texels = depth.reshape(-1)
    while True:
        band = fetch_add(taken, 0, 1)
        if band >= dirty.shape[1]:
            break
        begin, end = band * BAND, min((band + 1) * BAND, height)
        count, left, right = triangles_in_rows(order, begin, end, buffers.in_band)
        left, right = np.int64(left), np.int64(right)
        last_left, last_right = dirty[0, band], dirty[1, band]
        dirty[0, band], dirty[1, band] = left, right
        for row in range(begin, end):
            for i in range(np.uint64(row * width + min(left, last_left)),
                           np.uint64(row * width + max(right, last_right))):
                texels[i] = clear_depth
        target = Target(buffers.colour, texels[begin * width:end * width], buffers.faces, begin,
                        end, width, width)
        _draw_triangles(geometry, colours, buffers.in_band[:np.int64(count)], target,
                        buffers.batch, buffers.polygon)


@late_kernel
def _draw_triangles(geometry, colours, indices, target, batch, polygon):
    """Draw the depth of triangles: see rasterizer.rasterize."""
    sizes, count = geometry.sizes, np.uint64(indices.size)
    k = np.uint64(0)
    while k < count:
        first, size = k, sizes[indices[k]]
        if size != LARGE:
            while k < count and k - first < BATCH and sizes[indices[k]] == size:
                k += np.uint64(1)
            kept = gather(geometry, None, indices[np.int64(first):np.int64(k)], STATE, batch)
            set_up(None, kept, target.width, False, batch)
            _draw_batch(kept, size == MEDIUM, batch, target)
            continue
        triangle = np.int64(indices[k])
        k += np.uint64(1)
        corners, side = assemble_polygon(geometry, colours, triangle, STATE, polygon)
        for corner in range(2, corners):
            draw_large(polygon, corner, 2 * triangle + side, STATE, target, None)


@late_kernel
def _draw_batch(count, is_medium, batch, target):
    """Draw the depth of a batch's triangles."""
    integers, begin, end, stride = batch.integers, target.top, target.end, target.stride
    for k in range(count):
        top = integers[TOP + k]
        columns = (np.uint64(integers[COLUMNS + k]) + np.uint64(LANES - 1)) & WHOLE_VECTORS
        for row in range(max(top, begin), min(integers[END + k], end)):
            y = np.int32(row - top)
            first = np.uint64((row - begin) * stride + integers[LEFT + k])
            blocks = np.uint64(0), columns, first
            if is_medium:
                blocks = needed_blocks(k, y, first, batch)
            _draw_row((k, y), blocks, batch, target.depth)


@late_inner_kernel
def _draw_row(triangle_row, blocks, batch, depth):
    k, y = triangle_row
    start, columns, first = blocks
    integers = batch.integers
    ab_du, ca_du, bc_du = (integers[EDGE_DU + AB + k], integers[EDGE_DU + CA + k],
                           integers[EDGE_DU + BC + k])
    ab = along(integers[EDGE + AB + k], y, integers[EDGE_DV + AB + k])
    ca = along(integers[EDGE + CA + k], y, integers[EDGE_DV + CA + k])
    bc = along(integers[EDGE + BC + k], y, integers[EDGE_DV + BC + k])
    s, ds = value_in_row(batch.planes, k, np.uint64(0), y)
    s_least, s_most = bounds(batch, k, np.uint64(0))
    for j in range(columns & WHOLE_VECTORS):
        n = np.int32(np.int32(start) + np.int32(j))
        is_inside = (along(ab, n, ab_du) | along(ca, n, ca_du) | along(bc, n, bc_du)) >= 0
        here = clamp(s + ds * np.float32(n), s_least, s_most)
        depth[first + j] = max(here if is_inside else np.float32(-np.inf), depth[first + j])
