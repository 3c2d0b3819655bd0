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
Bending for position-based dynamics: all curvatures of a line are projected at once.

Projected one after the other, stiff curvatures give way to their neighbours, and the sheet is the
limper the finer its grid is. Bending is quadratic in the positions: curvatures D x of constants s
= h^2 b end a step at x - W D^T p, W the inverse masses, with the Lagrange multipliers p [kg m]
(Macklin, Mueller, Chentanez, XPBD, 2016, (18), times s) of

    (1 + s D W D^T) p = s D x.

Second differences along a line make that a matrix of five diagonals, whose elimination needs no
pivots; it is the same for all steps of a frame.

The twists T x of all cells are projected at once, too. Inverse masses are products w(row)
w(column), so T W T^T is A C, with A of three diagonals along the rows and C of three down the
columns, and

    (1 + r A) (1 + r C) = 1 + s T W T^T + r (A + C),    r^2 = s.

The last term is one too many, and slows what twists down, no more so on finer grids: a free square
that twists to and fro does it 0.5 % too slowly in steps of h omega = 0.001, 3 % in those of 0.01.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Band, Field, NEXT, Sheet, Vector
from flag_sim.cloth.solvers.elementwise import fill
from flag_sim.jit.kernels import kernel, wide_kernel
import numpy as np

FIELDS = 15
"""Flat fields that a Plate lies in."""

CARRIED = 2.0**-10
"""
Greatest s over a node's mass, times a unit in the last place of 1, that is taken.

The matrix has eigenvalues from 1 to 16 times that ratio: beyond, its pivots are but rounding.
In float64 that is never seen; in float32 a ratio of 8,000 is the plate of B = 70 N m on 121 x 81
nodes, in steps of 1/600 s, and stiffer ones are taken to be as soft.
"""


class Plate(NamedTuple):
    """Flat fields: factors of the matrices, and multipliers."""

    across: tuple        # of curvatures along rows: inverse pivots, and the two bands below them
    down: tuple          # and down columns
    twist_across: tuple  # of 1 + r A: inverse pivots, and the band below them
    twist_down: tuple    # of 1 + r C
    share_across: np.ndarray  # the inverse mass of a node is the product of these [kg^-1/2]
    share_down: np.ndarray
    multipliers: tuple   # x, y, z of the multipliers [kg m]
    most: float          # greatest constant s that the fields' precision carries [kg]

    @classmethod
    def of(cls, model: Model) -> 'Plate':
        """Return the fields for a model, with nothing in them but the shares."""
        mesh = model.mesh
        fields = tuple(mesh.fields(FIELDS))
        plate = cls(fields[:3], fields[3:6], fields[6:8], fields[8:10], fields[10], fields[11],
                    fields[12:15],
                    mesh.number(model.cell_mass * CARRIED / np.finfo(mesh.precision).eps))
        share = mesh.grid(mesh.mass_share) / mesh.grid(mesh.mass_share)[0, 0]
        unit = 2.0 / math.sqrt(model.cell_mass)
        mesh.grid(plate.share_across)[...] = unit * mesh.grid(mesh.free) / share[:1]
        mesh.grid(plate.share_down)[...] = unit / share[:, :1]
        return plate


@kernel
def _factor_curvatures(inverse_mass, weight, stiffness, back, factors, band):
    """Factor 1 + s D W D^T of lines, nodes of which lie `back` apart, into L P L^T."""
    inverse, below, second = factors
    one, two, four = type(stiffness)(1.0), type(stiffness)(2.0), type(stiffness)(4.0)
    first, last, _ = band
    for i in range(first, last):
        s = stiffness * weight[i]
        if s > 0.0:
            j = i - back
            w_j, w = inverse_mass[j], inverse_mass[i]
            diagonal = one + s * (w_j + four * w + inverse_mass[i + back])
            far = s * w_j
            near = -two * s * (w_j + w) - far * below[j]
            below[i], second[i] = near * inverse[j], far * inverse[j - back]
            inverse[i] = one / (diagonal - near * below[i] - far * second[i])
        else:
            inverse[i], below[i], second[i] = 0.0, 0.0, 0.0


@kernel
def _factor_twists(share, weight, root, back, factors, band):
    """Factor 1 + r A, or 1 + r C, into L P L^T."""
    inverse, below = factors
    one = type(root)(1.0)
    first, last, _ = band
    for i in range(first, last):
        if weight[i] > 0.0:
            j = i - back
            near = -root * share[i]
            below[i] = near * inverse[j]
            inverse[i] = one / (one + root * (share[i] + share[i + back]) - near * below[i])
        else:
            inverse[i], below[i] = 0.0, 0.0


@kernel
def _constants(bend, dt, plate):
    """Return the constants s [kg] across, down and of twist in steps of dt [s]."""
    h2 = dt * dt
    return (min(h2 * bend[0], plate.most), min(h2 * bend[1], plate.most),
            min(h2 * bend[2], plate.most))


@kernel
def factor_plate(sheet: Sheet, bend: Vector, dt: float, plate: Plate, band: Band) -> None:
    """Factor the matrices for steps of dt [s]."""
    across, down, twist = _constants(bend, dt, plate)
    root = math.sqrt(twist)
    stride = band.stride
    inverse_mass, weights = sheet.inverse_mass, sheet.weights
    _factor_curvatures(inverse_mass, weights.bend_across, across, NEXT, plate.across, band)
    _factor_curvatures(inverse_mass, weights.bend_down, down, stride, plate.down, band)
    _factor_twists(plate.share_across, weights.cell, root, NEXT, plate.twist_across, band)
    _factor_twists(plate.share_down, weights.cell, root, stride, plate.twist_down, band)


@wide_kernel
def _add_curvatures(field, weight, stiffness, back, multipliers, band):
    """Add the multipliers [kg m] that curvatures of a field would have if nothing gave way."""
    first, last, _ = band
    for axis in range(3):
        x, p = field[axis], multipliers[axis]
        for i in range(first, last):
            j, k = i - back, i + back
            p[i] += stiffness * weight[i] * ((x[k] - x[i]) - (x[i] - x[j]))


@kernel
def _solve_curvatures(factors, back, multipliers, band):
    """
    Solve L P L^T p' = p in place, for lines with nodes `back` apart.

    Only nodes that have a curvature are looked at: two lines before others there is no memory.
    """
    inverse, below, second = factors
    px, py, pz = multipliers
    first, last, _ = band
    for i in range(first, last):
        if inverse[i] > 0.0:
            h, j = i - back - back, i - back
            a, b = below[i], second[i]
            px[i] -= b * px[h] + a * px[j]
            py[i] -= b * py[h] + a * py[j]
            pz[i] -= b * pz[h] + a * pz[j]
    for n in range(last - first):
        i = last - NEXT - n
        if inverse[i] > 0.0:
            j, k = i + back, i + back + back
            c, a, b = inverse[i], below[j], second[k]
            px[i] = c * px[i] - b * px[k] - a * px[j]
            py[i] = c * py[i] - b * py[k] - a * py[j]
            pz[i] = c * pz[i] - b * pz[k] - a * pz[j]


@wide_kernel
def _move_curved(field, inverse_mass, back, multipliers, band):
    """Move each node by the three curvatures of a line that it has a part in."""
    first, last, _ = band
    for axis in range(3):
        x, p = field[axis], multipliers[axis]
        for i in range(first, last):
            x[i] -= inverse_mass[i] * ((p[i + back] - p[i]) - (p[i] - p[i - back]))


@kernel
def _solve_twists(factors, back, multipliers, band):
    """Solve L P L^T p' = p in place, for lines with cells `back` apart."""
    inverse, below = factors
    px, py, pz = multipliers
    first, last, _ = band
    for i in range(first, last):
        j, a = i - back, below[i]
        px[i] -= a * px[j]
        py[i] -= a * py[j]
        pz[i] -= a * pz[j]
    for n in range(last - first):
        i = last - NEXT - n
        j, c, a = i + back, inverse[i], below[i + back]
        px[i] = c * px[i] - a * px[j]
        py[i] = c * py[i] - a * py[j]
        pz[i] = c * pz[i] - a * pz[j]


@wide_kernel
def _add_twists(field, weight, stiffness, multipliers, band):
    """Add the multipliers [kg m] that twists of a field would have if nothing gave way."""
    first, last, stride = band
    for axis in range(3):
        x, p = field[axis], multipliers[axis]
        for i in range(first, last):
            e, s, d = i + NEXT, i + stride, i + stride + NEXT
            p[i] += stiffness * weight[i] * ((x[i] - x[e]) - (x[s] - x[d]))


@wide_kernel
def _move_twisted(field, inverse_mass, multipliers, band):
    """Move each node by the twists of the four cells that meet in it."""
    first, last, stride = band
    for axis in range(3):
        x, p = field[axis], multipliers[axis]
        for i in range(first, last):
            w, n = i - NEXT, i - stride
            x[i] -= inverse_mass[i] * ((p[i] - p[w]) - (p[n] - p[n - NEXT]))


@kernel
def project_plate(base: Field | None, increments: Field, sheet: Sheet, bend: Vector, dt: float,
                  plate: Plate, band: Band) -> None:
    """
    Let bending act on increments d (x, y, z) [m]: twists, curvatures of columns, then of rows.

    base: positions that have curvatures too; None where the plate only resists. Theirs are added
    to those of d, not taken of the sum, which would be rounded as positions are. The matrices are
    those of the last factor_plate.
    """
    across, down, twist = _constants(bend, dt, plate)
    weights, inverse_mass = sheet.weights, sheet.inverse_mass
    stride, p = band.stride, plate.multipliers
    zero = type(dt)(0.0)
    # Twists of all cells.
    fill(p, zero, band)
    if base is not None:
        _add_twists(base, weights.cell, twist, p, band)
    _add_twists(increments, weights.cell, twist, p, band)
    _solve_twists(plate.twist_across, NEXT, p, band)
    _solve_twists(plate.twist_down, stride, p, band)
    _move_twisted(increments, inverse_mass, p, band)
    # Curvatures of the columns.
    fill(p, zero, band)
    if base is not None:
        _add_curvatures(base, weights.bend_down, down, stride, p, band)
    _add_curvatures(increments, weights.bend_down, down, stride, p, band)
    _solve_curvatures(plate.down, stride, p, band)
    _move_curved(increments, inverse_mass, stride, p, band)
    # Curvatures of the rows.
    fill(p, zero, band)
    if base is not None:
        _add_curvatures(base, weights.bend_across, across, NEXT, p, band)
    _add_curvatures(increments, weights.bend_across, across, NEXT, p, band)
    _solve_curvatures(plate.across, NEXT, p, band)
    _move_curved(increments, inverse_mass, NEXT, p, band)
