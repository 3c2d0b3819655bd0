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

"""Symplectic (semi-implicit) Euler: velocity first, then position by the new velocity."""
import math

from flag_sim.cloth.barrier import wait
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.holds import hold_outside
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.kernels import shared_kernel, wide_kernel


@wide_kernel
def _update(position, velocity, force, inverse_mass, position_out, velocity_out, dt, keep, span):
    """
    Move the nodes; pins and ghosts have no inverse mass and stay.

    keep: what node damping leaves of a velocity in a step, taken implicitly: 1 / (1 + dt nu).
    """
    x, y, z = position
    vx, vy, vz = velocity
    fx, fy, fz = force
    x_out, y_out, z_out = position_out
    vx_out, vy_out, vz_out = velocity_out
    first, last, _ = span
    for i in range(first, last):
        t_m = dt * inverse_mass[i]            # a = t F / m: 1.7, 1.8
        ux = (vx[i] + t_m * fx[i]) * keep     # v = v0 + a: 1.9
        uy = (vy[i] + t_m * fy[i]) * keep
        uz = (vz[i] + t_m * fz[i]) * keep
        vx_out[i], vy_out[i], vz_out[i] = ux, uy, uz
        x_out[i] = x[i] + dt * ux             # x = x0 + v: 1.10, with v in metres per second
        y_out[i] = y[i] + dt * uy
        z_out[i] = z[i] + dt * uz


@shared_kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    one = type(dt)(1.0)
    keep = one / (one + dt * coefficients.node_damping)
    for _ in range(count):
        set_forces(position, velocity, wind, mass, weights, coefficients, work, dt, span)
        _update(position, velocity, work.force, inverse_mass, position_out, velocity_out, dt, keep,
                span)
        hold_outside(position_out, velocity_out, inverse_mass, coefficients.pole, span)
        wait(work.barrier)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class Symplectic(Solver):
    """
    The method that the source text steps with (1.7 to 1.11), its units put right.

    First order; conditionally stable: see largest_step. Springs and bending are explicit, the drag
    of the wind and the nodes' own damping implicit. Without damping it keeps the energy within a
    bound for ever, since it is symplectic.
    """

    order = 1

    take_steps = staticmethod(_take_steps)
    is_shared = True

    @classmethod
    def largest_step(cls, omega, gamma, air):
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        A mode obeys v' = v - h (omega^2 x + gamma v), x' = x + h v'. Its amplification matrix has
        determinant 1 - h gamma and trace 2 - h gamma - h^2 omega^2: both its eigenvalues are
        within the unit circle (Jury) where h^2 omega^2 + 2 h gamma <= 4. The drag of the air adds
        its own rate to h gamma, and keeps twice its greatest of these 4.
        """
        room = 4.0 - 2.0 * air.greatest_rate(cls.order)
        rate = gamma + math.sqrt(gamma**2 + room * omega**2)
        return room / rate if rate > 0.0 else math.inf
