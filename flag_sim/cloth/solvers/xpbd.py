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

"""Extended position-based dynamics in small steps: springs are met line after line."""
import math
from typing import NamedTuple

from flag_sim.cloth.bending import add_moments, set_moments
from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import Coefficients, set_forces
from flag_sim.cloth.mesh import ONE
from flag_sim.cloth.rigid import (
    add_rigid, Body, freedom_of, inertia, mass_center, rigid_of, SUMS, take_rigid)
from flag_sim.cloth.solvers.lines import (
    factor_lines, Family, Lines, meet_lines, pull_lines, set_lines, work_of_lines)
from flag_sim.cloth.solvers.plate import clear, factor_plate, meet_plate, Plate
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.stability import membrane_frequency_bound
from flag_sim.jit.kernels import inner_kernel, kernel, wide_kernel
import numpy as np

LONGEST = 4.0
"""Longest step, times the cloth's greatest frequency: see XPBD."""
TENSEST = 0.25
"""Greatest tension over a spring's length, times h^2 over a node's mass: see XPBD."""
ALIKE = 1e-9
"""Part of a field's square below which all of it but rounding is along another field."""


class Scratch(NamedTuple):
    """What a step is computed in; nothing is kept in it between steps."""

    lines: tuple       # Lines of rows, columns, rising and falling diagonals
    predicted: tuple   # increments x, y, z [m] by inertia and the forces from outside
    pulled: tuple      # what the springs' pull and stiffness make of them
    free: tuple        # what the forces' stiffness makes of the increments by all forces
    impulses: tuple    # two flat fields
    plate: Plate
    cell_mass: float   # of a node inside [kg]

    @classmethod
    def of(cls, model):
        """Return the scratch fields for a model."""
        fields = tuple(model.mesh.fields(11))
        return cls(tuple(Lines.of(model.mesh) for _ in range(4)), fields[:3], fields[3:6],
                   fields[6:9], fields[9:], Plate.of(model), model.mesh.number(model.cell_mass))


@wide_kernel
def _predict(velocity, force, inverse_mass, predicted, dt, keep, span):
    """
    Set the increments [m] that the nodes would have by the forces from outside alone.

    keep, what the nodes' damping leaves of a velocity, must not weaken a force that the springs
    will balance: the cloth at rest would seem lighter.
    """
    first, last, _ = span
    for axis in range(3):
        v, f, d = velocity[axis], force[axis], predicted[axis]
        for i in range(first, last):
            d[i] = dt * (keep * v[i] + dt * f[i] * inverse_mass[i])


@wide_kernel
def _copy(field, copy, span):
    """Copy a field."""
    first, last, _ = span
    for axis in range(3):
        a, b = field[axis], copy[axis]
        for i in range(first, last):
            b[i] = a[i]


@wide_kernel
def _add_forces(force, inverse_mass, increments, dt, span):
    """Add to increments what forces [N] add to them in a step."""
    h2 = dt * dt
    first, last, _ = span
    for axis in range(3):
        f, d = force[axis], increments[axis]
        for i in range(first, last):
            d[i] += h2 * inverse_mass[i] * f[i]


@kernel
def _add_bending(position, inverse_mass, weights, bend, work, increments, dt, span):
    """Add to increments what bending alone adds to them in a step; work is overwritten."""
    set_moments(position, weights, bend, work.moments, span)
    clear(work.force, span)
    add_moments(work.moments, work.force, span)
    _add_forces(work.force, inverse_mass, increments, dt, span)


@inner_kernel
def _difference(x, before, i, after):
    """Return the second difference of a field at node i, along one axis."""
    return np.float64((x[after] - x[i]) - (x[i] - x[before]))


@inner_kernel
def _twist(x, i, e, s, d):
    """Return the twist of a field on the cell whose corners are i, e, s and d, along one axis."""
    return np.float64((x[i] - x[e]) - (x[s] - x[d]))


@kernel
def _work_of_plate(position, a, b, weights, bend, span):
    """
    Return (a K a, a K b, b K b, pull a, pull b) of two fields of increments, in float64.

    K: h^2 times the Hessian of bending, of constants bend [kg]; pull: h^2 times its forces.
    """
    across, down, twist = np.float64(bend[0]), np.float64(bend[1]), np.float64(bend[2])
    aa, ab, bb, pa, pb = 0.0, 0.0, 0.0, 0.0, 0.0
    first, last, stride = span
    for axis in range(3):
        x, u, v = position[axis], a[axis], b[axis]
        for i in range(first, last):
            e, w, s, n, d = i + ONE, i - ONE, i + stride, i - stride, i + stride + ONE
            k = across * weights.bend_across[i]
            c, f, g = _difference(x, w, i, e), _difference(u, w, i, e), _difference(v, w, i, e)
            aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
            pa, pb = pa - k * c * f, pb - k * c * g
            k = down * weights.bend_down[i]
            c, f, g = _difference(x, n, i, s), _difference(u, n, i, s), _difference(v, n, i, s)
            aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
            pa, pb = pa - k * c * f, pb - k * c * g
            k = twist * weights.cell[i]
            c, f, g = _twist(x, i, e, s, d), _twist(u, i, e, s, d), _twist(v, i, e, s, d)
            aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
            pa, pb = pa - k * c * f, pb - k * c * g
    return aa, ab, bb, pa, pb


@inner_kernel(fastmath=SUMS)
def _products(a, b, c, mass, span):
    """Return (a M a, a M b, b M b, a M c, b M c) of three fields, in float64."""
    aa, ab, bb, ac, bc = 0.0, 0.0, 0.0, 0.0, 0.0
    first, last, _ = span
    for axis in range(3):
        u, v, w = a[axis], b[axis], c[axis]
        for i in range(first, last):
            m, f, g = np.float64(mass[i]), np.float64(u[i]), np.float64(v[i])
            aa += m * f * f
            ab += m * f * g
            bb += m * g * g
            ac += m * f * w[i]
            bc += m * g * w[i]
    return aa, ab, bb, ac, bc


@inner_kernel
def _shares(aa, ab, bb, a_rhs, b_rhs):
    """Solve [[aa, ab], [ab, bb]] (f, g) = (a_rhs, b_rhs), by the first alone if both are alike."""
    if not aa > 0.0:
        return 0.0, b_rhs / bb if bb > 0.0 else 0.0
    left = bb - ab * ab / aa
    g = (b_rhs - ab / aa * a_rhs) / left if left > ALIKE * bb else 0.0
    return (a_rhs - ab * g) / aa, g


@inner_kernel
def _set_sum(f, a, g, b, total, span):
    """Set a field to f times one and g times another."""
    first, last, _ = span
    for axis in range(3):
        u, v, t = a[axis], b[axis], total[axis]
        for i in range(first, last):
            t[i] = f * u[i] + g * v[i]


@kernel
def _combine(position, body, weights, bend, families, scratch, span):
    """
    Set scratch.predicted to the best increments that the two fields of the sweep span.

    The best are those of least energy |d - d*|^2_M / 2 + d K d / 2 - pull d, d* the predicted
    ones: their residual is orthogonal to both fields, which is why energy cannot grow (see XPBD).
    Rigid motion is set apart: no inner force acts on it, and it stays as predicted.
    """
    a, b, predicted = scratch.free, scratch.pulled, scratch.predicted
    total, center = mass_center(position, body.mass, body.freedom, span)
    moments = inertia(position, body.mass, center, span)
    rigid = rigid_of(position, predicted, body, total, center, moments, span)
    for field in (a, b, predicted):
        take_rigid(position, field, body, total, center, moments, span)

    aa, ab, bb, a_rhs, b_rhs = _products(a, b, predicted, body.mass, span)
    for one in range(4):
        k_aa, k_ab, k_bb, pull_a, pull_b = work_of_lines(a, b, families[one], scratch.lines[one],
                                                         span)
        aa, ab, bb, a_rhs, b_rhs = (aa + k_aa, ab + k_ab, bb + k_bb, a_rhs + pull_a,
                                    b_rhs + pull_b)
    if max(bend) > 0.0:
        k_aa, k_ab, k_bb, pull_a, pull_b = _work_of_plate(position, a, b, weights, bend, span)
        aa, ab, bb, a_rhs, b_rhs = (aa + k_aa, ab + k_ab, bb + k_bb, a_rhs + pull_a,
                                    b_rhs + pull_b)
    f, g = _shares(aa, ab, bb, a_rhs, b_rhs)
    number = type(bend[0])
    _set_sum(number(f), a, number(g), b, predicted, span)
    add_rigid(position, body.inverse_mass, rigid, predicted, span)


@kernel
def _families(weights, k, c, rest, dt, stride):
    """Return the springs' families in the order in which a sweep begins: rows come last."""
    none, h2 = np.uint64(0), dt * dt
    return (Family(weights.across, h2 * k[0], dt * c[0], rest[0], none, ONE),
            Family(weights.down, h2 * k[1], dt * c[1], rest[1], none, stride),
            Family(weights.cell, h2 * k[2], dt * c[2], rest[2], ONE, stride),
            Family(weights.cell, h2 * k[2], dt * c[2], rest[2], none, stride + ONE))


@kernel
def _sweep(position, inverse_mass, weights, bend, families, scratch, dt, span):
    """
    Let all families act on both fields, inwards and outwards again, each time half as stiff.

    A sweep that went one way only would not be symmetric, and what is not symmetric can feed a
    motion: folds that shiver, a flag that turns for ever in calm air.
    """
    pulled, free, lines, impulses = scratch.pulled, scratch.free, scratch.lines, scratch.impulses
    for one in range(4):
        meet_lines(pulled, free, inverse_mass, families[one], lines[one], impulses, span)
    if max(bend) > 0.0:
        plate = scratch.plate
        meet_plate(position, pulled, inverse_mass, weights, bend, dt, plate, span)
        meet_plate(None, free, inverse_mass, weights, bend, dt, plate, span)
    for one in range(4):
        meet_lines(pulled, free, inverse_mass, families[3 - one], lines[3 - one], impulses, span)


@wide_kernel
def _advance(position, increments, position_out, velocity_out, dt, span):
    """Move the nodes; velocities are the increments over h, not differences of positions."""
    first, last, _ = span
    for axis in range(3):
        x, d = position[axis], increments[axis]
        x_out, v_out = position_out[axis], velocity_out[axis]
        for i in range(first, last):
            x_out[i] = x[i] + d[i]
            v_out[i] = d[i] / dt


@kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, scratch, freedom, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    number = type(dt)
    keep = number(1.0) / (number(1.0) + dt * coefficients.node_damping)
    zero = number(0.0)
    none = (zero, zero, zero)
    # Drag keeps from overshooting as in a method of order 2: taken over steps as long as these to
    # order 1, a wind that only holds the cloth up, and changes no velocity, would be too weak.
    outside = Coefficients(none, none, coefficients.spring_rest, none, coefficients.gravity,
                           coefficients.drag, coefficients.drag_rate, coefficients.law, 2,
                           coefficients.node_damping, coefficients.limits)
    families = _families(weights, coefficients.spring_k, coefficients.spring_c,
                         coefficients.spring_rest, dt, span[2])
    bend = coefficients.bend
    h2 = dt * dt
    bend_h2 = (h2 * bend[0], h2 * bend[1], h2 * bend[2])
    body = Body(mass, inverse_mass, freedom)
    tensest = number(0.5 * TENSEST) * scratch.cell_mass
    predicted, pulled, free = scratch.predicted, scratch.pulled, scratch.free
    if max(bend) > 0.0:
        factor_plate(inverse_mass, weights, bend, dt, scratch.plate, span)
    for _ in range(count):
        set_forces(position, velocity, wind, mass, weights, outside, work, dt, span)
        _predict(velocity, work.force, inverse_mass, predicted, dt, keep, span)
        _copy(predicted, pulled, span)
        _copy(predicted, free, span)
        if max(bend) > 0.0:
            _add_bending(position, inverse_mass, weights, bend, work, free, dt, span)
        for one in range(4):
            set_lines(position, predicted, families[one], tensest, scratch.lines[one], span)
            factor_lines(inverse_mass, families[one], scratch.lines[one], span)
            pull_lines(free, inverse_mass, families[one], scratch.lines[one], scratch.impulses[0],
                       span)
        _sweep(position, inverse_mass, weights, bend, families, scratch, dt, span)
        _combine(position, body, weights, bend_h2, families, scratch, span)
        _advance(position, predicted, position_out, velocity_out, dt, span)
        collide(position, position_out, velocity_out, coefficients.limits, work.contact, span)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class XPBD(Solver):
    """
    One symmetric sweep over all curvatures and lines of springs in each of many small steps.

    First order. Springs act implicitly along themselves, explicitly across. Constraints are met
    with compliance (Macklin, Mueller, Chentanez, XPBD, 2016; Macklin et al., Small Steps in
    Physics Simulation, 2019), all springs of a line together (Deul, Kugelstadt, Weiler, Bender,
    Direct Position-Based Solver for Stiff Rods, 2018). What a sweep finds is put together so that

    - angular momentum is kept: springs keep the direction that they have at the step's beginning,
      in which impulses turn nothing, and rigid motion is not the sweep's to change (see rigid);
    - energy does not grow: from the two fields that the sweep makes, one under the springs' pull
      and one of all forces, those shares are taken whose residual r is orthogonal to both
      (Galerkin's condition, as in conjugate gradients). The energy of the cloth with its springs'
      directions held grows by -|v - v*|^2_M / 2 - |d|^2_K / 2 - r . d, and r . d is zero;
    - where the forces balance the cloth rests, at any step: r would be the only force.

    A sweep is no solution: where h omega is large, the orthogonal residual makes the cloth slow to
    give way. So steps are at most LONGEST / omega long. Across a spring its tension T acts
    explicitly, stable while the sum of h^2 T / length over a node's eight springs is at most
    twice its mass: a spring never pulls harder than TENSEST allows, which is as at a strain of
    14 % in the longest steps. A step is twice as long as one of symplectic and costs thirteen
    of them: nothing is cheapest with it. It is here as the method of its name that keeps its word.
    """

    order = 1
    useful_step = 1.0 / 600.0
    take_steps = staticmethod(_take_steps)

    def __init__(self, model):
        super().__init__(model)
        self._scratch = (Scratch.of(model), None)

    def advance(self, state, *arguments):
        """Take steps as every Solver does; which rigid motions are free follows from the pins."""
        self._scratch = (self._scratch[0], freedom_of(state))
        return super().advance(state, *arguments)

    @staticmethod
    def frequency_bound(model):
        """Return the bound of the springs alone: the plate is met by elimination, exactly."""
        return membrane_frequency_bound(model)

    @staticmethod
    def largest_step(omega, gamma, air):
        """Return LONGEST / omega [s]; dashpots and drag are implicit."""
        del gamma, air
        return LONGEST / omega if omega > 0.0 else math.inf
