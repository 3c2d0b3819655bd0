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

"""Extended position-based dynamics in small steps: springs are projected line after line."""
import math
from typing import NamedTuple

from flag_sim.cloth.aerodynamics import Wind
from flag_sim.cloth.bending import add_bending_forces, set_moments
from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import Coefficients, set_forces
from flag_sim.cloth.material import Air
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Field, NEXT
from flag_sim.cloth.solvers.elementwise import add_weighted, copy, fill
from flag_sim.cloth.solvers.galerkin import set_best
from flag_sim.cloth.solvers.lines import (
    apply_impulses, factor_lines, Family, Lines, project_lines, set_lines)
from flag_sim.cloth.solvers.plate import factor_plate, Plate, project_plate
from flag_sim.cloth.solvers.rigid import Body, FREE, Freedom, freedom_of
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.springs import Springs
from flag_sim.cloth.stability import membrane_frequency_bound
from flag_sim.cloth.state import State
from flag_sim.jit.kernels import kernel, wide_kernel
import numpy as np

MAX_STEP_TIMES_OMEGA = 4.0
"""Longest step, times the cloth's greatest frequency: see XPBD."""
MAX_TENSION = 0.25
"""Greatest tension over a spring's length, times h^2 over a node's mass: see XPBD."""
DRAG_ORDER = 2
"""
The order to which drag is kept from overshooting: see Wind.

Over steps as long as these, one of order 1 would be too weak where the wind only holds the cloth
up and changes no velocity.
"""


class Scratch(NamedTuple):
    """What a step is computed in; nothing is kept in it between steps."""

    lines: tuple       # Lines of rows, columns, rising and falling diagonals
    predicted: Field   # increments [m] by inertia and the forces from outside
    forced: Field      # what the springs' force and stiffness make of them
    free: Field        # what the forces' stiffness makes of the increments by all forces
    impulses: tuple    # two flat fields
    plate: Plate
    cell_mass: float   # of a node inside [kg]
    freedom: Freedom   # which rigid motions the pins leave free

    @classmethod
    def of(cls, model: Model) -> 'Scratch':
        """Return the scratch fields for a model."""
        fields = tuple(model.mesh.fields(11))
        none = (0.0, 0.0, 0.0)
        return cls(tuple(Lines.of(model.mesh) for _ in range(4)), fields[:3], fields[3:6],
                   fields[6:9], fields[9:], Plate.of(model), model.mesh.number(model.cell_mass),
                   Freedom(FREE, none, none))


@wide_kernel
def _predict(velocity, force, inverse_mass, predicted, dt, keep, band):
    """
    Set the increments [m] that the nodes would have by the forces from outside alone.

    keep, what the nodes' damping leaves of a velocity, must not weaken a force that the springs
    will balance: the cloth at rest would seem lighter.
    """
    first, last, _ = band
    for axis in range(3):
        v, f, d = velocity[axis], force[axis], predicted[axis]
        for i in range(first, last):
            d[i] = dt * (keep * v[i] + dt * f[i] * inverse_mass[i])


@kernel
def _add_bending(position, sheet, bend, work, increments, dt, band):
    """Add to increments what bending alone adds to them in a step; work is overwritten."""
    set_moments(position, sheet.weights, bend, work.moments, band)
    fill(work.force, type(dt)(0.0), band)
    add_bending_forces(work.moments, work.force, band)
    add_weighted(increments, dt * dt, sheet.inverse_mass, work.force, band)


@kernel
def _families(weights, springs, dt, stride):
    """Return the springs' families in the order in which a sweep begins: rows come last."""
    none, h2 = np.uint64(0), dt * dt
    k, c, rest = springs.k, springs.c, springs.rest
    return (Family(weights.across, h2 * k[0], dt * c[0], rest[0], none, NEXT),
            Family(weights.down, h2 * k[1], dt * c[1], rest[1], none, stride),
            Family(weights.cell, h2 * k[2], dt * c[2], rest[2], NEXT, stride),
            Family(weights.cell, h2 * k[2], dt * c[2], rest[2], none, stride + NEXT))


@kernel
def _sweep(position, sheet, bend, families, scratch, dt, band):
    """
    Let all families act on both fields, inwards and outwards again, each time half as stiff.

    A sweep that went one way only would not be symmetric, and what is not symmetric can feed a
    motion: folds that jitter, a flag that turns forever in calm air.
    """
    forced, free, lines, impulses = scratch.forced, scratch.free, scratch.lines, scratch.impulses
    inverse_mass = sheet.inverse_mass
    for one in range(4):
        project_lines(forced, free, inverse_mass, families[one], lines[one], impulses, band)
    if max(bend) > 0.0:
        plate = scratch.plate
        project_plate(position, forced, sheet, bend, dt, plate, band)
        project_plate(None, free, sheet, bend, dt, plate, band)
    for one in range(4):
        project_lines(forced, free, inverse_mass, families[3 - one], lines[3 - one], impulses,
                      band)


@wide_kernel
def _advance(position, increments, nodes_out, dt, band):
    """Move the nodes; velocities are the increments over h, not differences of positions."""
    first, last, _ = band
    for axis in range(3):
        x, d = position[axis], increments[axis]
        x_out, v_out = nodes_out.position[axis], nodes_out.velocity[axis]
        for i in range(first, last):
            x_out[i] = x[i] + d[i]
            v_out[i] = d[i] / dt


@kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, scratch, steps, band):
    """Take steps as Solver.take_steps says."""
    dt = steps.dt
    number = type(dt)
    keep = number(1.0) / (number(1.0) + dt * coefficients.node_damping)
    springs, bend = coefficients.springs, coefficients.bend
    zero = number(0.0)
    none = (zero, zero, zero)
    blowing = coefficients.wind
    # The order is that of coefficients, but known when this is compiled: that saves a rounding.
    wind = Wind(blowing.velocity, blowing.drag, blowing.drag_rate, blowing.law, DRAG_ORDER,
                blowing.spin)
    outside = Coefficients(Springs(none, none, springs.rest), none, coefficients.gravity, wind,
                           coefficients.node_damping, coefficients.limits)
    families = _families(sheet.weights, springs, dt, band.stride)
    h2 = dt * dt
    bend_h2 = (h2 * bend[0], h2 * bend[1], h2 * bend[2])
    body = Body(sheet.mass, sheet.inverse_mass, scratch.freedom)
    tensest = number(0.5 * MAX_TENSION) * scratch.cell_mass
    predicted, forced, free = scratch.predicted, scratch.forced, scratch.free
    if max(bend) > 0.0:
        factor_plate(sheet, bend, dt, scratch.plate, band)
    for _ in range(steps.count):
        # Weight and wind (eqs. 1.1, 1.3, 1.4), and where these and inertia alone take the nodes.
        set_forces(nodes, sheet, outside, work, dt, band)
        _predict(nodes.velocity, work.force, sheet.inverse_mass, predicted, dt, keep, band)
        # Two fields to begin the sweep with: these increments, and those by all forces, that is
        # by bending and springs (eq. 1.2) too.
        copy(predicted, forced, band)
        copy(predicted, free, band)
        if max(bend) > 0.0:
            _add_bending(nodes.position, sheet, bend, work, free, dt, band)
        for one in range(4):
            set_lines(nodes.position, predicted, families[one], tensest, scratch.lines[one], band)
            factor_lines(sheet.inverse_mass, families[one], scratch.lines[one], band)
            apply_impulses(free, sheet.inverse_mass, families[one], scratch.lines[one],
                           scratch.impulses[0], band)
        # One sweep over all springs and curvatures, and the best of what it finds.
        _sweep(nodes.position, sheet, bend, families, scratch, dt, band)
        set_best(nodes.position, body, sheet.weights, bend_h2, families, scratch, band)
        _advance(nodes.position, predicted, nodes_out, dt, band)
        # The pole, and the attachment to the hoist.
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)
        nodes, nodes_out = nodes_out, nodes


class XPBD(Solver):
    """
    One symmetric sweep over all curvatures and lines of springs in each of many small steps.

    First order. Springs act implicitly along themselves, explicitly across. Constraints are
    projected with compliance (Macklin, Mueller, Chentanez, XPBD, 2016; Macklin et al., Small Steps
    in Physics Simulation, 2019), all springs of a line together (Deul, Kugelstadt, Weiler, Bender,
    Direct Position-Based Solver for Stiff Rods, 2018). What a sweep finds is put together so that

    - angular momentum is kept: springs keep the direction that they have at the step's beginning,
      in which impulses turn nothing, and rigid motion is not the sweep's to change (see rigid);
    - energy does not grow: from the two fields that the sweep makes, one under the springs' force
      and one of all forces, those parts are taken whose residual r is orthogonal to both
      (Galerkin's condition, as in conjugate gradients). The energy of the cloth with its springs'
      directions held grows by -|v - v*|^2_M / 2 - |d|^2_K / 2 - r . d, and r . d is zero;
    - where the forces balance the cloth rests, at any step: r would be the only force.

    A sweep is no solution: where h omega is large, the orthogonal residual makes the cloth slow to
    give way. So steps are at most MAX_STEP_TIMES_OMEGA / omega long. Across a spring its tension T
    acts explicitly, stable while the sum of h^2 T / length over a node's eight springs is at most
    twice its mass: no tension exceeds MAX_TENSION, which is reached at a strain of 14 % in the
    longest steps. A step is twice as long as one of symplectic and costs thirteen times as much,
    so no error is reached fastest with it. It is provided as a stable XPBD to compare with.
    """

    order = 1
    drag_order = DRAG_ORDER
    useful_step = 1.0 / 600.0
    take_steps = staticmethod(_take_steps)

    @classmethod
    def new_scratch(cls, model: Model) -> Scratch:
        """Return the arrays of a step."""
        return Scratch.of(model)

    def scratch_from(self, state: State) -> Scratch:
        """Return the arrays of a step, and which rigid motions the pins of a state leave free."""
        return self._scratch._replace(freedom=freedom_of(state))

    @staticmethod
    def frequency_bound(model: Model) -> float:
        """Return the bound of the springs alone: the plate is solved by elimination, exactly."""
        return membrane_frequency_bound(model)

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """Return MAX_STEP_TIMES_OMEGA / omega [s]; dashpots and drag are implicit."""
        return MAX_STEP_TIMES_OMEGA / omega if omega > 0.0 else math.inf
