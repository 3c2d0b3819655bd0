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
Which nodes a step may have brought to the pole, or out of reach: found by one loop of vectors.

Most are far from both, and collision need not look at them.
"""
import math

from flag_sim.cloth.contact import Contact, Limits
from flag_sim.cloth.planes import separation
from flag_sim.cloth.records import Band, Field, NEXT
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel, wide_kernel
import numpy as np

FAR = 1e9
"""A separation [m] that nothing covers in a step, given to cells beyond the cloth's edges."""
SAFETY_MARGIN = 1e-3
"""Fraction added to a node's displacement, so that rounding cannot hide a contact."""


@wide_kernel
def set_room(position: Field, position_out: Field, limits: Limits, contact: Contact,
             band: Band) -> None:
    """
    Set how much farther each node could have gone before any of its cells met the pole [m].

    Where that is negative, the node has to be looked at more closely. Forgets all planes.
    """
    room, normal_x, normal_y, _ = contact
    center_x, center_y, radius = limits.pole
    cell = limits.cell
    x, y, z = position
    x_out, y_out, z_out = position_out
    number = type(radius)
    one, far, more = number(1.0), number(FAR), number(1.0 + SAFETY_MARGIN)
    edge = radius * more
    first, last, stride = band
    for i in range(first, last):
        n, s = i - stride, i + stride
        xnw, xn, xne = x[n - NEXT] - center_x, x[n] - center_x, x[n + NEXT] - center_x
        xw, xi, xe = x[i - NEXT] - center_x, x[i] - center_x, x[i + NEXT] - center_x
        xsw, xs, xse = x[s - NEXT] - center_x, x[s] - center_x, x[s + NEXT] - center_x
        ynw, yn, yne = y[n - NEXT] - center_y, y[n] - center_y, y[n + NEXT] - center_y
        yw, yi, ye = y[i - NEXT] - center_y, y[i] - center_y, y[i + NEXT] - center_y
        ysw, ys, yse = y[s - NEXT] - center_y, y[s] - center_y, y[s + NEXT] - center_y
        nw = separation((xnw, xn, xw, xi), (ynw, yn, yw, yi), edge)
        ne = separation((xn, xne, xi, xe), (yn, yne, yi, ye), edge)
        sw = separation((xw, xi, xsw, xs), (yw, yi, ysw, ys), edge)
        se = separation((xi, xe, xs, xse), (yi, ye, ys, yse), edge)
        nearest = min(min(nw + (one - cell[n - NEXT]) * far, ne + (one - cell[n]) * far),
                      min(sw + (one - cell[i - NEXT]) * far, se + (one - cell[i]) * far))
        dx, dy, dz = x_out[i] - x[i], y_out[i] - y[i], z_out[i] - z[i]
        room[i] = nearest - more * math.sqrt(dx * dx + dy * dy + dz * dz)
        normal_x[i] = normal_y[i] = number(0.0)


@lean_kernel
def clear_room_out_of_reach(position_out: Field, limits: Limits, room: np.ndarray,
                            band: Band) -> None:
    """Set room to -inf at nodes that are about as far as the cloth reaches, or farther."""
    x, y, z = position_out
    number = type(limits.reach)
    reach2 = limits.reach * limits.reach * number(1.0 - SAFETY_MARGIN)
    for row in range(*rows_of(limits, band)):
        hoist, begin, end = row_of(limits, row, band)
        hx, hy, hz = x[hoist], y[hoist], z[hoist]
        beyond = 0
        for i in range(begin, end):
            dx, dy, dz = x[i] - hx, y[i] - hy, z[i] - hz
            column = number(np.int64(i - hoist))
            beyond += dx * dx + dy * dy + dz * dz > reach2 * column * column
        if beyond > 0:
            for i in range(begin, end):
                dx, dy, dz = x[i] - hx, y[i] - hy, z[i] - hz
                column = number(np.int64(i - hoist))
                if dx * dx + dy * dy + dz * dz > reach2 * column * column:
                    room[i] = number(-math.inf)


@lean_inner_kernel
def rows_of(limits: Limits, band: Band) -> tuple[np.uint64, np.uint64]:
    """Return the first and the last row, not included, that nodes of a band are in."""
    first, last, stride = band
    return ((first - limits.first) // stride,
            (max(last, limits.first) - limits.first + stride - NEXT) // stride)


@lean_inner_kernel
def row_of(limits: Limits, row: np.uint64,
           band: Band) -> tuple[np.uint64, np.uint64, np.uint64]:
    """Return a row's hoist node and the first and last node, not included, in it and a band."""
    first, last, stride = band
    hoist = limits.first + row * stride
    return hoist, max(first, hoist), min(last, hoist + limits.columns)
