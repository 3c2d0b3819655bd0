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
Batches: triangles that are not wide, many at a time, made ready to be drawn (see blocks).

Setting up is one loop over a batch's triangles, which LLVM turns into vector instructions: its
arrays are flat, field after field, BATCH places each.
"""
from typing import NamedTuple

from flag_sim.drawing.attributes import keep_slot
from flag_sim.drawing.coverage import edge_function
from flag_sim.drawing.geometry import next_centre, SUBPIXELS
from flag_sim.drawing.pixels import LANES
from flag_sim.jit.kernels import inner_kernel, kernel

import numpy as np

BATCH = 64
# Whole numbers of a triangle: corner a and the ways from it to b and c [subpixels], ...
A_U, A_V, P_U, P_V, Q_U, Q_V = (np.uint64(k * BATCH) for k in range(6))
# ... three edge functions at the first pixel, their changes a column and a row, ...
EDGE, EDGE_U, EDGE_V = (np.uint64((6 + 3 * k) * BATCH) for k in range(3))
# ... the columns' start and number, rows' start and end, twice its number and the side seen, and
# whether its values must be held within their range.
LEFT, COUNT, TOP, END, FACE, THIN = (np.uint64(k * BATCH) for k in range(15, 21))
WHOLE_FIELDS = 21
# At a, b and c: reversed Z, red, green, blue.
VALUE_FIELDS = 12
# Reversed Z, red, green, blue: each at the first pixel, its changes a column and a row.
PLANE_FIELDS = 12
ONE, TWO, THREE, FOUR, EIGHT = (np.uint64(k * BATCH) for k in (1, 2, 3, 4, 8))
ZERO = np.int32(0)
# Up to which reach (see _reach) values need no bounds: rounded to float32, their sums miss them by
# less than 8 2^-24 2^8 of their range, which is a 32nd of a level of colour.
MOST_REACH = 2.0 ** 8


class Batch(NamedTuple):
    """A batch's fields, BATCH places each: flat int32, float64 and float32."""

    whole: np.ndarray
    values: np.ndarray
    planes: np.ndarray


def new_batch() -> Batch:
    """Make a batch's arrays."""
    return Batch(np.empty(WHOLE_FIELDS * BATCH, np.int32), np.empty(VALUE_FIELDS * BATCH),
                 np.empty(PLANE_FIELDS * BATCH, np.float32))


@inner_kernel
def fetch(geometry, colours, numbers, how, batch):
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
def set_up(count, width, is_perspective_correct, batch):
    """
    Make edge functions and planes; each value q is q_0 + q_u (u - ua) + q_v (v - va).

    Returns whether one of the triangles is THIN.
    """
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
        extent = (max(pu, qu, ZERO) - min(pu, qu, ZERO), max(pv, qv, ZERO) - min(pv, qv, ZERO))
        whole[THIN + k] = np.int32(_is_thin(values, k, extent, area, right - left,
                                            is_perspective_correct))
        # Four values, written out: LLVM vectorises no loop that has another one inside.
        _plane(values, planes, k, np.uint64(0), way, (1.0, 1.0, 1.0))
        # Perspective-correct colours are interpolated multiplied by 1 / z.
        times = (values[k] if is_perspective_correct else 1.0,
                 values[FOUR + k] if is_perspective_correct else 1.0,
                 values[EIGHT + k] if is_perspective_correct else 1.0)
        _plane(values, planes, k, np.uint64(1), way, times)
        _plane(values, planes, k, np.uint64(2), way, times)
        _plane(values, planes, k, np.uint64(3), way, times)
    are_thin = np.int32(0)
    for k in range(count):
        are_thin |= whole[THIN + k]
    return are_thin != 0


@inner_kernel
def _plane(values, planes, k, q, way, times):
    """
    Make the plane of value q, times something at a, b and c.

    way: how the weights of b and c change along u and v, and the way from a to the first pixel.
    """
    bu, bv, cu, cv, x, y = way
    place = q * ONE + k
    a, b, c = values[place], values[place + FOUR], values[place + EIGHT]
    a, b, c = a * times[0], b * times[1], c * times[2]
    change_u, change_v = (b - a) * bu + (c - a) * cu, (b - a) * bv + (c - a) * cv
    place = q * THREE + k
    planes[place] = a + change_u * x + change_v * y
    planes[place + ONE], planes[place + TWO] = change_u, change_v


@inner_kernel
def _is_thin(values, k, extent, area, columns, is_perspective_correct):
    """
    Whether values of triangle k must be held within their range.

    extent: its columns' and rows' [subpixel]; columns: how many pixels. By weights' slopes,
    (|qv| + |pv|) / area and the like, they change by at most 2 extent_v (columns + extent_u) /
    area from the first pixel to any other; colours that are divided by 1 / z, by so much
    more as the greatest exceeds the least.
    """
    reach = np.float64(extent[1]) * np.float64(SUBPIXELS * columns + extent[0])
    a, b, c = values[k], values[FOUR + k], values[EIGHT + k]
    most = 0.5 * MOST_REACH * abs(np.float64(area))
    # nan, too, is thin.
    if is_perspective_correct:
        return not reach * max(a, b, c) <= most * min(a, b, c)
    return not reach < most


@kernel
def keep_slots(count, is_perspective, slot, slots, batch):
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
