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

"""The source text's own scheme, equations 1.5 to 1.10 to the letter."""
from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.solvers.symplectic import Symplectic
from flag_sim.jit.kernels import kernel, shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait


@kernel
def _scale(velocity, factor, velocity_out, span):
    """Write velocity times a factor."""
    first, last, _ = span
    for axis in range(3):
        v, out = velocity[axis], velocity_out[axis]
        for i in range(first, last):
            out[i] = factor * v[i]


@wide_kernel
def _update(position, velocity, force, inverse_mass, position_out, velocity_out, dt, mu, span):
    """Move the nodes; velocities are in metres per step."""
    first, last, _ = span
    for axis in range(3):
        x, v, f = position[axis], velocity[axis], force[axis]
        x_out, v_out = position_out[axis], velocity_out[axis]
        for i in range(first, last):
            resultant = f[i] - mu * f[i]               # friction against it: 1.5, 1.6
            a = dt * resultant * inverse_mass[i]       # 1.7, 1.8
            moved = v[i] + a * dt                      # 1.9
            v_out[i] = moved
            x_out[i] = x[i] + moved                    # 1.10


@shared_kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, scratch, dt, count, span):
    """Take count steps, each from one pair of arrays to the other; velocities go by the step."""
    one, now = type(dt)(1.0), type(dt)(0.0)
    mu = min(coefficients.node_damping, one)
    v, v_out = (scratch[0], scratch[1], scratch[2]), (scratch[3], scratch[4], scratch[5])
    _scale(velocity, dt, v, span)
    wait(work.barrier)
    for _ in range(count):
        set_forces(position, v, wind, mass, weights, coefficients, work, now, span)
        _update(position, v, work.force, inverse_mass, position_out, v_out, dt, mu, span)
        collide(position, position_out, v_out, coefficients.limits, work.contact, span)
        wait(work.barrier)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity
        v, v_out = v_out, v
    _scale(v, one / dt, velocity, span)


class Seed(Solver):
    """
    Symplectic Euler with the velocity in metres per step: the baseline of all others.

    First order in the step, towards a motion without friction: forces see metres per step where
    metres per second are meant, so that dashpots and the wind's relative velocity are too weak
    by the factor dt. Friction 1.5 is -mu times the resultant, which only makes nodes heavier; mu
    is the number of node_damping, at most 1, where nothing moves any more.
    Between frames velocities are kept in metres per second, so that methods can be changed. Drag
    is explicit: strong wind on light cloth diverges, and the cloth is then held.
    """

    order = 1
    scratch = 6
    take_steps = staticmethod(_take_steps)
    is_shared = True

    @staticmethod
    def largest_step(omega, gamma, air):
        """Return the symplectic method's; its dashpots are stronger, for steps below a second."""
        del air
        return Symplectic.largest_step(omega, gamma, VACUUM)

    @classmethod
    def stable_step(cls, omega, gamma, air):
        """Return 0 in the wind: cloth that flees it by metres per step hardly weakens its push."""
        return 0.0 if air.drag > 0.0 else cls.largest_step(omega, gamma, air)
