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
from flag_sim.cloth.solvers.lanes import (
    count_pieces, lanes_of, piece, row_range, ROWS, rows_of)
from flag_sim.cloth.solvers.plate_lines import (
    eliminate_curvatures, eliminate_twists, insert_curvatures, insert_twists, move_curved,
    move_twisted, set_curvatures, set_twists, solve_curvatures_of_rows, solve_twists_of_rows)
from flag_sim.jit.kernels import kernel, shared_kernel
from flag_sim.parallel.barrier import wait
import numpy as np

FIELDS = 18
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
    multipliers_of_free: tuple  # and of those of a second field
    most: float          # greatest constant s that the fields' precision carries [kg]

    @classmethod
    def of(cls, model: Model) -> 'Plate':
        """Return the fields for a model, with nothing in them but the shares."""
        mesh = model.mesh
        fields = tuple(mesh.fields(FIELDS))
        plate = cls(fields[:3], fields[3:6], fields[6:8], fields[8:10], fields[10], fields[11],
                    fields[12:15], fields[15:],
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
def plate_constants(bend: Vector, dt: float, plate: Plate) -> Vector:
    """Return the constants s [kg] across, down and of twist in steps of dt [s]."""
    h2 = dt * dt
    return (min(h2 * bend[0], plate.most), min(h2 * bend[1], plate.most),
            min(h2 * bend[2], plate.most))


@kernel
def factor_plate(sheet: Sheet, constants: Vector, plate: Plate, band: Band) -> None:
    """Factor the matrices, for constants of plate_constants."""
    across, down, twist = constants
    root = math.sqrt(twist)
    stride = band.stride
    inverse_mass, weights = sheet.inverse_mass, sheet.weights
    _factor_curvatures(inverse_mass, weights.bend_across, across, NEXT, plate.across, band)
    _factor_curvatures(inverse_mass, weights.bend_down, down, stride, plate.down, band)
    _factor_twists(plate.share_across, weights.cell, root, NEXT, plate.twist_across, band)
    _factor_twists(plate.share_down, weights.cell, root, stride, plate.twist_down, band)


@kernel
def _project_columns(base, increments, sheet, stiffness, plate, p, bands):
    """Let the curvatures of the columns act, each thread's on its own; see project_plate."""
    (band, whole), weight = bands, sheet.weights.bend_down
    stride = band.stride
    lanes = lanes_of(stride, band, whole)
    nodes = count_pieces(whole.first, whole.last, lanes[2])
    for n in range(nodes):
        first, last = piece(n, whole.first, whole.last, lanes)
        set_curvatures(base, increments, weight, stiffness, stride, p, first, last)
    # The first and the last node of a column have no curvature, and no neighbours beyond.
    begin, end = whole.first + stride, whole.last - stride
    count = count_pieces(begin, end, lanes[2])
    for n in range(count):
        first, last = piece(count - 1 - n, begin, end, lanes)
        eliminate_curvatures(plate.down, stride, p, p, first, last)
    for n in range(count):
        first, last = piece(n, begin, end, lanes)
        insert_curvatures(plate.down, stride, p, p, first, last)
    for n in range(nodes):
        first, last = piece(n, whole.first, whole.last, lanes)
        move_curved(increments, sheet.inverse_mass, stride, p, first, last)


@kernel
def _project_rows(base, increments, sheet, stiffness, plate, p, bands):
    """Let the curvatures of the rows act, each thread's on its own; see project_plate."""
    (band, whole), weight = bands, sheet.weights.bend_across
    row, last_row = rows_of(band, whole)
    while row < last_row:
        begin, end = row_range(row, last_row, whole)
        set_curvatures(base, increments, weight, stiffness, NEXT, p, begin, end)
        solve_curvatures_of_rows(plate.across, p, begin, end, whole.stride)
        move_curved(increments, sheet.inverse_mass, NEXT, p, begin, end)
        row += ROWS


@kernel
def _solve_twists(base, increments, sheet, stiffness, plate, p, bands):
    """Set the multipliers of all twists, but for what the columns make of them."""
    band, whole = bands
    row, last_row = rows_of(band, whole)
    while row < last_row:
        begin, end = row_range(row, last_row, whole)
        set_twists(base, increments, sheet.weights.cell, stiffness, whole.stride, p, begin, end)
        solve_twists_of_rows(plate.twist_across, p, begin, end, whole.stride)
        row += ROWS


@kernel
def _solve_twists_of_columns(plate, p, bands):
    """Set the multipliers of all twists, given what _solve_twists has made of them."""
    band, whole = bands
    stride = band.stride
    lanes = lanes_of(stride, band, whole)
    count = count_pieces(whole.first, whole.last, lanes[2])
    for n in range(count):
        begin, end = piece(count - 1 - n, whole.first, whole.last, lanes)
        eliminate_twists(plate.twist_down, stride, p, p, begin, end)
    for n in range(count):
        begin, end = piece(n, whole.first, whole.last, lanes)
        insert_twists(plate.twist_down, stride, p, p, begin, end)


@shared_kernel
def project_plate(base: Field, forced: Field, free: Field, sheet: Sheet, constants: Vector,
                  plate: Plate, bands: tuple[Band, Band], barrier: np.ndarray) -> None:
    """
    Let bending act on increments d (x, y, z) [m]: twists, curvatures of columns, then of rows.

    forced: of a cloth at positions base, which have curvatures too. Theirs are added to those of
    d, not taken of the sum, which would be rounded as positions are. free: of one that is flat.
    constants: of plate_constants; the matrices are those of the last factor_plate. bands: whose
    lines act, and all nodes.
    """
    across, down, twist = constants
    inverse_mass, band = sheet.inverse_mass, bands[0]
    p, q = plate.multipliers, plate.multipliers_of_free
    _solve_twists(base, forced, sheet, twist, plate, p, bands)
    _solve_twists(None, free, sheet, twist, plate, q, bands)
    wait(barrier)
    _solve_twists_of_columns(plate, p, bands)
    _solve_twists_of_columns(plate, q, bands)
    wait(barrier)
    move_twisted(forced, inverse_mass, p, band)
    move_twisted(free, inverse_mass, q, band)
    wait(barrier)
    _project_columns(base, forced, sheet, down, plate, p, bands)
    _project_columns(None, free, sheet, down, plate, q, bands)
    wait(barrier)
    _project_rows(base, forced, sheet, across, plate, p, bands)
    _project_rows(None, free, sheet, across, plate, q, bands)
    wait(barrier)
