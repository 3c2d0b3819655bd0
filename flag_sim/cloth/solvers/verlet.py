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

"""Velocity Verlet, its forces taken at a predicted velocity."""
import math

from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait


@wide_kernel
def _accelerate(force, inverse_mass, acceleration, span):
    """Set the acceleration [m/s2] that the next step begins with."""
    first, last, _ = span
    for axis in range(3):
        f, a = force[axis], acceleration[axis]
        for i in range(first, last):
            a[i] = f[i] * inverse_mass[i]


@wide_kernel
def _drift(position, velocity, acceleration, position_out, velocity_out, dt, keep, span):
    """
    Move the nodes by x + h v + h^2/2 a; write the predicted velocity v + h a.

    Both halves of the nodes' damping are in the prediction: forces taken without the second would
    be first order where they depend on the velocity.
    """
    half = type(dt)(0.5) * dt
    first, last, _ = span
    for axis in range(3):
        x, v, a = position[axis], velocity[axis], acceleration[axis]
        x_out, v_out = position_out[axis], velocity_out[axis]
        for i in range(first, last):
            u = v[i] * keep
            x_out[i] = x[i] + dt * (u + half * a[i])
            v_out[i] = (u + dt * a[i]) * keep


@wide_kernel
def _kick(velocity, force, inverse_mass, acceleration, dt, keep, span):
    """Correct the predicted velocity to v + h/2 (a + a'), and keep a' for the next step."""
    half = type(dt)(0.5) * dt
    first, last, _ = span
    for axis in range(3):
        v, f, a = velocity[axis], force[axis], acceleration[axis]
        for i in range(first, last):
            after = f[i] * inverse_mass[i]
            v[i] += half * (after - a[i]) * keep
            a[i] = after


@shared_kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, acceleration, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    keep = math.exp(type(dt)(-0.5) * dt * coefficients.node_damping)
    set_forces(position, velocity, wind, mass, weights, coefficients, work, dt, span)
    _accelerate(work.force, inverse_mass, acceleration, span)
    for _ in range(count):
        _drift(position, velocity, acceleration, position_out, velocity_out, dt, keep, span)
        collide(position, position_out, velocity_out, coefficients.limits, work.contact, span)
        wait(work.barrier)
        set_forces(position_out, velocity_out, wind, mass, weights, coefficients, work, dt, span)
        _kick(velocity_out, work.force, inverse_mass, acceleration, dt, keep, span)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class Verlet(Solver):
    """
    Second order, with damping too, for one evaluation of the forces a step.

    Forces at the step's end are taken at the velocity v + h a, not at the one before (which would
    be first order). The nodes' own damping is exact, half of it before and half after the step
    (Strang). Without damping it is symplectic.
    """

    order = 2
    scratch = 3
    take_steps = staticmethod(_take_steps)
    is_shared = True

    @classmethod
    def largest_step(cls, omega, gamma, air):
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        With z = h^2 omega^2 and g = h gamma, x, h v and h^2 a obey a matrix of characteristic
        polynomial l^3 - (2 - z - 3/2 g) l^2 + (1 - 2 g) l + g/2, whose roots are within the unit
        circle (Jury) where z + 4 g <= 4. The drag of the air adds its own rate to g.
        """
        room = 1.0 - air.greatest_rate(cls.order)
        rate = gamma + math.sqrt(gamma**2 + room * omega**2)
        return 2.0 * room / rate if rate > 0.0 else math.inf
