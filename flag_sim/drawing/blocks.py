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
Narrow triangles, many at a time.

They are fetched, set up and drawn in groups. Setting up is one loop over a group's triangles,
which LLVM turns into vector instructions: a group's arrays are flat, field after field, GROUP
slots each. A triangle covers a pixel where its three edge functions (Pineda, 1988) are not
negative; they are whole numbers of square subpixels, so coverage is exact. Rows are drawn in
blocks of LANES pixels at columns that are multiples of LANES: what one triangle stores, the next
one loads in one piece, which a processor forwards at once, while pieces that overlap in part, or
under a mask, wait for memory.
"""
from flag_sim.drawing.projection import next_centre, SUBPIXEL_BITS, SUBPIXELS
from flag_sim.drawing.spans import hold, LANES, pack, WHOLE
from flag_sim.kernels import inner_kernel, kernel

import numpy as np

GROUP = 64
# Fields of a triangle: corner a and the ways from it to b and c [subpixels].
A_U, A_V, P_U, P_V, Q_U, Q_V = (np.uint64(k * GROUP) for k in range(6))
POSITION_FIELDS = 6
# At a, b and c: reversed Z, red, green, blue.
VALUE_FIELDS = 12
# Three edge functions at the first pixel, their changes a column and a row; the columns' start
# and number, rows' start and end.
EDGE, EDGE_U, EDGE_V = (np.uint64(3 * k * GROUP) for k in range(3))
LEFT, COUNT, TOP, END = (np.uint64(k * GROUP) for k in range(9, 13))
EDGE_FIELDS = 13
# Reversed Z, red, green, blue: each at the first pixel, its changes a column and a row; then,
# from BOUND on, the least and the most of each.
PLANE_FIELDS, BOUND = 20, np.uint64(12 * GROUP)
ONE, TWO, THREE = np.uint64(GROUP), np.uint64(2 * GROUP), np.uint64(3 * GROUP)
ZERO = np.int32(0)
# More than a quotient below 100 is wrong by, less than one of whole numbers below 2^23 can be
# beside a whole number.
ROUNDING = 1e-9


@kernel
def draw_narrow(triangles, numbers, first, count, closed, u, v, reversed_z, colours, is_flat,
                is_perspective_correct, is_painter, is_slanted, shift_u, shift_v, top, end, width,
                stride, positions, values, edges, planes, depths, words):
    """
    Draw `count` triangles, at most GROUP, numbers[first] and on, into rows top .. end - 1.

    All are INSIDE and of one kind, SLIM or, where is_slanted, NARROW (see culling). closed,
    colours, is_flat, is_perspective_correct, is_painter, shift_u, shift_v, stride: see
    rasterizer.fill; positions, values, edges, planes: for the work in between; depths, words:
    reversed Z and colours of the rows.
    """
    kept = _fetch(triangles, numbers, first, count, closed, u, v, reversed_z, colours, is_flat,
                  is_perspective_correct, shift_u, shift_v, positions, values)
    _set_up(kept, width, is_perspective_correct, positions, values, edges, planes)
    if not is_painter:
        _draw(np.uint64(0), kept, edges, planes, is_slanted, is_perspective_correct, top, end,
              stride, depths, words)
        return
    for k in range(kept):
        # What is emptied first is covered.
        _empty_rows(k, edges, top, end, stride, depths)
        _draw(k, k + np.uint64(1), edges, planes, is_slanted, is_perspective_correct, top, end,
              stride, depths, words)


@kernel
def _draw(first_k, end_k, edges, planes, is_slanted, is_perspective_correct, begin, end, stride,
          depths, words):
    if is_slanted:
        _draw_slanted(first_k, end_k, edges, planes, is_perspective_correct, begin, end, stride,
                      depths, words)
    else:
        _draw_rows(first_k, end_k, edges, planes, is_perspective_correct, begin, end, stride,
                   depths, words)


@kernel
def _fetch(triangles, numbers, first, count, closed, u, v, reversed_z, colours, is_flat,
           is_perspective_correct, shift_u, shift_v, positions, values):
    """Gather what is known of the corners; backs of closed bodies are left out."""
    kept = np.uint64(0)
    for k in range(count):
        t = np.uint64(numbers[first + k])
        a, b = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1])
        c = np.uint64(triangles[t, 2])
        au, av = u[a] - shift_u, v[a] - shift_v
        pu, pv = u[b] - shift_u - au, v[b] - shift_v - av
        qu, qv = u[c] - shift_u - au, v[c] - shift_v - av
        area = pu * qv - qu * pv
        positions[A_U + kept], positions[A_V + kept] = au, av
        positions[P_U + kept], positions[P_V + kept] = pu, pv
        positions[Q_U + kept], positions[Q_V + kept] = qu, qv
        # v points down, so the front, counterclockwise, has a negative area.
        side = np.uint64(area > 0)
        matter_a, matter_b, matter_c = (t, t, t) if is_flat else (a, b, c)
        sa, sb, sc = reversed_z[a], reversed_z[b], reversed_z[c]
        values[kept], values[kept + np.uint64(4 * GROUP)] = sa, sb
        values[kept + np.uint64(8 * GROUP)] = sc
        # Perspective-correct colours are interpolated multiplied by 1 / z.
        wa, wb, wc = (sa, sb, sc) if is_perspective_correct else (1.0, 1.0, 1.0)
        for channel in range(3):
            slot = kept + np.uint64((1 + channel) * GROUP)
            values[slot] = wa * colours[matter_a, side, channel]
            values[slot + np.uint64(4 * GROUP)] = wb * colours[matter_b, side, channel]
            values[slot + np.uint64(8 * GROUP)] = wc * colours[matter_c, side, channel]
        kept += np.uint64((side == 0) | (t < closed))
    return kept


@kernel
def _set_up(count, width, is_perspective_correct, positions, values, edges, planes):
    """Make edge functions and planes; each value q is q_0 + q_u (u - ua) + q_v (v - va)."""
    full = np.int32(SUBPIXELS)
    for k in range(count):
        au, av = positions[A_U + k], positions[A_V + k]
        pu, pv = positions[P_U + k], positions[P_V + k]
        qu, qv = positions[Q_U + k], positions[Q_V + k]
        area = pu * qv - qu * pv
        left = next_centre(au + min(pu, qu, ZERO))
        right = next_centre(au + max(pu, qu, ZERO))
        top = max(next_centre(av + min(pv, qv, ZERO)), ZERO)
        left = max(left & np.int32(-LANES), ZERO)
        right = min(right, np.int32(width))
        edges[LEFT + k], edges[COUNT + k] = left, max(right - left, ZERO)
        edges[TOP + k] = top
        edges[END + k] = next_centre(av + max(pv, qv, ZERO))
        du, dv = left * full - au, top * full - av
        sign = np.int32(1) if area > 0 else np.int32(-1)
        # From a to b, from c to a and from b to c, inside to the left.
        change_u, change_v = -pv * sign, pu * sign
        edges[EDGE + k] = _in_steps(change_u * du + change_v * dv, change_u, change_v)
        edges[EDGE_U + k], edges[EDGE_V + k] = change_u, change_v
        change_u, change_v = qv * sign, -qu * sign
        edges[EDGE + ONE + k] = _in_steps(change_u * du + change_v * dv, change_u, change_v)
        edges[EDGE_U + ONE + k], edges[EDGE_V + ONE + k] = change_u, change_v
        change_u, change_v = (pv - qv) * sign, (qu - pu) * sign
        edges[EDGE + TWO + k] = _in_steps(
            change_u * (du - pu) + change_v * (dv - pv), change_u, change_v)
        edges[EDGE_U + TWO + k], edges[EDGE_V + TWO + k] = change_u, change_v

        share = SUBPIXELS / area
        bu, bv, cu, cv = qv * share, -qu * share, -pv * share, pu * share
        x, y = du / SUBPIXELS, dv / SUBPIXELS
        # Four values, written out: LLVM vectorises no loop that has another one inside.
        _plane(values, planes, k, np.uint64(0), bu, bv, cu, cv, x, y, is_perspective_correct)
        _plane(values, planes, k, np.uint64(1), bu, bv, cu, cv, x, y, is_perspective_correct)
        _plane(values, planes, k, np.uint64(2), bu, bv, cu, cv, x, y, is_perspective_correct)
        _plane(values, planes, k, np.uint64(3), bu, bv, cu, cv, x, y, is_perspective_correct)


@kernel
def _in_steps(edge, change_u, change_v):
    """
    Divide an edge function by SUBPIXELS, which is what a pixel changes it in; keep its sign.

    A point on an edge that is neither top nor left is outside, so there the quotient is negative.
    """
    is_excluded = (change_u < 0) | ((change_u == 0) & (change_v < 0))
    return np.int32((edge - (1 if is_excluded else 0)) >> SUBPIXEL_BITS)


@kernel
def _plane(values, planes, k, q, bu, bv, cu, cv, x, y, is_perspective_correct):
    slot = q * np.uint64(GROUP) + k
    start = values[slot]
    along_b = values[slot + np.uint64(4 * GROUP)] - start
    along_c = values[slot + np.uint64(8 * GROUP)] - start
    change_u, change_v = along_b * bu + along_c * cu, along_b * bv + along_c * cv
    slot = q * THREE + k
    planes[slot] = start + change_u * x + change_v * y
    planes[slot + ONE], planes[slot + TWO] = change_u, change_v
    a, b = start, values[q * ONE + k + np.uint64(4 * GROUP)]
    c = values[q * ONE + k + np.uint64(8 * GROUP)]
    if is_perspective_correct and q > 0:
        # Those values come times reversed Z; what they are held within does not.
        a, b, c = (a / values[k], b / values[np.uint64(4 * GROUP) + k],
                   c / values[np.uint64(8 * GROUP) + k])
    slot = BOUND + q * TWO + k
    planes[slot], planes[slot + ONE] = min(a, b, c), max(a, b, c)


@kernel
def _draw_rows(first_k, end_k, edges, planes, is_perspective_correct, begin, end, stride, depths,
               words):
    """Draw all blocks of the rows of triangles first_k .. end_k - 1 of the group."""
    for k in range(first_k, end_k):
        top = edges[TOP + k]
        columns = (np.uint64(edges[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
        for row in range(max(top, begin), min(edges[END + k], end)):
            # From the triangle's own first row, so that bands make no difference.
            y = np.int32(row - top)
            first = np.uint64((row - begin) * stride + edges[LEFT + k])
            _draw_row(k, y, np.uint64(0), columns, edges, planes, is_perspective_correct, first,
                      depths, words)


@kernel
def _draw_slanted(first_k, end_k, edges, planes, is_perspective_correct, begin, end, stride,
                  depths, words):
    """Draw the same, but of each row only the blocks that can have pixels inside."""
    for k in range(first_k, end_k):
        top = edges[TOP + k]
        columns = (np.uint64(edges[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
        for row in range(max(top, begin), min(edges[END + k], end)):
            y = np.int32(row - top)
            low, high = 0.0, np.float64(columns) - 1.0
            for edge in range(np.uint64(3)):
                slot = edge * ONE + k
                here = np.int32(edges[EDGE + slot] + np.int32(y * edges[EDGE_V + slot]))
                # here + n change is not negative from this column on, or up to it.
                cut = -here / edges[EDGE_U + slot]
                if edges[EDGE_U + slot] > 0:
                    low = max(low, cut)
                elif edges[EDGE_U + slot] < 0:
                    high = min(high, cut)
            inner, last = np.ceil(low - ROUNDING), np.floor(high + ROUNDING)
            if inner <= last:
                start = np.uint64(inner) & WHOLE
                stop = min((np.uint64(last) + np.uint64(LANES)) & WHOLE, columns)
                first = np.uint64((row - begin) * stride + edges[LEFT + k]) + start
                _draw_row(k, y, start, stop - start, edges, planes, is_perspective_correct, first,
                          depths, words)


@inner_kernel
def _draw_row(k, y, start, columns, edges, planes, is_perspective_correct, first, depths, words):
    """Draw `columns` of row y of triangle k from column `start` on, which is pixel `first`."""
    a_u, b_u, c_u = edges[EDGE_U + k], edges[EDGE_U + ONE + k], edges[EDGE_U + TWO + k]
    a = _along(edges[EDGE + k], y, edges[EDGE_V + k])
    b = _along(edges[EDGE + ONE + k], y, edges[EDGE_V + ONE + k])
    c = _along(edges[EDGE + TWO + k], y, edges[EDGE_V + TWO + k])
    ds, dr = planes[ONE + k], planes[THREE + ONE + k]
    dg, db = planes[np.uint64(7 * GROUP) + k], planes[np.uint64(10 * GROUP) + k]
    s_least, r_least = planes[BOUND + k], planes[BOUND + TWO + k]
    s_most, r_most = planes[BOUND + ONE + k], planes[BOUND + THREE + k]
    g_least, b_least = planes[BOUND + TWO + TWO + k], planes[BOUND + THREE + THREE + k]
    g_most, b_most = planes[BOUND + TWO + THREE + k], planes[BOUND + np.uint64(7 * GROUP) + k]
    down = np.float32(y)
    s = planes[k] + planes[TWO + k] * down
    red = planes[THREE + k] + planes[THREE + TWO + k] * down
    green = planes[np.uint64(6 * GROUP) + k] + planes[np.uint64(8 * GROUP) + k] * down
    blue = planes[np.uint64(9 * GROUP) + k] + planes[np.uint64(11 * GROUP) + k] * down
    for j in range(columns & WHOLE):
        n = np.int32(np.int32(start) + np.int32(j))
        i = np.float32(n)
        there = depths[first + j]
        is_inside = (_along(a, n, a_u) | _along(b, n, b_u) | _along(c, n, c_u)) >= 0
        here = hold(s + ds * i, s_least, s_most) if is_inside else np.float32(-np.inf)
        # Stored whether it is new or not: LLVM would mask a store under a condition.
        depths[first + j] = max(here, there)
        if here > there:
            # Perspective-correct colours come times 1 / z (Heckbert, 1989).
            depth = np.float32(1.0) / here if is_perspective_correct else np.float32(1.0)
            words[first + j] = pack(hold((red + dr * i) * depth, r_least, r_most),
                                    hold((green + dg * i) * depth, g_least, g_most),
                                    hold((blue + db * i) * depth, b_least, b_most))


@inner_kernel
def _along(edge, n, change):
    """Return an edge function n steps on; in 32 bits, or else LLVM multiplies with 64, slowly."""
    return np.int32(edge + np.int32(n * change))


@kernel
def _empty_rows(k, edges, begin, end, stride, depths):
    """Empty the depths where triangle k of the group is, so that whatever is drawn is nearer."""
    columns = (np.uint64(edges[COUNT + k]) + np.uint64(LANES - 1)) & WHOLE
    for row in range(max(edges[TOP + k], begin), min(edges[END + k], end)):
        y = np.int32(row - edges[TOP + k])
        a = _along(edges[EDGE + k], y, edges[EDGE_V + k])
        b = _along(edges[EDGE + ONE + k], y, edges[EDGE_V + ONE + k])
        c = _along(edges[EDGE + TWO + k], y, edges[EDGE_V + TWO + k])
        first = np.uint64((row - begin) * stride + edges[LEFT + k])
        for j in range(columns):
            n = np.int32(j)
            if (_along(a, n, edges[EDGE_U + k]) | _along(b, n, edges[EDGE_U + ONE + k])
                    | _along(c, n, edges[EDGE_U + TWO + k])) >= 0:
                depths[first + j] = -np.inf
