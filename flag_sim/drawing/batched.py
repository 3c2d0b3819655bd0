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
Triangles that are not wide, many at a time.

They are fetched, set up and drawn in batches. Setting up is one loop over a batch's triangles,
which LLVM turns into vector instructions: a batch's arrays are flat, field after field, BATCH
places each. Rows are drawn in blocks of LANES pixels at columns that are multiples of LANES: what
one triangle stores, the next one loads in one piece, which a processor forwards at once, while
pieces that overlap in part, or under a mask, wait for memory.
"""
from typing import NamedTuple

from flag_sim.drawing.attributes import write_planes
from flag_sim.drawing.coverage import edge_function
from flag_sim.drawing.culling import MEDIUM
from flag_sim.drawing.geometry import next_centre, SUBPIXELS
from flag_sim.kernels import inner_kernel, kernel

import numpy as np

BATCH = 64
# Pixels in a vector of 256 bits, and the mask that rounds down to whole vectors.
LANES = 8
WHOLE = np.uint64(2 ** 64 - LANES)
# Fields of a triangle: corner a and the ways from it to b and c [subpixels], ...
A_U, A_V, P_U, P_V, Q_U, Q_V = (np.uint64(k * BATCH) for k in range(6))
# ... the numbers of its vertices, its own, and the side that is seen, ...
A, B, C, TRIANGLE, SIDE = (np.uint64(k * BATCH) for k in range(6, 11))
# ... three edge functions at the first pixel, their changes a column and a row, the columns' start
# and number, rows' start and end.
EDGE, EDGE_U, EDGE_V = (np.uint64((11 + 3 * k) * BATCH) for k in range(3))
LEFT, COUNT, TOP, END = (np.uint64(k * BATCH) for k in range(20, 24))
WHOLE_FIELDS = 24
# Reversed Z at a, b and c; the weights of b and c: at the first pixel, their changes a column and
# a row.
S_A, S_B, S_C, OF_B, OF_B_U, OF_B_V, OF_C, OF_C_U, OF_C_V = (
    np.uint64(k * BATCH) for k in range(9))
DOUBLE_FIELDS = 9
# Reversed Z at the first pixel, its changes a column and a row, its least and most.
S, S_U, S_V, S_LEAST, S_MOST = (np.uint64(k * BATCH) for k in range(5))
SINGLE_FIELDS = 5
ONE, TWO = np.uint64(BATCH), np.uint64(2 * BATCH)
ZERO = np.int32(0)
# More than a quotient below 100 is wrong by, less than one of whole numbers below 2^23 can be
# beside a whole number.
ROUNDING = 1e-9


class Batch(NamedTuple):
    """A batch's fields, BATCH places each: flat int32, float64 and float32."""

    whole: np.ndarray
    doubles: np.ndarray
    singles: np.ndarray


def new_batch() -> Batch:
    """Make a batch's arrays."""
    return Batch(np.empty(WHOLE_FIELDS * BATCH, np.int32), np.empty(DOUBLE_FIELDS * BATCH),
                 np.empty(SINGLE_FIELDS * BATCH, np.float32))


@kernel
def draw_batch(geometry, numbers, how, values, table, slot, target, batch):
    """
    Draw triangles of one size, SMALL or MEDIUM, with `numbers`, at most BATCH of them.

    how, target: see visibility; values, table: of attributes; slot: the first that is free.
    Returns the next one.
    """
    size = geometry.sizes[numbers[0]]
    kept = _fetch(geometry, numbers, how, batch)
    _set_up(kept, target.width, batch)
    _set_attributes(kept, values, how.groups, table, slot, batch)
    if size == MEDIUM:
        _draw_needed_blocks(kept, batch, how.ceiling, slot, target)
    else:
        _draw_all_blocks(kept, batch, how.ceiling, slot, target)
    return slot + np.int64(kept)


@inner_kernel
def _fetch(geometry, numbers, how, batch):
    """Gather what is known of the corners; backs of closed bodies are left out."""
    triangles, is_closed, vertices = geometry.triangles, geometry.is_closed, geometry.vertices
    u, v, reversed_z = vertices.u, vertices.v, vertices.reversed_z
    shift_u, shift_v = how.shift_u, how.shift_v
    whole, doubles = batch.whole, batch.doubles
    kept = np.uint64(0)
    for k in range(np.uint64(numbers.size)):
        t = np.uint64(numbers[k])
        a, b = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1])
        c = np.uint64(triangles[t, 2])
        au, av = u[a] - shift_u, v[a] - shift_v
        pu, pv = u[b] - shift_u - au, v[b] - shift_v - av
        qu, qv = u[c] - shift_u - au, v[c] - shift_v - av
        # v points down, so the front, counterclockwise, has a negative area.
        side = np.uint64(pu * qv - qu * pv > 0)
        whole[A_U + kept], whole[A_V + kept] = au, av
        whole[P_U + kept], whole[P_V + kept] = pu, pv
        whole[Q_U + kept], whole[Q_V + kept] = qu, qv
        whole[A + kept], whole[B + kept], whole[C + kept] = a, b, c
        whole[TRIANGLE + kept], whole[SIDE + kept] = t, side
        doubles[S_A + kept], doubles[S_B + kept] = reversed_z[a], reversed_z[b]
        doubles[S_C + kept] = reversed_z[c]
        kept += np.uint64((side == 0) | (is_closed[t] == 0))
    return kept


@inner_kernel
def _set_up(count, width, batch):
    """Make edge functions, the plane of reversed Z and those of the weights of b and c."""
    whole, doubles, singles = batch
    full = np.int32(SUBPIXELS)
    for k in range(count):
        au, av = whole[A_U + k], whole[A_V + k]
        pu, pv = whole[P_U + k], whole[P_V + k]
        qu, qv = whole[Q_U + k], whole[Q_V + k]
        area = pu * qv - qu * pv
        left = next_centre(au + min(pu, qu, ZERO))
        right = next_centre(au + max(pu, qu, ZERO))
        top = max(next_centre(av + min(pv, qv, ZERO)), ZERO)
        left = max(left & np.int32(-LANES), ZERO)
        right = min(right, np.int32(width))
        whole[LEFT + k], whole[COUNT + k] = left, max(right - left, ZERO)
        whole[TOP + k] = top
        whole[END + k] = next_centre(av + max(pv, qv, ZERO))
        du, dv = left * full - au, top * full - av
        sign = np.int32(1) if area > 0 else np.int32(-1)
        # From a to b, from c to a and from b to c, inside to the left.
        change_u, change_v = -pv * sign, pu * sign
        whole[EDGE + k] = np.int32(edge_function(change_u, change_v, du, dv))
        whole[EDGE_U + k], whole[EDGE_V + k] = change_u, change_v
        change_u, change_v = qv * sign, -qu * sign
        whole[EDGE + ONE + k] = np.int32(edge_function(change_u, change_v, du, dv))
        whole[EDGE_U + ONE + k], whole[EDGE_V + ONE + k] = change_u, change_v
        change_u, change_v = (pv - qv) * sign, (qu - pu) * sign
        whole[EDGE + TWO + k] = np.int32(
            edge_function(change_u, change_v, du - pu, dv - pv))
        whole[EDGE_U + TWO + k], whole[EDGE_V + TWO + k] = change_u, change_v

        share = SUBPIXELS / area
        bu, bv, cu, cv = qv * share, -qu * share, -pv * share, pu * share
        x, y = du / SUBPIXELS, dv / SUBPIXELS
        doubles[OF_B + k], doubles[OF_B_U + k], doubles[OF_B_V + k] = bu * x + bv * y, bu, bv
        doubles[OF_C + k], doubles[OF_C_U + k], doubles[OF_C_V + k] = cu * x + cv * y, cu, cv
        a, b, c = doubles[S_A + k], doubles[S_B + k], doubles[S_C + k]
        change_u, change_v = (b - a) * bu + (c - a) * cu, (b - a) * bv + (c - a) * cv
        singles[S + k] = a + change_u * x + change_v * y
        singles[S_U + k], singles[S_V + k] = change_u, change_v
        singles[S_LEAST + k], singles[S_MOST + k] = min(a, b, c), max(a, b, c)


@inner_kernel
def _set_attributes(count, values, groups, table, slot, batch):
    """Write the attributes' planes of the batch's triangles."""
    whole, doubles = batch.whole, batch.doubles
    for k in range(count):
        source = (np.uint64(whole[A + k]), np.uint64(whole[B + k]), np.uint64(whole[C + k]),
                  np.uint64(whole[TRIANGLE + k]), np.uint64(whole[SIDE + k]))
        origin = np.float32(whole[LEFT + k]), np.float32(whole[TOP + k])
        b, b_u, b_v = doubles[OF_B + k], doubles[OF_B_U + k], doubles[OF_B_V + k]
        c, c_u, c_v = doubles[OF_C + k], doubles[OF_C_U + k], doubles[OF_C_V + k]
        a, a_u, a_v = 1.0 - b - c, -b_u - c_u, -b_v - c_v
        s_a, s_b, s_c = doubles[S_A + k], doubles[S_B + k], doubles[S_C + k]
        screen = a, a_u, a_v, b, b_u, b_v, c, c_u, c_v
        perspective = (a * s_a, a_u * s_a, a_v * s_a, b * s_b, b_u * s_b, b_v * s_b,
                       c * s_c, c_u * s_c, c_v * s_c)
        write_planes(values, groups, table, slot + np.int64(k), source, origin,
                     (screen, perspective))


@kernel
def _draw_all_blocks(count, batch, ceiling, slot, target):
    """Draw all blocks of the rows of the batch's triangles."""
    whole, begin, end, stride = batch.whole, target.top, target.end, target.stride
    for k in range(count):
        top = whole[TOP + k]
        columns = (np.uint64(whole[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
        for row in range(max(top, begin), min(whole[END + k], end)):
            first = np.uint64((row - begin) * stride + whole[LEFT + k])
            # From the triangle's own first row, so that bands make no difference.
            _draw_row(k, np.int32(row - top), (np.uint64(0), columns, first), batch, ceiling,
                      np.uint32(slot + np.int64(k)), target)


@kernel
def _draw_needed_blocks(count, batch, ceiling, slot, target):
    """Draw the same, but of each row only the blocks that can have pixels inside."""
    whole, begin, end, stride = batch.whole, target.top, target.end, target.stride
    for k in range(count):
        top = whole[TOP + k]
        columns = (np.uint64(whole[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
        for row in range(max(top, begin), min(whole[END + k], end)):
            y = np.int32(row - top)
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
            if inner <= last:
                start = np.uint64(inner) & WHOLE
                stop = min((np.uint64(last) + np.uint64(LANES)) & WHOLE, columns)
                first = np.uint64((row - begin) * stride + whole[LEFT + k]) + start
                _draw_row(k, y, (start, stop - start, first), batch, ceiling,
                          np.uint32(slot + np.int64(k)), target)


@inner_kernel
def _draw_row(k, y, run, batch, ceiling, slot, target):
    """Draw row y of triangle k: run says from which column, how many, and the first pixel."""
    start, columns, first = run
    whole, _, singles = batch
    depths, slots = target.depths, target.slots
    a_u, b_u, c_u = whole[EDGE_U + k], whole[EDGE_U + ONE + k], whole[EDGE_U + TWO + k]
    a = _along(whole[EDGE + k], y, whole[EDGE_V + k])
    b = _along(whole[EDGE + ONE + k], y, whole[EDGE_V + ONE + k])
    c = _along(whole[EDGE + TWO + k], y, whole[EDGE_V + TWO + k])
    s, s_u = singles[S + k] + singles[S_V + k] * np.float32(y), singles[S_U + k]
    least, most = singles[S_LEAST + k], singles[S_MOST + k]
    for j in range(columns & WHOLE):
        n = np.int32(np.int32(start) + np.int32(j))
        there = depths[first + j]
        is_inside = (_along(a, n, a_u) | _along(b, n, b_u) | _along(c, n, c_u)) >= 0
        here = min(max(s + s_u * np.float32(n), least), most) if is_inside else np.float32(-np.inf)
        is_seen = here > min(there, ceiling)
        # Stored whether it is new or not: LLVM would mask a store under a condition.
        depths[first + j] = here if is_seen else there
        if is_seen:
            slots[first + j] = slot


@inner_kernel
def _along(edge, n, change):
    """Return an edge function n steps on; in 32 bits, or else LLVM multiplies with 64, slowly."""
    return np.int32(edge + np.int32(n * change))
