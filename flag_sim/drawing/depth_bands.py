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

from flag_sim.drawing.batched import along, bounds, needed_blocks
from flag_sim.drawing.culling import LARGE, MEDIUM, triangles_in_rows
from flag_sim.drawing.pixels import BAND, clamp, LANES, WHOLE_VECTORS
from flag_sim.drawing.polygon import assemble_polygon, new_polygon, Polygon
from flag_sim.drawing.rasterizer import RasterizerState, Target
from flag_sim.drawing.scanline import draw_large
from flag_sim.drawing.triangle_setup import (
    AB, BATCH, Batch, BC, CA, COLUMNS, DU, DV, EDGE, EDGE_DU, EDGE_DV, END, gather, LEFT,
    new_batch, set_up, START, TOP)
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
    integers, planes, depth = batch.integers, batch.planes, target.depth
    begin, end, stride = target.top, target.end, target.stride
    for k in range(count):
        # Read once, for a row has few pixels.
        top = integers[TOP + k]
        columns = (np.uint64(integers[COLUMNS + k]) + np.uint64(LANES - 1)) & WHOLE_VECTORS
        edges = (integers[EDGE + AB + k], integers[EDGE + CA + k], integers[EDGE + BC + k])
        edges_dv = (integers[EDGE_DV + AB + k], integers[EDGE_DV + CA + k],
                    integers[EDGE_DV + BC + k])
        edges_du = (integers[EDGE_DU + AB + k], integers[EDGE_DU + CA + k],
                    integers[EDGE_DU + BC + k])
        s, s_dv, s_du = planes[START + k], planes[DV + k], planes[DU + k]
        least_and_most = bounds(batch, k, np.uint64(0))
        for row in range(max(top, begin), min(integers[END + k], end)):
            y = np.int32(row - top)
            first = np.uint64((row - begin) * stride + integers[LEFT + k])
            blocks = np.uint64(0), columns, first
            if is_medium:
                blocks = needed_blocks(k, y, first, batch)
            here = (along(edges[0], y, edges_dv[0]), along(edges[1], y, edges_dv[1]),
                    along(edges[2], y, edges_dv[2]))
            _draw_row(blocks, here, edges_du, (s + s_dv * np.float32(y), s_du), least_and_most,
                      depth)


@late_inner_kernel
def _draw_row(blocks, edges, edges_du, s_and_change, least_and_most, depth):
    start, columns, first = blocks
    s, s_du = s_and_change
    least, most = least_and_most
    for j in range(columns & WHOLE_VECTORS):
        n = np.int32(np.int32(start) + np.int32(j))
        is_inside = (along(edges[0], n, edges_du[0]) | along(edges[1], n, edges_du[1])
                     | along(edges[2], n, edges_du[2])) >= 0
        here = clamp(s + s_du * np.float32(n), least, most)
        depth[first + j] = max(here if is_inside else np.float32(-np.inf), depth[first + j])
