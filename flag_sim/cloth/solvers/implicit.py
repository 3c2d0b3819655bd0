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

"""Backward Euler: every force as it will be at the step's end, so that no step is too long."""
import math
from typing import NamedTuple

from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import Coefficients, set_forces
from flag_sim.cloth.material import Air
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Field
from flag_sim.cloth.solvers.conjugate import solve
from flag_sim.cloth.solvers.elementwise import (
    add, copy, dot, fill, norm2, scale, set_difference, set_sum)
from flag_sim.cloth.solvers.matrix import (
    add_drag, FIELDS, Matrix, multiply, set_faces, set_springs, System)
from flag_sim.cloth.solvers.rigid import (
    add_rigid, Body, FREE, Freedom, freedom_of, inertia_of, rigid_of)
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.springs import Springs
from flag_sim.cloth.state import State
from flag_sim.jit.kernels import inner_kernel, kernel

TOLERANCE = 1e-3
"""Part of the residual that is left; smaller ones change less than the step's own error does."""
MAX_ITERATIONS = 400
"""Iterations in a step; 61 x 41 nodes need 45 at the defaults, 300 at stiffness 1e5."""


class Scratch(NamedTuple):
    """What a step is computed in; nothing is kept in it between steps."""

    matrix: Matrix
    residual: Field   # [N s]
    direction: Field  # of conjugate gradients
    product: Field
    guess: Field      # the velocities that forces are taken at [m/s]
    wind: Field       # the wind's forces there [N]
    freedom: Freedom  # which rigid motions the pins leave free

    @classmethod
    def of(cls, mesh: Mesh) -> 'Scratch':
        """Return the scratch fields for a mesh."""
        fields = tuple(mesh.fields(FIELDS + 15))
        none = (0.0, 0.0, 0.0)
        return cls(Matrix.of(fields), *(fields[at:at + 3] for at in range(FIELDS, FIELDS + 15, 3)),
                   Freedom(FREE, none, none))


@inner_kernel
def _guess(velocity, inverse_mass, gravity, dt, velocity_out, band):
    """Guess that the nodes fall freely."""
    x, y, z = velocity
    x_out, y_out, z_out = velocity_out
    fx, fy, fz = dt * gravity[0], dt * gravity[1], dt * gravity[2]
    none = type(dt)(0.0)
    first, last, _ = band
    for i in range(first, last):
        falls = inverse_mass[i] > 0.0
        x_out[i] = x[i] - (fx if falls else none)
        y_out[i] = y[i] - (fy if falls else none)
        z_out[i] = z[i] - (fz if falls else none)


@inner_kernel
def _set_residual(velocity, velocity_out, force, system, residual, band):
    """Set what the guess y leaves of M (v - y) + h f(x + h y, y) - h nu M y [N s]."""
    mass, node_damping, dt = system.sheet.mass, system.coefficients.node_damping, system.dt
    first, last, _ = band
    for axis in range(3):
        v, y, f, r = velocity[axis], velocity_out[axis], force[axis], residual[axis]
        for i in range(first, last):
            r[i] = mass[i] * (v[i] - y[i] - dt * node_damping * y[i]) + dt * f[i]


@inner_kernel
def _lose_energy(velocity, velocity_out, system, residual, product, band):
    """
    See to it that a system that is not solved to the end gives no energy to the cloth.

    For y with A y = M v - h dE/dx - r, and E quadratic with the Hessian K, the sum of kinetic
    and elastic energy grows in the step to x + h y by

        - |y - v|^2_M / 2 - h^2 y^T K y / 2 - h y^T (C + G + nu M) y - r^T y.

    All but the last are losses. Where that might be more than the first makes up for, y is made as
    long as leaves r^T y = 0, the best that there is in its direction.
    """
    gained = -dot(residual, velocity_out, band)
    set_difference(velocity_out, velocity, product, band)
    if gained > 0.5 * norm2(product, system.sheet.mass, band):
        multiply(system, velocity_out, product, band)
        factor = 1.0 - gained / dot(velocity_out, product, band)
        scale(velocity_out, type(system.dt)(factor), band)


@inner_kernel
def _set_inner(velocity_out, scratch, system, band):
    """Make scratch.product, velocities less the guess, the part that inner forces have in it."""
    inverse_mass, dt = system.sheet.inverse_mass, system.dt
    node_damping = system.coefficients.node_damping
    first, last, _ = band
    for axis in range(3):
        y, f = velocity_out[axis], scratch.wind[axis]
        drag, change = scratch.residual[axis], scratch.product[axis]
        for i in range(first, last):
            change[i] += dt * node_damping * y[i] - inverse_mass[i] * (dt * f[i] - drag[i])


@inner_kernel
def _drag_on(field, scratch, system, band):
    """Set scratch.residual to what the wind's drag takes from velocities, h G times a field."""
    fill(scratch.residual, type(system.dt)(0.0), band)
    if system.coefficients.wind.drag > 0.0:
        add_drag(scratch.matrix, field, system.work.faces, scratch.residual, band)


@inner_kernel
def _keep_momentum(position, velocity_out, scratch, system, band):
    """
    Take off the rigid motion that inner forces seem to have caused, as none can.

    Backward Euler takes them where the nodes will be, and so loses angular momentum: a turn at
    omega fades at the rate h omega^2. The guess has all of gravity; the wind is no inner force
    either, nor its drag on what the velocities differ by from the guess that it was taken at. The
    drag that the change itself meets is taken implicitly, as all drag is here.
    """
    nu, dt, change = system.coefficients.node_damping, system.dt, scratch.product
    body = Body(system.sheet.mass, system.sheet.inverse_mass, scratch.freedom)
    inertia = inertia_of(position, body, band)
    set_difference(velocity_out, scratch.guess, change, band)
    _drag_on(change, scratch, system, band)
    _set_inner(velocity_out, scratch, system, band)
    rigid = rigid_of(position, change, body, inertia, band)
    fill(change, type(dt)(0.0), band)
    add_rigid(position, body.inverse_mass, rigid, change, band)
    _drag_on(change, scratch, system, band)
    inertial = norm2(change, body.mass, band)
    resisting = (1.0 + dt * nu) * inertial + dot(change, scratch.residual, band)
    if resisting > 0.0:
        add(velocity_out, type(dt)(-inertial / resisting), change, band)


@kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, scratch, steps, band):
    """Take steps as Solver.take_steps says."""
    dt, residual = steps.dt, scratch.residual
    zero = type(dt)(0.0)
    none = (zero, zero, zero)
    wind_alone = Coefficients(Springs(none, none, coefficients.springs.rest), none, none,
                              coefficients.wind, coefficients.node_damping, coefficients.limits)
    system = System(scratch.matrix, sheet, coefficients, work, dt)
    for _ in range(steps.count):
        position, velocity = nodes
        position_out, velocity_out = nodes_out
        # Free fall, the guess about which the forces are linearised.
        _guess(velocity, sheet.inverse_mass, coefficients.gravity, dt, velocity_out, band)
        set_sum(position, dt, velocity_out, position_out, band)
        # The wind's momentary force (eqs. 1.3, 1.4): that it weakens as the cloth yields is in A.
        set_forces(nodes_out, sheet, wind_alone, work, zero, band)
        copy(velocity_out, scratch.guess, band)
        copy(work.force, scratch.wind, band)
        # All forces (eq. 1.6), and what they leave of the step's equation.
        set_forces(nodes_out, sheet, coefficients, work, zero, band)
        _set_residual(velocity, velocity_out, work.force, system, residual, band)
        # What a change of velocity does to them: the matrix A of springs and wind.
        set_springs(position_out, sheet.weights, coefficients.springs, scratch.matrix, dt, band)
        if coefficients.wind.drag > 0.0:
            set_faces(nodes_out, coefficients.wind, sheet.weights, scratch.matrix, dt, band)
        # One step of Newton's method, which gives the cloth no energy and no momentum.
        solve(system, residual, scratch.direction, scratch.product, velocity_out, TOLERANCE,
              MAX_ITERATIONS, band)
        _lose_energy(velocity, velocity_out, system, residual, scratch.product, band)
        _keep_momentum(position, velocity_out, scratch, system, band)
        set_sum(position, dt, velocity_out, position_out, band)
        # The pole, and the attachment to the hoist.
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)
        nodes, nodes_out = nodes_out, nodes


class Implicit(Solver):
    """
    Backward Euler with one step of Newton's method, solved by conjugate gradients.

    First order. The velocity y at the step's end obeys M (y - v) = h f(x + h y, y) (Baraff and
    Witkin, Large Steps in Cloth Simulation, 1998); f is linearised about free fall, where springs
    that are pressed together are given no tension (Choi and Ko, Stable but Responsive Cloth, 2002;
    see matrix). The cloth linearised so loses energy in every step, also where the iterations
    end early. It pays for that with its motion: a wave of frequency omega fades at the rate
    h omega^2 / 2, so that long steps still the cloth, and short waves go first.

    What it is for: to check the others. Where forces balance its steps leave no error, however
    long; for motion there is no cloth that it is the cheapest for, and no preset uses it. An
    iteration costs what a step of symplectic does, and a frame takes about as many, since they
    grow with h omega as well: at 1e5 N/m and 61 x 41 nodes 2,300 in ten steps to 1/30 s, where
    symplectic takes 1,300 steps.
    """

    order = 1
    drag_order = 1
    useful_step = 1.0 / 300.0
    take_steps = staticmethod(_take_steps)

    @classmethod
    def new_scratch(cls, model: Model) -> Scratch:
        """Return the arrays of a step."""
        return Scratch.of(model.mesh)

    def scratch_from(self, state: State) -> Scratch:
        """Return the arrays of a step, and which rigid motions the pins of a state leave free."""
        return self._scratch._replace(freedom=freedom_of(state))

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """Return infinity: no step is unstable."""
        return math.inf
