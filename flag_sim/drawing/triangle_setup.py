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
Triangle setup: edge functions and planes of many triangles at a time, ready to be drawn.

A batch holds up to BATCH triangles that are not LARGE. Setting it up is one loop over them, which
LLVM turns into vector instructions: so the arrays are flat, field after field, BATCH places each,
and a field's place for triangle k is its offset + k.
"""
from typing import NamedTuple

from flag_sim.drawing.coverage import edge_function
from flag_sim.drawing.geometry import next_centre, SUBPIXELS
from flag_sim.drawing.pixels import LANES
from flag_sim.jit.kernels import late_inner_kernel

import numpy as np

BATCH = 64
# Batch.integers: corner a and the vectors from it to b and to c [subpixel], ...
A_U, A_V, AB_U, AB_V, AC_U, AC_V = (np.uint64(k * BATCH) for k in range(6))
# ... three edge functions at the first pixel, and their changes a column and a row, ...
EDGE, EDGE_DU, EDGE_DV = (np.uint64((6 + 3 * k) * BATCH) for k in range(3))
# (of the edges from a to b, from c to a and from b to c, with the inside to the left)
AB, CA, BC = (np.uint64(k * BATCH) for k in range(3))
# ... the first column and the number of columns, the first row and the end, twice the triangle's
# index and the side seen, and whether its values must be clamped to their range.
LEFT, COLUMNS, TOP, END, FACE, THIN = (np.uint64(k * BATCH) for k in range(15, 21))
INTEGER_FIELDS = 21
# Batch.values: q = 0 reversed Z, 1 red, 2 green, 3 blue, at corners a, b and c.
VALUES = 4
VALUE = np.uint64(BATCH)  # from q to q + 1 at the same corner
AT_A, AT_B, AT_C = (np.uint64(k * VALUES * BATCH) for k in range(3))
# Batch.planes: each q at the first pixel, and its changes a column and a row.
PLANE = np.uint64(3 * BATCH)  # from q to q + 1
START, DU, DV = (np.uint64(k * BATCH) for k in range(3))
ZERO = np.int32(0)
# Up to which reach (see _is_thin) values need no clamping: rounded to float32, their sums miss
# them by less than 8 2^-24 2^8 of their range, which is a 32nd of a level of colour.
LARGEST_REACH = 2.0 ** 8


class Batch(NamedTuple):
    """Flat int32, float64 and float32 arrays of the fields above."""

    integers: np.ndarray
    values: np.ndarray
    planes: np.ndarray


def new_batch() -> Batch:
    """Make a batch's arrays."""
    return Batch(np.empty(INTEGER_FIELDS * BATCH, np.int32), np.empty(3 * VALUES * BATCH),
                 np.empty(3 * VALUES * BATCH, np.float32))


@late_inner_kernel
def gather(geometry, colours, indices, state, batch):
    """
    Read the corners of triangles with `indices` into the batch, but no backs of closed bodies.

    colours: see rasterizer, or None where only depth is drawn. Returns how many are kept.
    """
    triangles, is_closed, vertices = geometry.triangles, geometry.is_closed, geometry.vertices
    u, v, reversed_z = vertices.u, vertices.v, vertices.reversed_z
    shift_u, shift_v = state.shift_u, state.shift_v
    integers, values = batch.integers, batch.values
    kept = np.uint64(0)
    for k in range(np.uint64(indices.size)):
        t = np.uint64(indices[k])
        a, b = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1])
        c = np.uint64(triangles[t, 2])
        a_u, a_v = u[a] - shift_u, v[a] - shift_v
        ab_u, ab_v = u[b] - shift_u - a_u, v[b] - shift_v - a_v
        ac_u, ac_v = u[c] - shift_u - a_u, v[c] - shift_v - a_v
        # v points down, so the front, counterclockwise, has a negative area.
        side = np.uint64(ab_u * ac_v - ac_u * ab_v > 0)
        integers[A_U + kept], integers[A_V + kept] = a_u, a_v
        integers[AB_U + kept], integers[AB_V + kept] = ab_u, ab_v
        integers[AC_U + kept], integers[AC_V + kept] = ac_u, ac_v
        integers[FACE + kept] = np.uint64(2) * t + side
        values[AT_A + kept], values[AT_B + kept] = reversed_z[a], reversed_z[b]
        values[AT_C + kept] = reversed_z[c]
        if colours is not None:
            colour = colours.values
            at_a, at_b, at_c = (t, t, t) if colours.is_flat else (a, b, c)
            for channel in range(3):
                place = kept + np.uint64((1 + channel) * BATCH)
                values[AT_A + place] = colour[at_a, side, channel]
                values[AT_B + place] = colour[at_b, side, channel]
                values[AT_C + place] = colour[at_c, side, channel]
        kept += np.uint64((side == 0) | (is_closed[t] == 0))
    return kept


@late_inner_kernel
def set_up(colours, count, width, is_perspective_correct, batch):
    """
    Compute edge functions and planes of a batch's first `count` triangles.

    colours: see gather; width: of the image [pixel]. Returns whether one of the triangles is THIN.
    """
    integers, values, planes = batch
    one_pixel = np.int32(SUBPIXELS)
    for k in range(count):
        a_u, a_v = integers[A_U + k], integers[A_V + k]
        ab_u, ab_v = integers[AB_U + k], integers[AB_V + k]
        ac_u, ac_v = integers[AC_U + k], integers[AC_V + k]
        area = ab_u * ac_v - ac_u * ab_v
        left = next_centre(a_u + min(ab_u, ac_u, ZERO))
        right = next_centre(a_u + max(ab_u, ac_u, ZERO))
        top = max(next_centre(a_v + min(ab_v, ac_v, ZERO)), ZERO)
        left = max(left & np.int32(-LANES), ZERO)
        right = min(right, np.int32(width))
        integers[LEFT + k], integers[COLUMNS + k] = left, max(right - left, ZERO)
        integers[TOP + k] = top
        integers[END + k] = next_centre(a_v + max(ab_v, ac_v, ZERO))
        du, dv = left * one_pixel - a_u, top * one_pixel - a_v
        sign = np.int32(1) if area > 0 else np.int32(-1)
        change_u, change_v = -ab_v * sign, ab_u * sign
        integers[EDGE + AB + k] = np.int32(edge_function(change_u, change_v, du, dv))
        integers[EDGE_DU + AB + k], integers[EDGE_DV + AB + k] = change_u, change_v
        change_u, change_v = ac_v * sign, -ac_u * sign
        integers[EDGE + CA + k] = np.int32(edge_function(change_u, change_v, du, dv))
        integers[EDGE_DU + CA + k], integers[EDGE_DV + CA + k] = change_u, change_v
        change_u, change_v = (ab_v - ac_v) * sign, (ac_u - ab_u) * sign
        integers[EDGE + BC + k] = np.int32(
            edge_function(change_u, change_v, du - ab_u, dv - ab_v))
        integers[EDGE_DU + BC + k], integers[EDGE_DV + BC + k] = change_u, change_v

        scale = SUBPIXELS / area
        # Changes a column and a row of the weights of b and c, and the first pixel from a.
        slopes = (ac_v * scale, -ac_u * scale, -ab_v * scale, ab_u * scale,
                  du / SUBPIXELS, dv / SUBPIXELS)
        extent = (max(ab_u, ac_u, ZERO) - min(ab_u, ac_u, ZERO),
                  max(ab_v, ac_v, ZERO) - min(ab_v, ac_v, ZERO))
        integers[THIN + k] = np.int32(_is_thin(values, k, extent, area, right - left,
                                               is_perspective_correct))
        # Four values, written out: LLVM vectorises no loop that has another one inside.
        _plane(values, planes, k, np.uint64(0), slopes, (1.0, 1.0, 1.0))
        if colours is not None:
            # Perspective-correct colours are interpolated multiplied by 1 / z.
            factors = (values[AT_A + k] if is_perspective_correct else 1.0,
                       values[AT_B + k] if is_perspective_correct else 1.0,
                       values[AT_C + k] if is_perspective_correct else 1.0)
            _plane(values, planes, k, np.uint64(1), slopes, factors)
            _plane(values, planes, k, np.uint64(2), slopes, factors)
            _plane(values, planes, k, np.uint64(3), slopes, factors)
    has_thin = np.int32(0)
    for k in range(count):
        has_thin |= integers[THIN + k]
    return has_thin != 0


@late_inner_kernel
def _plane(values, planes, k, q, slopes, factors):
    """Write the plane of triangle k's value q, multiplied by factors at a, b and c."""
    b_du, b_dv, c_du, c_dv, x, y = slopes
    place = q * VALUE + k
    a, b, c = values[AT_A + place], values[AT_B + place], values[AT_C + place]
    a, b, c = a * factors[0], b * factors[1], c * factors[2]
    change_u, change_v = (b - a) * b_du + (c - a) * c_du, (b - a) * b_dv + (c - a) * c_dv
    place = q * PLANE + k
    planes[START + place] = a + change_u * x + change_v * y
    planes[DU + place], planes[DV + place] = change_u, change_v


@late_inner_kernel
def _is_thin(values, k, extent, area, columns, is_perspective_correct):
    """
    Whether values of triangle k must be clamped to their range.

    extent: its columns' and rows' [subpixel]; columns: how many pixels. By the slopes of the
    weights, (|ac_v| + |ab_v|) / area and the like, values change by at most 2 extent_v (columns +
    extent_u) / area of their range from the first pixel to any other; colours that are divided by
    1 / z, by so much more as the greatest exceeds the least.
    """
    reach = np.float64(extent[1]) * np.float64(SUBPIXELS * columns + extent[0])
    a, b, c = values[AT_A + k], values[AT_B + k], values[AT_C + k]
    most = 0.5 * LARGEST_REACH * abs(np.float64(area))
    # NaN, too, is thin.
    if is_perspective_correct:
        return not reach * max(a, b, c) <= most * min(a, b, c)
    return not reach < most
