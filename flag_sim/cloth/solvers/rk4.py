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
from flag_sim.cloth.material import Air
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Nodes
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait

STABILITY_RADIUS = 2.6
"""The half disc of this radius left of the origin lies in the method's region of stability."""

STAGES = ((1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0))
"""Of each: six times its weight in the step, and how far ahead of the step's start the next is."""


@wide_kernel
def _begin(nodes, stage, nodes_out, keep, band):
    """
    Write where the first stage begins, and what the stages' sums begin with.

    The way is summed alone, and added to the positions once: each sum with them is rounded as they
    are.
    """
    first, last, _ = band
    for axis in range(3):
        x, v, xs, vs = (nodes.position[axis], nodes.velocity[axis], stage.position[axis],
                        stage.velocity[axis])
        x_out, v_out = nodes_out.position[axis], nodes_out.velocity[axis]
        for i in range(first, last):
            xs[i], x_out[i] = x[i], 0.0
            vs[i] = keep * v[i]
            v_out[i] = keep * v[i]


@wide_kernel
def _stage(nodes, stage, force, inverse_mass, nodes_out, times, band):
    """
    Add a stage's rates, times its weight, to the result; go ahead by them to the next stage.

    times: weight [s], ahead [s], and what half of the node damping leaves of a velocity.
    """
    weight, ahead, keep = times
    first, last, _ = band
    for axis in range(3):
        x, v, f = nodes.position[axis], nodes.velocity[axis], force[axis]
        xs, vs = stage.position[axis], stage.velocity[axis]
        x_out, v_out = nodes_out.position[axis], nodes_out.velocity[axis]
        for i in range(first, last):
            a = f[i] * inverse_mass[i]
            x_out[i] += weight * vs[i]
            v_out[i] += weight * a
            xs[i] = x[i] + ahead * vs[i]
            vs[i] = keep * v[i] + ahead * a


@wide_kernel
def _end(position, nodes_out, keep, band):
    """Add the way to the positions, and take the second half of the nodes' damping."""
    first, last, _ = band
    for axis in range(3):
        x, x_out, v_out = position[axis], nodes_out.position[axis], nodes_out.velocity[axis]
        for i in range(first, last):
            x_out[i] = x[i] + x_out[i]
            v_out[i] *= keep


@shared_kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, stage, steps, band):
    """Take steps as Solver.take_steps says; stage: the nodes that forces are taken at."""
    dt = steps.dt
    number = type(dt)
    # Half of the node damping, exact: exp(-h nu / 2).
    keep = math.exp(number(-0.5) * dt * coefficients.node_damping)
    for _ in range(steps.count):
        _begin(nodes, stage, nodes_out, keep, band)
        for weight, ahead in STAGES:
            wait(work.barrier)
            # All forces at the stage, and its part in the step.
            set_forces(stage, sheet, coefficients, work, dt, band)
            wait(work.barrier)  # before neighbours move, whose positions the sums are taken with
            _stage(nodes, stage, work.force, sheet.inverse_mass, nodes_out,
                   (number(weight / 6.0) * dt, number(ahead) * dt, keep), band)
        _end(nodes.position, nodes_out, keep, band)
        # The pole, and the attachment to the hoist.
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)
        wait(work.barrier)  # before positions that neighbours look at are written over
        nodes, nodes_out = nodes_out, nodes


class RK4(Solver):
    """
    Fourth order, for four evaluations of the forces a step.

    The nodes' own damping is exact, half of it before and half after the step (Strang): where it
    is not zero, the order is two in it. Loses a little energy in the shortest waves, gains none.
    """

    order = 4
    drag_order = 4
    force_time = 0.5
    take_steps = staticmethod(_take_steps)
    is_parallel = True

    @classmethod
    def new_scratch(cls, model: Model) -> Nodes:
        """Return room for the nodes of a stage."""
        fields = tuple(model.mesh.fields(6))
        return Nodes(fields[:3], fields[3:])

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        A mode's rates l obey l^2 + g l + z = 0, with z up to omega^2 and g up to gamma and the
        drag's rate; whichever they are, |l| is at most the greater of sqrt(z) and g. Within the
        half disc of radius STABILITY_RADIUS all is stable; the drag's rate is given in steps.
        """
        by_waves = STABILITY_RADIUS / omega if omega > 0.0 else math.inf
        room = STABILITY_RADIUS - air.greatest_rate(cls.drag_order)
        by_damping = room / gamma if gamma > 0.0 else math.inf
        return min(by_waves, by_damping)
