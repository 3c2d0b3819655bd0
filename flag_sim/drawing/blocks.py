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
Blocks: how a batch's triangles are drawn.

Rows are drawn in blocks of LANES pixels at columns that are multiples of LANES: what one triangle
stores, the next one loads in one piece, which a processor forwards at once, while pieces that
overlap in part, or under a mask, wait.
"""
from flag_sim.drawing.batched import (
    COUNT, EDGE, EDGE_U, EDGE_V, EIGHT, END, fetch, FOUR, keep_slots, LEFT, ONE, set_up, THIN,
    THREE, TOP, TWO)
from flag_sim.drawing.culling import MEDIUM
from flag_sim.drawing.pixels import hold, LANES, pack, WHOLE
from flag_sim.jit.kernels import inner_kernel, kernel

import numpy as np

# More than a quotient below 100 is wrong by, less than one of whole numbers can be from another.
ROUNDING = 1e-9


@kernel
def draw_batch(geometry, colours, numbers, how, slot, target, batch):
    """
    Draw triangles of one size, SMALL or MEDIUM, with `numbers`, at most BATCH of them.

    colours, how, target: see visibility; slot: the first that is free. Returns the next one.
    """
    size = geometry.sizes[numbers[0]]
    kept = fetch(geometry, colours, numbers, how, batch)
    has_thin = set_up(kept, target.width, how.is_perspective_correct, batch)
    if target.numbers.size > 0:
        keep_slots(kept, geometry.lens.is_perspective, slot, target.slots, batch)
    # Most batches are plain; what the others need makes plain ones 4 to 8 % slower if it stands
    # in the same loop.
    if has_thin or how.ceiling < np.float32(0.0) or target.numbers.size > 0:
        _draw_any(kept, batch, how, slot, target)
    elif size == MEDIUM:
        _draw_needed_blocks(kept, batch, how, target)
    else:
        _draw_all_blocks(kept, batch, how, target)
    return slot + np.int64(kept)


@kernel
def _draw_all_blocks(count, batch, how, target):
    """Draw all blocks of the rows of the batch's triangles."""
    whole, begin, end, stride = batch.whole, target.top, target.end, target.stride
    for k in range(count):
        top = whole[TOP + k]
        columns = (np.uint64(whole[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
        for row in range(max(top, begin), min(whole[END + k], end)):
            first = np.uint64((row - begin) * stride + whole[LEFT + k])
            # From the triangle's own first row, so that bands make no difference.
            _draw_plain((k, np.int32(row - top)), (np.uint64(0), columns, first), batch, how,
                        target)


@kernel
def _draw_needed_blocks(count, batch, how, target):
    """Draw the same, but of each row only the blocks that can have pixels inside."""
    whole, begin, end, stride = batch.whole, target.top, target.end, target.stride
    for k in range(count):
        top = whole[TOP + k]
        for row in range(max(top, begin), min(whole[END + k], end)):
            y = np.int32(row - top)
            run = _needed(k, y, np.uint64((row - begin) * stride + whole[LEFT + k]), batch)
            _draw_plain((k, y), run, batch, how, target)


@kernel
def _draw_any(count, batch, how, slot, target):
    """Draw the same where triangles are THIN, for a painter, or to slots from `slot` on."""
    whole, begin, end, stride = batch.whole, target.top, target.end, target.stride
    for k in range(count):
        top, way = whole[TOP + k], (how.ceiling, np.uint32(slot + np.int64(k)))
        for row in range(max(top, begin), min(whole[END + k], end)):
            y = np.int32(row - top)
            run = _needed(k, y, np.uint64((row - begin) * stride + whole[LEFT + k]), batch)
            _draw_pixels((k, y), run, batch, way, target, False, how.is_perspective_correct)


@inner_kernel
def _draw_plain(place, run, batch, how, target):
    # What never changes in the loop is told by literals: each then has a loop of its own.
    way = how.ceiling, np.uint32(0)
    if how.is_perspective_correct:
        _draw_pixels(place, run, batch, way, target, True, True)
    else:
        _draw_pixels(place, run, batch, way, target, True, False)


@inner_kernel
def _needed(k, y, first, batch):
    """Return the blocks of row y with pixels inside: column, how many, `first` and column."""
    whole = batch.whole
    columns = (np.uint64(whole[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
    low, high = 0.0, np.float64(columns) - 1.0
    for edge in range(np.uint64(3)):
        place = edge * ONE + k
        here = np.int32(whole[EDGE + place] + np.int32(y * whole[EDGE_V + place]))
        # here + n change is not negative from this column on, or up to it.
        cut = -here / whole[EDGE_U + place]
        if whole[EDGE_U + place] > 0:
            low = max(low, cut)
        elif whole[EDGE_U + place] < 0:
            high = min(high, cut)
    inner, last = np.ceil(low - ROUNDING), np.floor(high + ROUNDING)
    if inner > last:
        return np.uint64(0), np.uint64(0), first
    start = np.uint64(inner) & WHOLE
    stop = min((np.uint64(last) + np.uint64(LANES)) & WHOLE, columns)
    return start, stop - start, first + start


@inner_kernel
def _draw_pixels(place, run, batch, way, target, is_plain, is_perspective_correct):
    k, y = place
    start, columns, first = run
    ceiling, slot = way
    whole, values, planes = batch
    depths, words, numbers = target.depths, target.words, target.numbers
    a_u, b_u, c_u = whole[EDGE_U + k], whole[EDGE_U + ONE + k], whole[EDGE_U + TWO + k]
    a = _along(whole[EDGE + k], y, whole[EDGE_V + k])
    b = _along(whole[EDGE + ONE + k], y, whole[EDGE_V + ONE + k])
    c = _along(whole[EDGE + TWO + k], y, whole[EDGE_V + TWO + k])
    s, ds = _value(planes, k, np.uint64(0), y)
    red, dr = _value(planes, k, np.uint64(1), y)
    green, dg = _value(planes, k, np.uint64(2), y)
    blue, db = _value(planes, k, np.uint64(3), y)
    s_least, s_most = _bounds(batch, k, np.uint64(0))
    r_least, r_most = _bounds(batch, k, np.uint64(1))
    g_least, g_most = _bounds(batch, k, np.uint64(2))
    b_least, b_most = _bounds(batch, k, np.uint64(3))
    for j in range(columns & WHOLE):
        n = np.int32(np.int32(start) + np.int32(j))
        i = np.float32(n)
        there = depths[first + j]
        is_inside = (_along(a, n, a_u) | _along(b, n, b_u) | _along(c, n, c_u)) >= 0
        here = s + ds * i
        if not is_plain:
            here = hold(here, s_least, s_most)
        here = here if is_inside else np.float32(-np.inf)
        is_seen = here > (there if is_plain else min(there, ceiling))
        # Stored whether it is new or not: LLVM would mask a store under a condition.
        depths[first + j] = max(here, there) if is_plain else (here if is_seen else there)
        if is_seen:
            # Perspective-correct colours come times 1 / z (Heckbert, 1989).
            depth = np.float32(1.0) / here if is_perspective_correct else np.float32(1.0)
            r, g, b_ = (red + dr * i) * depth, (green + dg * i) * depth, (blue + db * i) * depth
            if is_plain and is_perspective_correct:
                # As below, that nothing is rounded otherwise.
                r, g, b_ = (hold(r, np.float32(0), np.float32(255)),
                            hold(g, np.float32(0), np.float32(255)),
                            hold(b_, np.float32(0), np.float32(255)))
            elif not is_plain:
                r, g, b_ = (hold(r, r_least, r_most), hold(g, g_least, g_most),
                            hold(b_, b_least, b_most))
            words[first + j] = pack(r, g, b_)
            if not is_plain and numbers.size > 0:
                numbers[first + j] = slot


@inner_kernel
def _value(planes, k, q, y):
    """Return value q of triangle k in row y at the first column, and its change a column."""
    place = q * THREE + k
    return planes[place] + planes[place + TWO] * np.float32(y), planes[place + ONE]


@inner_kernel
def _bounds(batch, k, q):
    """Return the least and the most of value q of triangle k, infinite unless it is THIN."""
    place, infinite = q * ONE + k, np.float32(np.inf)
    a, b, c = (batch.values[place], batch.values[place + FOUR], batch.values[place + EIGHT])
    is_thin = batch.whole[THIN + k] != 0
    return (np.float32(min(a, b, c)) if is_thin else -infinite,
            np.float32(max(a, b, c)) if is_thin else infinite)


@inner_kernel
def _along(edge, n, change):
    """Return an edge function n steps on; in 32 bits, or else LLVM multiplies with 64, slowly."""
    return np.int32(edge + np.int32(n * change))
