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
Batches: SMALL and MEDIUM triangles, set up together and then drawn in blocks of pixels.

A block is LANES pixels at a column that is a multiple of LANES. What one triangle stores, the
next one then loads in one piece, which a processor forwards at once; loads that overlap a store
in part, or a store under a mask, wait.
"""
from flag_sim.drawing.culling import MEDIUM
from flag_sim.drawing.depth import is_nearer
from flag_sim.drawing.pixels import clamp, LANES, pack_rgb, WHOLE_VECTORS
from flag_sim.drawing.triangle_setup import (
    AB, AT_A, AT_B, AT_C, BC, CA, COLUMNS, DU, DV, EDGE, EDGE_DU, EDGE_DV, END, FACE, gather, LEFT,
    PLANE, set_up, START, THIN, TOP, VALUE)
from flag_sim.drawing.visibility import face_mark
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# More than the rounding of a quotient below 100, less than the distance from it to any other
# quotient of such whole numbers.
ROUNDING = 1e-9


@late_kernel
def draw_batch(geometry, colours, indices, state, target, batch, rare):
    """
    Draw triangles of one size, SMALL or MEDIUM, with `indices`, at most BATCH of them.

    colours, state, target, rare: see rasterizer.
    """
    size = geometry.sizes[indices[0]]
    kept = gather(geometry, colours, indices, state, batch)
    has_thin = set_up(colours, kept, target.width, state.is_perspective_correct, batch)
    # Most batches are plain; what the others need makes plain ones 4 to 8 % slower if it stands
    # in the same loop.
    if has_thin or state.depth_ceiling < np.float32(0.0):
        _draw_any(kept, batch, state, target)
        return
    if rare is not None:
        if target.faces.size > 0:
            _draw_with_faces(kept, batch, state, target, size == MEDIUM)
            return
    if size == MEDIUM:
        _draw_needed_blocks(kept, batch, state, target)
    else:
        _draw_all_blocks(kept, batch, state, target)


@late_kernel
def _draw_all_blocks(count, batch, state, target):
    """Draw all blocks in the bounding boxes of the batch's triangles."""
    integers, begin, end, stride = batch.integers, target.top, target.end, target.stride
    for k in range(count):
        top = integers[TOP + k]
        columns = (np.uint64(integers[COLUMNS + k]) + np.uint64(LANES - 1)) & WHOLE_VECTORS
        for row in range(max(top, begin), min(integers[END + k], end)):
            first = np.uint64((row - begin) * stride + integers[LEFT + k])
            # From the triangle's own first row, so that bands make no difference.
            _draw_plain((k, np.int32(row - top)), (np.uint64(0), columns, first), batch, state,
                        target)


@late_kernel
def _draw_needed_blocks(count, batch, state, target):
    """Draw the same, but of each row only the blocks that can have pixels inside."""
    integers, begin, end, stride = batch.integers, target.top, target.end, target.stride
    for k in range(count):
        top = integers[TOP + k]
        for row in range(max(top, begin), min(integers[END + k], end)):
            y = np.int32(row - top)
            blocks = needed_blocks(
                k, y, np.uint64((row - begin) * stride + integers[LEFT + k]), batch)
            _draw_plain((k, y), blocks, batch, state, target)


@late_kernel
def _draw_any(count, batch, state, target):
    """Draw the same where triangles are THIN, or for a painter."""
    integers, begin, end, stride = batch.integers, target.top, target.end, target.stride
    for k in range(count):
        top = integers[TOP + k]
        ceiling_and_face = state.depth_ceiling, face_mark(integers[FACE + k])
        for row in range(max(top, begin), min(integers[END + k], end)):
            y = np.int32(row - top)
            blocks = needed_blocks(
                k, y, np.uint64((row - begin) * stride + integers[LEFT + k]), batch)
            _draw_pixels((k, y), blocks, batch, ceiling_and_face, target, False,
                         state.is_perspective_correct)


@late_kernel
def _draw_with_faces(count, batch, state, target, is_medium):
    """Draw the same, and which face each pixel sees."""
    integers, begin, end, stride = batch.integers, target.top, target.end, target.stride
    for k in range(count):
        top = integers[TOP + k]
        ceiling_and_face = state.depth_ceiling, face_mark(integers[FACE + k])
        columns = (np.uint64(integers[COLUMNS + k]) + np.uint64(LANES - 1)) & WHOLE_VECTORS
        for row in range(max(top, begin), min(integers[END + k], end)):
            y = np.int32(row - top)
            first = np.uint64((row - begin) * stride + integers[LEFT + k])
            blocks = np.uint64(0), columns, first
            if is_medium:
                blocks = needed_blocks(k, y, first, batch)
            if state.is_perspective_correct:
                _draw_pixels((k, y), blocks, batch, ceiling_and_face, target, True, True, True)
            else:
                _draw_pixels((k, y), blocks, batch, ceiling_and_face, target, True, False, True)


@late_inner_kernel
def _draw_plain(triangle_row, blocks, batch, state, target):
    # What never changes in the loop is passed as literals: each case then has a loop of its own.
    ceiling_and_face = state.depth_ceiling, np.uint32(0)
    if state.is_perspective_correct:
        _draw_pixels(triangle_row, blocks, batch, ceiling_and_face, target, True, True)
    else:
        _draw_pixels(triangle_row, blocks, batch, ceiling_and_face, target, True, False)


@late_inner_kernel
def needed_blocks(k, y, first, batch):
    """
    Return the blocks of row y with pixels inside of triangle k.

    first: the pixel at the triangle's first column. Returns the blocks' first column, the number
    of their columns, and the pixel that they begin at.
    """
    integers = batch.integers
    columns = (np.uint64(integers[COLUMNS + k]) + np.uint64(LANES - 1)) & WHOLE_VECTORS
    low, high = 0.0, np.float64(columns) - 1.0
    for edge in range(np.uint64(3)):
        place = edge * CA + k
        here = np.int32(integers[EDGE + place] + np.int32(y * integers[EDGE_DV + place]))
        # here + n change is not negative from this column on, or up to it.
        crossing = -here / integers[EDGE_DU + place]
        if integers[EDGE_DU + place] > 0:
            low = max(low, crossing)
        elif integers[EDGE_DU + place] < 0:
            high = min(high, crossing)
    inner, last = np.ceil(low - ROUNDING), np.floor(high + ROUNDING)
    if inner > last:
        return np.uint64(0), np.uint64(0), first
    start = np.uint64(inner) & WHOLE_VECTORS
    stop = min((np.uint64(last) + np.uint64(LANES)) & WHOLE_VECTORS, columns)
    return start, stop - start, first + start


@late_inner_kernel
def _draw_pixels(triangle_row, blocks, batch, ceiling_and_face, target, is_plain,
                 is_perspective_correct, has_faces=False):
    k, y = triangle_row
    start, columns, first = blocks
    ceiling, face = ceiling_and_face
    integers, values, planes = batch
    depth, colour, faces = target.depth, target.colour, target.faces
    ab_du, ca_du, bc_du = (integers[EDGE_DU + AB + k], integers[EDGE_DU + CA + k],
                           integers[EDGE_DU + BC + k])
    ab = along(integers[EDGE + AB + k], y, integers[EDGE_DV + AB + k])
    ca = along(integers[EDGE + CA + k], y, integers[EDGE_DV + CA + k])
    bc = along(integers[EDGE + BC + k], y, integers[EDGE_DV + BC + k])
    s, ds = _value(planes, k, np.uint64(0), y)
    red, dr = _value(planes, k, np.uint64(1), y)
    green, dg = _value(planes, k, np.uint64(2), y)
    blue, db = _value(planes, k, np.uint64(3), y)
    s_least, s_most = bounds(batch, k, np.uint64(0))
    r_least, r_most = bounds(batch, k, np.uint64(1))
    g_least, g_most = bounds(batch, k, np.uint64(2))
    b_least, b_most = bounds(batch, k, np.uint64(3))
    for j in range(columns & WHOLE_VECTORS):
        n = np.int32(np.int32(start) + np.int32(j))
        i = np.float32(n)
        stored = depth[first + j]
        is_inside = (along(ab, n, ab_du) | along(ca, n, ca_du) | along(bc, n, bc_du)) >= 0
        here = s + ds * i
        if not is_plain:
            here = clamp(here, s_least, s_most)
        here = here if is_inside else np.float32(-np.inf)
        is_seen = is_nearer(here, stored if is_plain else min(stored, ceiling))
        # Stored whether it is new or not: LLVM would mask a store under a condition.
        depth[first + j] = max(here, stored) if is_plain else (here if is_seen else stored)
        if is_seen:
            # Perspective-correct colours come times 1 / z (Heckbert, 1989).
            z = np.float32(1.0) / here if is_perspective_correct else np.float32(1.0)
            r, g, b = (red + dr * i) * z, (green + dg * i) * z, (blue + db * i) * z
            if is_plain and is_perspective_correct:
                # As below, that nothing is rounded otherwise.
                r, g, b = (clamp(r, np.float32(0), np.float32(255)),
                           clamp(g, np.float32(0), np.float32(255)),
                           clamp(b, np.float32(0), np.float32(255)))
            elif not is_plain:
                r, g, b = (clamp(r, r_least, r_most), clamp(g, g_least, g_most),
                           clamp(b, b_least, b_most))
            colour[first + j] = pack_rgb(r, g, b)
            if has_faces or (not is_plain and faces.size > 0):
                faces[first + j] = face


@late_inner_kernel
def _value(planes, k, q, y):
    """Return value q of triangle k in row y at the first column, and its change a column."""
    place = q * PLANE + k
    return planes[START + place] + planes[DV + place] * np.float32(y), planes[DU + place]


@late_inner_kernel
def bounds(batch, k, q):
    """Return the least and the most of value q of triangle k, infinite unless it is THIN."""
    place, infinite = q * VALUE + k, np.float32(np.inf)
    a, b, c = (batch.values[AT_A + place], batch.values[AT_B + place],
               batch.values[AT_C + place])
    is_thin = batch.integers[THIN + k] != 0
    return (np.float32(min(a, b, c)) if is_thin else -infinite,
            np.float32(max(a, b, c)) if is_thin else infinite)


@late_inner_kernel
def along(edge, n, change):
    """Return an edge function n steps on; in 32 bits, or else LLVM multiplies with 64, slowly."""
    return np.int32(edge + np.int32(n * change))
