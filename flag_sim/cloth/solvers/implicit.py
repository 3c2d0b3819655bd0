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
from flag_sim.cloth.rigid import (
    add_rigid, Body, freedom_of, inertia, mass_center, rigid_of)
from flag_sim.cloth.solvers.conjugate import add, dot, norm2, solve
from flag_sim.cloth.solvers.matrix import (
    add_drag, FIELDS, Matrix, multiply, set_faces, set_springs)
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import inner_kernel, kernel

TOLERANCE = 1e-3
"""Part of the residual that is left; smaller ones change less than the step's own error does."""
LIMIT = 400
"""Iterations in a step; 61 x 41 nodes need 45 at the defaults, 300 at stiffness 1e5."""


class Scratch(NamedTuple):
    """What a step is computed in; nothing is kept in it between steps."""

    matrix: Matrix
    residual: tuple   # x, y, z [N s]
    direction: tuple  # of conjugate gradients
    product: tuple
    guess: tuple      # the velocities that forces are taken at [m/s]
    wind: tuple       # the wind's forces there [N]

    @classmethod
    def of(cls, mesh):
        """Return the scratch fields for a mesh."""
        fields = tuple(mesh.fields(FIELDS + 15))
        return cls(Matrix.of(fields), *(fields[at:at + 3] for at in range(FIELDS, FIELDS + 15, 3)))


@inner_kernel
def _guess(velocity, inverse_mass, gravity, dt, velocity_out, span):
    """Guess that the nodes fall freely."""
    x, y, z = velocity
    x_out, y_out, z_out = velocity_out
    fallen, none = dt * gravity, type(dt)(0.0)
    first, last, _ = span
    for i in range(first, last):
        x_out[i], y_out[i] = x[i], y[i]
        z_out[i] = z[i] - (fallen if inverse_mass[i] > 0.0 else none)


@inner_kernel
def _keep(guess, wind, scratch, span):
    """Keep the guess and the wind's forces."""
    first, last, _ = span
    for axis in range(3):
        v, f, kept_v, kept_f = guess[axis], wind[axis], scratch.guess[axis], scratch.wind[axis]
        for i in range(first, last):
            kept_v[i], kept_f[i] = v[i], f[i]


@inner_kernel
def _move(position, velocity, dt, position_out, span):
    """Move the nodes by a velocity."""
    first, last, _ = span
    for axis in range(3):
        x, v, out = position[axis], velocity[axis], position_out[axis]
        for i in range(first, last):
            out[i] = x[i] + dt * v[i]


@inner_kernel
def _set_residual(velocity, velocity_out, force, mass, node_damping, dt, residual, span):
    """Set what the guess y leaves of M (v - y) + h f(x + h y, y) - h nu M y [N s]."""
    first, last, _ = span
    for axis in range(3):
        v, y, f, r = velocity[axis], velocity_out[axis], force[axis], residual[axis]
        for i in range(first, last):
            r[i] = mass[i] * (v[i] - y[i] - dt * node_damping * y[i]) + dt * f[i]


@inner_kernel
def _set_difference(a, b, difference, span):
    """Set the difference a - b of two fields."""
    first, last, _ = span
    for axis in range(3):
        u, v, d = a[axis], b[axis], difference[axis]
        for i in range(first, last):
            d[i] = u[i] - v[i]


@inner_kernel
def _set_all(field, value, span):
    """Set a field to one value."""
    first, last, _ = span
    for axis in range(3):
        f = field[axis]
        for i in range(first, last):
            f[i] = value


@inner_kernel
def _scale(field, factor, span):
    """Multiply a field by a factor."""
    first, last, _ = span
    for axis in range(3):
        f = field[axis]
        for i in range(first, last):
            f[i] *= factor


@inner_kernel
def _lose_energy(velocity, velocity_out, matrix, mass, weights, coefficients, work, residual,
                 product, dt, span):
    """
    See to it that a system that is not solved to the end gives no energy to the cloth.

    For y with A y = M v - h dE/dx - r, and E quadratic with the Hessian K, the sum of kinetic
    and elastic energy grows in the step to x + h y by

        - |y - v|^2_M / 2 - h^2 y^T K y / 2 - h y^T (C + G + nu M) y - r^T y.

    All but the last are losses. Where that might be more than the first makes up for, y is made as
    long as leaves r^T y = 0, the best that there is in its direction.
    """
    gained = -dot(residual, velocity_out, span)
    _set_difference(velocity_out, velocity, product, span)
    if gained > 0.5 * norm2(product, mass, span):
        multiply(matrix, mass, weights, coefficients, work, velocity_out, product, dt, span)
        _scale(velocity_out, type(dt)(1.0 - gained / dot(velocity_out, product, span)), span)


@inner_kernel
def _set_inner(velocity_out, scratch, inverse_mass, node_damping, dt, span):
    """Make scratch.product, velocities less the guess, the part that inner forces have in it."""
    first, last, _ = span
    for axis in range(3):
        y, f = velocity_out[axis], scratch.wind[axis]
        drag, change = scratch.residual[axis], scratch.product[axis]
        for i in range(first, last):
            change[i] += dt * node_damping * y[i] - inverse_mass[i] * (dt * f[i] - drag[i])


@inner_kernel
def _drag_on(field, scratch, work, coefficients, span):
    """Set scratch.residual to what the wind's drag takes from velocities, h G times a field."""
    _set_all(scratch.residual, 0.0, span)
    if coefficients.drag > 0.0:
        add_drag(scratch.matrix, field, work.faces, scratch.residual, span)


@inner_kernel
def _keep_momentum(position, velocity_out, body, scratch, work, coefficients, dt, span):
    """
    Take off the rigid motion that inner forces seem to have caused, as none can.

    Backward Euler takes them where the nodes will be, and so loses angular momentum: a turn at
    omega fades at the rate h omega^2. The guess has all of gravity; the wind is no inner force
    either, nor its drag on what the velocities differ by from the guess that it was taken at. The
    drag that the change itself meets is taken implicitly, as all drag is here.
    """
    nu, change = coefficients.node_damping, scratch.product
    total, center = mass_center(position, body.mass, body.freedom, span)
    moments = inertia(position, body.mass, center, span)
    _set_difference(velocity_out, scratch.guess, change, span)
    _drag_on(change, scratch, work, coefficients, span)
    _set_inner(velocity_out, scratch, body.inverse_mass, nu, dt, span)
    rigid = rigid_of(position, change, body, total, center, moments, span)
    _set_all(change, 0.0, span)
    add_rigid(position, body.inverse_mass, rigid, change, span)
    _drag_on(change, scratch, work, coefficients, span)
    inertial = norm2(change, body.mass, span)
    resisting = (1.0 + dt * nu) * inertial + dot(change, scratch.residual, span)
    if resisting > 0.0:
        add(velocity_out, type(dt)(-inertial / resisting), change, span)


@kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, scratch, freedom, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    matrix, residual, product = scratch.matrix, scratch.residual, scratch.product
    zero = type(dt)(0.0)
    none = (zero, zero, zero)
    blown = Coefficients(none, none, coefficients.spring_rest, none, zero, coefficients.drag,
                         coefficients.drag_rate, coefficients.law, coefficients.order,
                         coefficients.node_damping, coefficients.limits)
    body = Body(mass, inverse_mass, freedom)
    for _ in range(count):
        _guess(velocity, inverse_mass, coefficients.gravity, dt, velocity_out, span)
        _move(position, velocity_out, dt, position_out, span)
        # The wind's momentary force: that it weakens as the cloth yields is in the matrix.
        set_forces(position_out, velocity_out, wind, mass, weights, blown, work, zero, span)
        _keep(velocity_out, work.force, scratch, span)
        set_forces(position_out, velocity_out, wind, mass, weights, coefficients, work, zero, span)
        _set_residual(velocity, velocity_out, work.force, mass, coefficients.node_damping, dt,
                      residual, span)
        set_springs(position_out, weights, coefficients.spring_k, coefficients.spring_c,
                    coefficients.spring_rest, matrix, dt, span)
        if coefficients.drag > 0.0:
            set_faces(position_out, velocity_out, wind, weights, coefficients.drag,
                      coefficients.law, matrix, dt, span)
        solve(matrix, mass, inverse_mass, weights, coefficients, work, residual, scratch.direction,
              product, velocity_out, TOLERANCE, LIMIT, dt, span)
        _lose_energy(velocity, velocity_out, matrix, mass, weights, coefficients, work, residual,
                     product, dt, span)
        _keep_momentum(position, velocity_out, body, scratch, work, coefficients, dt, span)
        _move(position, velocity_out, dt, position_out, span)
        collide(position, position_out, velocity_out, coefficients.limits, work.contact, span)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class Implicit(Solver):
    """
    Backward Euler with one step of Newton's method, solved by conjugate gradients.

    First order. The velocity y at the step's end obeys M (y - v) = h f(x + h y, y) (Baraff and
    Witkin, Large Steps in Cloth Simulation, 1998); f is linearised about free fall, where springs
    that are pressed together are given no tension (Choi and Ko, Stable but Responsive Cloth, 2002;
    see matrix). The cloth linearised so loses energy in every step, also where the iterations
    end early. It pays for that with its motion: a wave of frequency omega fades at the rate
    h omega^2 / 2, so that long steps still the cloth, and short waves go first.

    Where forces balance its steps leave no error, however long; for motion there is no cloth that
    it is the cheapest for. An iteration costs what a step of symplectic does, and a frame takes
    about as many, since they grow with h omega as well: at 1e5 N/m and 61 x 41 nodes 2,300 in ten
    steps to 1/30 s, where symplectic takes 1,300 steps.
    """

    order = 1
    useful_step = 1.0 / 300.0
    take_steps = staticmethod(_take_steps)

    def __init__(self, model):
        super().__init__(model)
        self._scratch = (Scratch.of(model.mesh), None)

    def advance(self, state, *arguments):
        """Take steps as every Solver does; which rigid motions are free follows from the pins."""
        self._scratch = (self._scratch[0], freedom_of(state))
        return super().advance(state, *arguments)

    @staticmethod
    def largest_step(omega, gamma, air):
        """Return infinity: no step is unstable."""
        del omega, gamma, air
        return math.inf
