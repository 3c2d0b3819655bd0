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

"""The classical Runge-Kutta method of fourth order."""
import math

from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait

RADIUS = 2.6
"""The half disc of this radius left of the origin lies in the method's region of stability."""


@wide_kernel
def _begin(position, velocity, stage_x, stage_v, position_out, velocity_out, keep, span):
    """
    Write where the first stage begins, and what the stages' sums begin with.

    The way is summed alone, and added to the positions once: each sum with them is rounded as they
    are.
    """
    first, last, _ = span
    for axis in range(3):
        x, v, xs, vs = position[axis], velocity[axis], stage_x[axis], stage_v[axis]
        x_out, v_out = position_out[axis], velocity_out[axis]
        for i in range(first, last):
            xs[i], x_out[i] = x[i], 0.0
            vs[i] = keep * v[i]
            v_out[i] = keep * v[i]


@wide_kernel
def _stage(position, velocity, stage_x, stage_v, force, inverse_mass, position_out, velocity_out,
           weight, ahead, keep, span):
    """Add a stage's rates, times weight [s], to the result; go ahead [s] by them to the next."""
    first, last, _ = span
    for axis in range(3):
        x, v, f = position[axis], velocity[axis], force[axis]
        xs, vs = stage_x[axis], stage_v[axis]
        x_out, v_out = position_out[axis], velocity_out[axis]
        for i in range(first, last):
            a = f[i] * inverse_mass[i]
            x_out[i] += weight * vs[i]
            v_out[i] += weight * a
            xs[i] = x[i] + ahead * vs[i]
            vs[i] = keep * v[i] + ahead * a


@wide_kernel
def _end(position, position_out, velocity_out, keep, span):
    """Add the way to the positions, and take the second half of the nodes' damping."""
    first, last, _ = span
    for axis in range(3):
        x, x_out, v_out = position[axis], position_out[axis], velocity_out[axis]
        for i in range(first, last):
            x_out[i] = x[i] + x_out[i]
            v_out[i] *= keep


@shared_kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, scratch, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    number = type(dt)
    keep = math.exp(number(-0.5) * dt * coefficients.node_damping)
    x, v = (scratch[0], scratch[1], scratch[2]), (scratch[3], scratch[4], scratch[5])
    for _ in range(count):
        _begin(position, velocity, x, v, position_out, velocity_out, keep, span)
        for weight, ahead in ((1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)):
            wait(work.barrier)
            set_forces(x, v, wind, mass, weights, coefficients, work, dt, span)
            wait(work.barrier)  # before neighbours move, whose positions the sums are taken with
            _stage(position, velocity, x, v, work.force, inverse_mass, position_out, velocity_out,
                   number(weight / 6.0) * dt, number(ahead) * dt, keep, span)
        _end(position, position_out, velocity_out, keep, span)
        collide(position, position_out, velocity_out, coefficients.limits, work.contact, span)
        wait(work.barrier)  # before positions that neighbours look at are written over
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class RK4(Solver):
    """
    Fourth order, for four evaluations of the forces a step.

    The nodes' own damping is exact, half of it before and half after the step (Strang): where it
    is not zero, the order is two in it. Loses a little energy in the shortest waves, gains none.
    """

    order = 4
    scratch = 6
    take_steps = staticmethod(_take_steps)
    is_shared = True

    @classmethod
    def largest_step(cls, omega, gamma, air):
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        A mode's rates l obey l^2 + g l + z = 0, with z up to omega^2 and g up to gamma and the
        drag's rate; whichever they are, |l| is at most the greater of sqrt(z) and g. Within the
        half disc of radius RADIUS all is stable; the drag's rate is given in steps.
        """
        by_waves = RADIUS / omega if omega > 0.0 else math.inf
        by_damping = (RADIUS - air.greatest_rate(cls.order)) / gamma if gamma > 0.0 else math.inf
        return min(by_waves, by_damping)
