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
from flag_sim.cloth.material import Air
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Field
from flag_sim.cloth.solvers.elementwise import set_weighted
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait


@wide_kernel
def _drift(nodes, acceleration, nodes_out, dt, keep, band):
    """
    Move the nodes by x + h v + h^2/2 a; write the predicted velocity v + h a.

    Both halves of the nodes' damping are in the prediction: forces taken without the second would
    be first order where they depend on the velocity.
    """
    half = type(dt)(0.5) * dt
    first, last, _ = band
    for axis in range(3):
        x, v, a = nodes.position[axis], nodes.velocity[axis], acceleration[axis]
        x_out, v_out = nodes_out.position[axis], nodes_out.velocity[axis]
        for i in range(first, last):
            u = v[i] * keep
            x_out[i] = x[i] + dt * (u + half * a[i])
            v_out[i] = (u + dt * a[i]) * keep


@wide_kernel
def _kick(velocity, force, inverse_mass, acceleration, dt, keep, band):
    """Correct the predicted velocity to v + h/2 (a + a'), and keep a' for the next step."""
    half = type(dt)(0.5) * dt
    first, last, _ = band
    for axis in range(3):
        v, f, a = velocity[axis], force[axis], acceleration[axis]
        for i in range(first, last):
            after = f[i] * inverse_mass[i]
            v[i] += half * (after - a[i]) * keep
            a[i] = after


@shared_kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, acceleration, steps, band):
    """Take steps as Solver.take_steps says; acceleration [m/s2] goes from each to the next."""
    dt = steps.dt
    # Half of the node damping, exact: exp(-h nu / 2).
    keep = math.exp(type(dt)(-0.5) * dt * coefficients.node_damping)
    # The acceleration that the first step begins with.
    set_forces(nodes, sheet, coefficients, work, dt, band)
    set_weighted(sheet.inverse_mass, work.force, acceleration, band)
    for _ in range(steps.count):
        # Positions at the step's end, and a first guess of the velocities.
        _drift(nodes, acceleration, nodes_out, dt, keep, band)
        # The pole, and the attachment to the hoist.
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)
        wait(work.barrier)
        # All forces there, and the velocities by the mean of both accelerations.
        set_forces(nodes_out, sheet, coefficients, work, dt, band)
        _kick(nodes_out.velocity, work.force, sheet.inverse_mass, acceleration, dt, keep, band)
        nodes, nodes_out = nodes_out, nodes


class Verlet(Solver):
    """
    Second order, with damping too, for one evaluation of the forces a step.

    Forces at the step's end are taken at the velocity v + h a, not at the one before (which would
    be first order). The nodes' own damping is exact, half of it before and half after the step
    (Strang). Without damping it is symplectic.
    """

    order = 2
    drag_order = 2
    force_time = 0.5
    take_steps = staticmethod(_take_steps)
    is_parallel = True

    @classmethod
    def new_scratch(cls, model: Model) -> Field:
        """Return room for the nodes' acceleration [m/s2]."""
        return tuple(model.mesh.fields(3))

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        With z = h^2 omega^2 and g = h gamma, x, h v and h^2 a obey a matrix of characteristic
        polynomial l^3 - (2 - z - 3/2 g) l^2 + (1 - 2 g) l + g/2, whose roots are within the unit
        circle (Jury) where z + 4 g <= 4. The drag of the air adds its own rate to g.
        """
        room = 1.0 - air.greatest_rate(cls.drag_order)
        rate = gamma + math.sqrt(gamma**2 + room * omega**2)
        return 2.0 * room / rate if rate > 0.0 else math.inf
