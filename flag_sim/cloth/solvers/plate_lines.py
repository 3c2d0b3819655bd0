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
The plate's lines: multipliers of curvatures and twists, set, solved and given to the nodes.

A line's matrix is L P L^T. To solve it is to eliminate from its first node to its last, and to
insert from the last to the first. Kernels of pieces (see lanes) take the multipliers twice: what
they read of the piece before, or after, they do not write.
"""
from flag_sim.cloth.records import Band, Field, NEXT
from flag_sim.jit.kernels import inner_kernel, wide_kernel
import numpy as np


@inner_kernel
def _curvature(x, i, back):
    """Return the second difference at node i along one axis."""
    return (x[i + back] - x[i]) - (x[i] - x[i - back])


@wide_kernel
def set_curvatures(base: Field | None, field: Field, weight: np.ndarray, stiffness: float,
                   back: np.uint64, multipliers: Field, begin: np.uint64, end: np.uint64) -> None:
    """Set the multipliers [kg m] that curvatures would have if nothing gave way."""
    for axis in range(3):
        d, p = field[axis], multipliers[axis]
        for i in range(begin, end):
            s = stiffness * weight[i]
            if base is None:
                p[i] = s * _curvature(d, i, back)
            else:
                p[i] = s * _curvature(base[axis], i, back) + s * _curvature(d, i, back)


@wide_kernel
def eliminate_curvatures(factors: tuple, back: np.uint64, multipliers: Field, before: Field,
                         begin: np.uint64, end: np.uint64) -> None:
    """Eliminate a piece. factors: inverse pivots, and the two bands below them."""
    _, below, second = factors
    px, py, pz = multipliers
    bx, by, bz = before
    for i in range(begin, end):
        h, j = i - back - back, i - back
        a, b = below[i], second[i]
        px[i] -= b * bx[h] + a * bx[j]
        py[i] -= b * by[h] + a * by[j]
        pz[i] -= b * bz[h] + a * bz[j]


@wide_kernel
def insert_curvatures(factors: tuple, back: np.uint64, multipliers: Field, after: Field,
                      begin: np.uint64, end: np.uint64) -> None:
    """Insert in a piece."""
    inverse, below, second = factors
    px, py, pz = multipliers
    ax, ay, az = after
    for i in range(begin, end):
        j, k = i + back, i + back + back
        c, a, b = inverse[i], below[j], second[k]
        px[i] = c * px[i] - b * ax[k] - a * ax[j]
        py[i] = c * py[i] - b * ay[k] - a * ay[j]
        pz[i] = c * pz[i] - b * az[k] - a * az[j]


@inner_kernel
def solve_curvatures_of_rows(factors: tuple, multipliers: Field, begin: np.uint64, end: np.uint64,
                             stride: np.uint64) -> None:
    """Solve the systems of rows, in all of them one node after the other."""
    inverse, below, second = factors
    px, py, pz = multipliers
    for column in range(begin, begin + stride):
        for i in range(column, end, stride):
            h, j = i - NEXT - NEXT, i - NEXT
            a, b = below[i], second[i]
            px[i] -= b * px[h] + a * px[j]
            py[i] -= b * py[h] + a * py[j]
            pz[i] -= b * pz[h] + a * pz[j]
    for n in range(stride):
        for i in range(begin + stride - NEXT - n, end, stride):
            j, k = i + NEXT, i + NEXT + NEXT
            c, a, b = inverse[i], below[j], second[k]
            px[i] = c * px[i] - b * px[k] - a * px[j]
            py[i] = c * py[i] - b * py[k] - a * py[j]
            pz[i] = c * pz[i] - b * pz[k] - a * pz[j]


@wide_kernel
def move_curved(field: Field, inverse_mass: np.ndarray, back: np.uint64, multipliers: Field,
                begin: np.uint64, end: np.uint64) -> None:
    """Move each node by the three curvatures of a line that it has a part in."""
    for axis in range(3):
        x, p = field[axis], multipliers[axis]
        for i in range(begin, end):
            x[i] -= inverse_mass[i] * _curvature(p, i, back)


@inner_kernel
def _twist(x, i, stride):
    """Return the twist of the cell whose upper hoist corner is node i, along one axis."""
    e, s, d = i + NEXT, i + stride, i + stride + NEXT
    return (x[i] - x[e]) - (x[s] - x[d])


@wide_kernel
def set_twists(base: Field | None, field: Field, weight: np.ndarray, stiffness: float,
               stride: np.uint64, multipliers: Field, begin: np.uint64, end: np.uint64) -> None:
    """Set the multipliers [kg m] that twists would have if nothing gave way."""
    for axis in range(3):
        d, p = field[axis], multipliers[axis]
        for i in range(begin, end):
            s = stiffness * weight[i]
            if base is None:
                p[i] = s * _twist(d, i, stride)
            else:
                p[i] = s * _twist(base[axis], i, stride) + s * _twist(d, i, stride)


@wide_kernel
def eliminate_twists(factors: tuple, back: np.uint64, multipliers: Field, before: Field,
                     begin: np.uint64, end: np.uint64) -> None:
    """Eliminate a piece. factors: inverse pivots, and the band below them."""
    _, below = factors
    px, py, pz = multipliers
    bx, by, bz = before
    for i in range(begin, end):
        j, a = i - back, below[i]
        px[i] -= a * bx[j]
        py[i] -= a * by[j]
        pz[i] -= a * bz[j]


@wide_kernel
def insert_twists(factors: tuple, back: np.uint64, multipliers: Field, after: Field,
                  begin: np.uint64, end: np.uint64) -> None:
    """Insert in a piece."""
    inverse, below = factors
    px, py, pz = multipliers
    ax, ay, az = after
    for i in range(begin, end):
        j, c, a = i + back, inverse[i], below[i + back]
        px[i] = c * px[i] - a * ax[j]
        py[i] = c * py[i] - a * ay[j]
        pz[i] = c * pz[i] - a * az[j]


@inner_kernel
def solve_twists_of_rows(factors: tuple, multipliers: Field, begin: np.uint64, end: np.uint64,
                         stride: np.uint64) -> None:
    """Solve the systems of rows, in all of them one cell after the other."""
    inverse, below = factors
    px, py, pz = multipliers
    for column in range(begin, begin + stride):
        for i in range(column, end, stride):
            j, a = i - NEXT, below[i]
            px[i] -= a * px[j]
            py[i] -= a * py[j]
            pz[i] -= a * pz[j]
    for n in range(stride):
        for i in range(begin + stride - NEXT - n, end, stride):
            j, c, a = i + NEXT, inverse[i], below[i + NEXT]
            px[i] = c * px[i] - a * px[j]
            py[i] = c * py[i] - a * py[j]
            pz[i] = c * pz[i] - a * pz[j]


@wide_kernel
def move_twisted(field: Field, inverse_mass: np.ndarray, multipliers: Field, band: Band) -> None:
    """Move each node by the twists of the four cells that meet in it."""
    first, last, stride = band
    for axis in range(3):
        x, p = field[axis], multipliers[axis]
        for i in range(first, last):
            w, n = i - NEXT, i - stride
            x[i] -= inverse_mass[i] * ((p[i] - p[w]) - (p[n] - p[n - NEXT]))
