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

"""The source text's own scheme: equations 1.5 to 1.10 exactly as published."""
from flag_sim.cloth.collision import collide
from flag_sim.cloth.contact import limits_in_steps
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.material import Air, VACUUM
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Field, Nodes
from flag_sim.cloth.solvers.elementwise import copy, scale
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.solvers.symplectic import Symplectic
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait


@wide_kernel
def _update(nodes, force, inverse_mass, nodes_out, dt, mu, band):
    """Move the nodes; velocities are in metres per step."""
    first, last, _ = band
    for axis in range(3):
        x, v, f = nodes.position[axis], nodes.velocity[axis], force[axis]
        x_out, v_out = nodes_out.position[axis], nodes_out.velocity[axis]
        for i in range(first, last):
            resultant = f[i] - mu * f[i]               # friction against it: eqs. 1.5, 1.6
            a = dt * resultant * inverse_mass[i]       # eqs. 1.7, 1.8
            moved = v[i] + a * dt                      # eq. 1.9
            v_out[i] = moved
            x_out[i] = x[i] + moved                    # eq. 1.10


@shared_kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, moves, steps, band):
    """Take steps as Solver.take_steps says; moves: two fields of velocities by the step."""
    dt = steps.dt
    one, now = type(dt)(1.0), type(dt)(0.0)
    mu = min(coefficients.node_damping, one)
    limits = limits_in_steps(coefficients.limits)
    # From metres per second to metres per step.
    start, end = Nodes(nodes.position, moves[0]), Nodes(nodes_out.position, moves[1])
    copy(nodes.velocity, start.velocity, band)
    scale(start.velocity, dt, band)
    wait(work.barrier)
    for _ in range(steps.count):
        # All forces at the step's beginning (eqs. 1.1 to 1.4).
        set_forces(start, sheet, coefficients, work, now, band)
        # The motion that follows from them (eqs. 1.5 to 1.10).
        _update(start, work.force, sheet.inverse_mass, end, dt, mu, band)
        # The pole, and the attachment to the hoist.
        collide(start, end, limits, work.contact, band)
        wait(work.barrier)
        start, end = end, start
        nodes, nodes_out = nodes_out, nodes
    # And back, where the result is.
    copy(start.velocity, nodes.velocity, band)
    scale(nodes.velocity, one / dt, band)


class Seed(Solver):
    """
    Symplectic Euler with the velocity in metres per step: the baseline of all others.

    First order in the step, towards a motion without friction: forces see metres per step where
    metres per second are meant, so that dashpots and the wind's relative velocity are too weak
    by the factor dt. Friction 1.5 is -mu times the resultant, which only makes nodes heavier; mu
    is the number of node_damping, at most 1, where nothing moves any more.
    Between frames velocities are kept in metres per second, so that methods can be changed. Drag
    is explicit: strong wind on light cloth diverges, and the frame is refused.
    """

    order = 1
    drag_order = 1
    take_steps = staticmethod(_take_steps)
    is_parallel = True

    @classmethod
    def new_scratch(cls, model: Model) -> tuple[Field, Field]:
        """Return room for the velocities of two steps, in metres per step."""
        fields = tuple(model.mesh.fields(6))
        return fields[:3], fields[3:]

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """Return the symplectic method's; its dashpots are stronger, for steps below a second."""
        del air
        return Symplectic.largest_step(omega, gamma, VACUUM)

    @classmethod
    def stable_step(cls, omega: float, gamma: float, air: Air) -> float:
        """Return 0 in wind: cloth that flees it by metres per step hardly weakens its force."""
        return 0.0 if air.drag > 0.0 else cls.largest_step(omega, gamma, air)
