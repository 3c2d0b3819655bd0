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

Setting up is one loop over a batch's triangles, which LLVM turns into vector instructions: its
arrays are flat, field after field, BATCH places each. Rows are drawn in blocks of LANES pixels at
columns that are multiples of LANES: what one triangle stores, the next one loads in one piece,
which a processor forwards at once, while pieces that overlap in part, or under a mask, wait.
"""
from typing import NamedTuple

from flag_sim.drawing.attributes import keep_slot
from flag_sim.drawing.coverage import edge_function
from flag_sim.drawing.culling import MEDIUM
from flag_sim.drawing.geometry import next_centre, SUBPIXELS
from flag_sim.drawing.pixels import hold, LANES, pack, WHOLE
from flag_sim.kernels import inner_kernel, kernel

import numpy as np

BATCH = 64
# Whole numbers of a triangle: corner a and the ways from it to b and c [subpixels], ...
A_U, A_V, P_U, P_V, Q_U, Q_V = (np.uint64(k * BATCH) for k in range(6))
# ... three edge functions at the first pixel, their changes a column and a row, ...
EDGE, EDGE_U, EDGE_V = (np.uint64((6 + 3 * k) * BATCH) for k in range(3))
# ... the columns' start and number, rows' start and end, twice its number and the side seen.
LEFT, COUNT, TOP, END, FACE = (np.uint64(k * BATCH) for k in range(15, 20))
WHOLE_FIELDS = 20
# At a, b and c: reversed Z, red, green, blue.
VALUE_FIELDS = 12
# Reversed Z, red, green, blue: each at the first pixel, its changes a column and a row; then,
# from BOUND on, the least and the most of each.
PLANE_FIELDS, BOUND = 20, np.uint64(12 * BATCH)
ONE, TWO, THREE, FOUR, EIGHT = (np.uint64(k * BATCH) for k in (1, 2, 3, 4, 8))
ZERO = np.int32(0)
# More than a quotient below 100 is wrong by, less than one of whole numbers can be from another.
ROUNDING = 1e-9


class Batch(NamedTuple):
    """A batch's fields, BATCH places each: flat int32, float64 and float32."""

    whole: np.ndarray
    values: np.ndarray
    planes: np.ndarray


def new_batch() -> Batch:
    """Make a batch's arrays."""
    return Batch(np.empty(WHOLE_FIELDS * BATCH, np.int32), np.empty(VALUE_FIELDS * BATCH),
                 np.empty(PLANE_FIELDS * BATCH, np.float32))


@kernel
def draw_batch(geometry, colours, numbers, how, slot, target, batch):
    """
    Draw triangles of one size, SMALL or MEDIUM, with `numbers`, at most BATCH of them.

    colours, how, target: see visibility; slot: the first that is free. Returns the next one.
    """
    size = geometry.sizes[numbers[0]]
    kept = _fetch(geometry, colours, numbers, how, batch)
    _set_up(kept, target.width, how.is_perspective_correct, batch)
    if target.numbers.size > 0:
        _keep_slots(kept, geometry.lens.is_perspective, slot, target.slots, batch)
    if size == MEDIUM:
        _draw_needed_blocks(kept, batch, how, slot, target)
    else:
        _draw_all_blocks(kept, batch, how, slot, target)
    return slot + np.int64(kept)


@inner_kernel
def _fetch(geometry, colours, numbers, how, batch):
    """Gather what is known of the corners; backs of closed bodies are left out."""
    triangles, is_closed, vertices = geometry.triangles, geometry.is_closed, geometry.vertices
    u, v, reversed_z = vertices.u, vertices.v, vertices.reversed_z
    shift_u, shift_v = how.shift_u, how.shift_v
    whole, values, colour, is_flat = batch.whole, batch.values, colours.values, colours.is_flat
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
        whole[FACE + kept] = np.uint64(2) * t + side
        at_a, at_b, at_c = (t, t, t) if is_flat else (a, b, c)
        sa, sb, sc = reversed_z[a], reversed_z[b], reversed_z[c]
        values[kept], values[kept + FOUR], values[kept + EIGHT] = sa, sb, sc
        for channel in range(3):
            place = kept + np.uint64((1 + channel) * BATCH)
            values[place] = colour[at_a, side, channel]
            values[place + FOUR] = colour[at_b, side, channel]
            values[place + EIGHT] = colour[at_c, side, channel]
        kept += np.uint64((side == 0) | (is_closed[t] == 0))
    return kept


@inner_kernel
def _set_up(count, width, is_perspective_correct, batch):
    """Make edge functions and planes; each value q is q_0 + q_u (u - ua) + q_v (v - va)."""
    whole, values, planes = batch
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
        way = qv * share, -qu * share, -pv * share, pu * share, du / SUBPIXELS, dv / SUBPIXELS
        # Four values, written out: LLVM vectorises no loop that has another one inside.
        _plane(values, planes, k, np.uint64(0), way, (1.0, 1.0, 1.0))
        # Perspective-correct colours are interpolated multiplied by 1 / z.
        times = (values[k] if is_perspective_correct else 1.0,
                 values[FOUR + k] if is_perspective_correct else 1.0,
                 values[EIGHT + k] if is_perspective_correct else 1.0)
        _plane(values, planes, k, np.uint64(1), way, times)
        _plane(values, planes, k, np.uint64(2), way, times)
        _plane(values, planes, k, np.uint64(3), way, times)


@inner_kernel
def _plane(values, planes, k, q, way, times):
    """
    Make the plane of value q, times something at a, b and c, and its bounds, without it.

    way: how the weights of b and c change along u and v, and the way from a to the first pixel.
    """
    bu, bv, cu, cv, x, y = way
    place = q * ONE + k
    a, b, c = values[place], values[place + FOUR], values[place + EIGHT]
    place = BOUND + q * TWO + k
    planes[place], planes[place + ONE] = min(a, b, c), max(a, b, c)
    a, b, c = a * times[0], b * times[1], c * times[2]
    change_u, change_v = (b - a) * bu + (c - a) * cu, (b - a) * bv + (c - a) * cv
    place = q * THREE + k
    planes[place] = a + change_u * x + change_v * y
    planes[place + ONE], planes[place + TWO] = change_u, change_v


@kernel
def _keep_slots(count, is_perspective, slot, slots, batch):
    """Write which triangles have the slots from `slot` on."""
    whole, values = batch.whole, batch.values
    for k in range(count):
        pu, pv = np.int64(whole[P_U + k]), np.int64(whole[P_V + k])
        qu, qv = np.int64(whole[Q_U + k]), np.int64(whole[Q_V + k])
        area = pu * qv - qu * pv
        share = SUBPIXELS / area if area != 0 else 0.0
        s_b, s_c = (values[FOUR + k], values[EIGHT + k]) if is_perspective else (1.0, 1.0)
        keep_slot(slots, slot + np.int64(k), whole[FACE + k],
                  (0.0, s_b * qv * share, -s_b * qu * share),
                  (0.0, -s_c * pv * share, s_c * pu * share),
                  (whole[A_U + k] / SUBPIXELS, whole[A_V + k] / SUBPIXELS))


@kernel
def _draw_all_blocks(count, batch, how, slot, target):
    """Draw all blocks of the rows of the batch's triangles."""
    whole, begin, end, stride = batch.whole, target.top, target.end, target.stride
    for k in range(count):
        top = whole[TOP + k]
        columns = (np.uint64(whole[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
        for row in range(max(top, begin), min(whole[END + k], end)):
            first = np.uint64((row - begin) * stride + whole[LEFT + k])
            # From the triangle's own first row, so that bands make no difference.
            _draw_row(k, np.int32(row - top), (np.uint64(0), columns, first), batch, how,
                      slot + np.int64(k), target)


@kernel
def _draw_needed_blocks(count, batch, how, slot, target):
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
                _draw_row(k, y, (start, stop - start, first), batch, how, slot + np.int64(k),
                          target)


@inner_kernel
def _draw_row(k, y, run, batch, how, slot, target):
    """Draw row y of triangle k: run says from which column, how many, and the first pixel."""
    # What never changes in the loop is told by literals: each then has a loop of its own.
    row = (k, y, np.uint32(slot), how.ceiling)
    if target.numbers.size > 0:
        _draw_pixels(row, run, batch, target, how.is_perspective_correct, True)
    elif how.is_perspective_correct:
        _draw_pixels(row, run, batch, target, True, False)
    else:
        _draw_pixels(row, run, batch, target, False, False)


@inner_kernel
def _draw_pixels(row, run, batch, target, is_perspective_correct, keeps_slots):
    k, y, slot, ceiling = row
    start, columns, first = run
    whole, _, planes = batch
    depths, words, numbers = target.depths, target.words, target.numbers
    a_u, b_u, c_u = whole[EDGE_U + k], whole[EDGE_U + ONE + k], whole[EDGE_U + TWO + k]
    a = _along(whole[EDGE + k], y, whole[EDGE_V + k])
    b = _along(whole[EDGE + ONE + k], y, whole[EDGE_V + ONE + k])
    c = _along(whole[EDGE + TWO + k], y, whole[EDGE_V + TWO + k])
    s, ds, s_least, s_most = _value(planes, k, np.uint64(0), y)
    red, dr, r_least, r_most = _value(planes, k, np.uint64(1), y)
    green, dg, g_least, g_most = _value(planes, k, np.uint64(2), y)
    blue, db, b_least, b_most = _value(planes, k, np.uint64(3), y)
    for j in range(columns & WHOLE):
        n = np.int32(np.int32(start) + np.int32(j))
        i = np.float32(n)
        there = depths[first + j]
        is_inside = (_along(a, n, a_u) | _along(b, n, b_u) | _along(c, n, c_u)) >= 0
        here = hold(s + ds * i, s_least, s_most) if is_inside else np.float32(-np.inf)
        is_seen = here > min(there, ceiling)
        # Stored whether it is new or not: LLVM would mask a store under a condition.
        depths[first + j] = here if is_seen else there
        if is_seen:
            # Perspective-correct colours come times 1 / z (Heckbert, 1989).
            depth = np.float32(1.0) / here if is_perspective_correct else np.float32(1.0)
            words[first + j] = pack(hold((red + dr * i) * depth, r_least, r_most),
                                    hold((green + dg * i) * depth, g_least, g_most),
                                    hold((blue + db * i) * depth, b_least, b_most))
            if keeps_slots:
                numbers[first + j] = slot


@inner_kernel
def _value(planes, k, q, y):
    """Return value q in row y at the first column, its change a column, its least and most."""
    place, bound = q * THREE + k, BOUND + q * TWO + k
    return (planes[place] + planes[place + TWO] * np.float32(y), planes[place + ONE],
            planes[bound], planes[bound + ONE])


@inner_kernel
def _along(edge, n, change):
    """Return an edge function n steps on; in 32 bits, or else LLVM multiplies with 64, slowly."""
    return np.int32(edge + np.int32(n * change))
