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

"""Culling: which triangles can be seen at all, and in which rows, once a frame for all bands."""
from typing import NamedTuple

from flag_sim.drawing.clipping import INSIDE, INVALID
from flag_sim.drawing.geometry import next_centre, SUBPIXELS
from flag_sim.jit.kernels import late_kernel

import numpy as np

# Consecutive triangles that share a bounding box, so that a band skips most of them at once.
CHUNK = 64
# How a triangle is drawn (see rasterizer): LARGE ones one by one; others in batches, MEDIUM ones
# only in those blocks of their rows that can have pixels inside, SMALL ones in all blocks, for
# these are so few that to find out would take longer.
LARGE, MEDIUM, SMALL = range(3)
# Up to which widths [subpixel]; a matter of speed, but the edge functions of what is drawn in
# batches must stay below 2^31. Up to 64 pixels they do: no two vertices are more than 2^23
# subpixels apart (see GUARD_BAND), and blocks reach 14 pixels beyond:
# 2 (78 2^8) 2^23 / 2^8 < 2^31.
MEDIUM_WIDTH, SMALL_WIDTH = 64 * SUBPIXELS, 16 * SUBPIXELS


class DrawOrder(NamedTuple):
    """
    The order in which triangles are drawn, and which rows each can cover.

    indices: (m,) int32, the triangles in that order; rows: (2, m) int16, for each of them its
    first row and the end, both 0 for what cannot be seen; boxes: (4, chunks) int32, for each
    CHUNK of them its first row and the end, its first column and the end.
    """

    indices: np.ndarray
    rows: np.ndarray
    boxes: np.ndarray


def new_order(indices: np.ndarray) -> DrawOrder:
    """Make the DrawOrder of triangles with these indices, (m,) int32."""
    return DrawOrder(indices, np.empty((2, len(indices)), np.int16),
                     np.empty((4, -(-len(indices) // CHUNK)), np.int32))


class Viewport(NamedTuple):
    """The image's size [pixel], and how far around pixels' centres triangles count [subpixel]."""

    width: int
    height: int
    margin: int


@late_kernel
def cull(geometry, order, viewport, first_chunk, end_chunk):
    """
    Find the rows that triangles can cover: write order.rows and boxes, and geometry.sizes.

    Only chunks first_chunk .. end_chunk - 1 are done.
    """
    triangles, sizes = geometry.triangles, geometry.sizes
    vertices = geometry.vertices
    u, v, outcodes = vertices.u, vertices.v, vertices.outcodes
    indices, rows, boxes = order
    width, height, margin = viewport
    for chunk in range(first_chunk, end_chunk):
        first, last = chunk * CHUNK, min((chunk + 1) * CHUNK, indices.shape[0])
        box_top, box_end = np.int32(height), np.int32(0)
        box_left, box_right = np.int32(width), np.int32(0)
        for k in range(np.uint64(first), np.uint64(last)):
            t = np.uint64(indices[k])
            a, b = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1])
            c = np.uint64(triangles[t, 2])
            worst = max(outcodes[a], outcodes[b], outcodes[c])
            u_least, u_most = min(u[a], u[b], u[c]), max(u[a], u[b], u[c])
            v_least, v_most = min(v[a], v[b], v[c]), max(v[a], v[b], v[c])
            # What is not INSIDE can be anywhere.
            is_inside = worst == INSIDE
            left = next_centre(u_least - margin) if is_inside else np.int32(0)
            right = next_centre(u_most + margin) if is_inside else np.int32(width)
            top = next_centre(v_least - margin) if is_inside else np.int32(0)
            end = next_centre(v_most + margin) if is_inside else np.int32(height)
            left, right = max(left, np.int32(0)), min(right, np.int32(width))
            top, end = max(top, np.int32(0)), min(end, np.int32(height))
            is_seen = (worst < INVALID) & (left < right) & (top < end)
            extent = u_most - u_least
            is_medium, is_small = is_inside & (extent <= MEDIUM_WIDTH), extent <= SMALL_WIDTH
            sizes[t] = np.uint8(is_medium) + np.uint8(is_medium & is_small)
            rows[0, k] = top if is_seen else np.int32(0)
            rows[1, k] = end if is_seen else np.int32(0)
            box_top = min(box_top, top if is_seen else np.int32(height))
            box_end = max(box_end, end if is_seen else np.int32(0))
            box_left = min(box_left, left if is_seen else np.int32(width))
            box_right = max(box_right, right if is_seen else np.int32(0))
        boxes[0, chunk], boxes[1, chunk] = box_top, box_end
        boxes[2, chunk], boxes[3, chunk] = box_left, box_right


@late_kernel
def triangles_in_rows(order, begin, end, found):
    """
    Collect in `found` (m + 1,) the triangles that can cover rows begin .. end - 1, in their order.

    Returns how many, and the first column and the end of what they can cover.
    """
    indices, rows, boxes = order
    count = np.uint64(0)
    left, right = 2 ** 30, 0
    for chunk in range(boxes.shape[1]):
        if boxes[0, chunk] >= end or boxes[1, chunk] <= begin:
            continue
        left, right = min(left, boxes[2, chunk]), max(right, boxes[3, chunk])
        first, last = chunk * CHUNK, min((chunk + 1) * CHUNK, indices.shape[0])
        for k in range(np.uint64(first), np.uint64(last)):
            # Always written, kept if it counts: a branch would be mispredicted too often.
            found[count] = indices[k]
            count += np.uint64((rows[0, k] < end) & (rows[1, k] > begin))
    return count, left, right
