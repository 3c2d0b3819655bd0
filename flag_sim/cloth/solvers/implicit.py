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

"""Backward Euler, linearised: large steps for stiff cloth, each a system of equations."""
import math

from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.solvers.conjugate import dot, norm2, solve
from flag_sim.cloth.solvers.matrix import (FIELDS, Matrix, multiply, set_faces, set_springs)
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.kernels import kernel

TOLERANCE = 1e-3
LIMIT = 100


@kernel
def _go(position, velocity, dt, position_out, span):
    """Move the nodes by their velocity."""
    first, last, _ = span
    for axis in range(3):
        x, v, out = position[axis], velocity[axis], position_out[axis]
        for i in range(first, last):
            out[i] = x[i] + dt * v[i]


@kernel
def _guess(velocity, inverse_mass, gravity, dt, velocity_out, span):
    """Guess that the nodes fall freely."""
    x, y, z = velocity
    x_out, y_out, z_out = velocity_out
    first, last, _ = span
    for i in range(first, last):
        x_out[i], y_out[i] = x[i], y[i]
        z_out[i] = z[i] - (dt * gravity if inverse_mass[i] > 0.0 else 0.0)


@kernel
def _set_residual(velocity, velocity_out, force, mass, node_damping, dt, residual, span):
    """Set what the guess leaves of M (v - y) + h f(x + h y, y) - h nu M y [N s]."""
    first, last, _ = span
    for axis in range(3):
        v, y, f, r = velocity[axis], velocity_out[axis], force[axis], residual[axis]
        for i in range(first, last):
            r[i] = mass[i] * (v[i] - y[i] - dt * node_damping * y[i]) + dt * f[i]


@kernel(fastmath={'contract', 'reassoc'})
def _kick2(velocity, velocity_out, mass, span):
    """Return the sum over nodes of mass times the square of the change of velocity [J]."""
    first, last, _ = span
    total = 0.0
    for axis in range(3):
        v, u = velocity[axis], velocity_out[axis]
        for i in range(first, last):
            total += mass[i] * (u[i] - v[i])**2
    return total


@kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, matrix, residual, direction, product, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    k, c, rest = coefficients.spring_k, coefficients.spring_c, coefficients.spring_rest
    total = 0
    for _ in range(count):
        _guess(velocity, inverse_mass, coefficients.gravity, dt, velocity_out, span)
        _go(position, velocity_out, dt, position_out, span)
        set_forces(position_out, velocity_out, wind, mass, weights, coefficients, work, 0.0, span)
        _set_residual(velocity, velocity_out, work.force, mass, coefficients.node_damping, dt,
                      residual, span)
        set_springs(position_out, weights, k, c, rest, matrix, dt, span)
        if coefficients.drag > 0.0:
            set_faces(position_out, velocity_out, wind, weights, coefficients.drag,
                      coefficients.law, matrix, dt, span)
        total += solve(matrix, mass, inverse_mass, weights, coefficients, work, residual,
                       direction, product, velocity_out, TOLERANCE, LIMIT, dt, span)
        gained = -dot(residual, velocity_out, span)
        if gained > 0.5 * _kick2(velocity, velocity_out, mass, span):
            multiply(matrix, mass, weights, coefficients, work, velocity_out, product, dt, span)
            part = 1.0 - gained / dot(velocity_out, product, span)
            for axis in range(3):
                velocity_out[axis][:] *= part
        _go(position, velocity_out, dt, position_out, span)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity
    return total


class Implicit(Solver):
    """TODO."""

    order = 1
    useful_step = 1.0 / 300.0
    take_steps = staticmethod(_take_steps)

    def __init__(self, model):
        super().__init__(model)
        fields = tuple(model.mesh.fields(FIELDS + 9))
        self._scratch = (Matrix.of(fields), fields[-9:-6], fields[-6:-3], fields[-3:])

    @staticmethod
    def largest_step(omega, gamma, drag=True):
        """Return infinity: no step is unstable."""
        del omega, gamma, drag
        return math.inf
