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

"""Explicit Euler: position and velocity both by the rates at the step's beginning."""
import math

from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.material import Air
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait


@wide_kernel
def _update(nodes, force, inverse_mass, nodes_out, dt, keep, band):
    """Move the nodes; keep: what the nodes' damping leaves of a velocity in a step."""
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    fx, fy, fz = force
    x_out, y_out, z_out = nodes_out.position
    vx_out, vy_out, vz_out = nodes_out.velocity
    first, last, _ = band
    for i in range(first, last):
        t_m = dt * inverse_mass[i]
        x_out[i] = x[i] + dt * vx[i]
        y_out[i] = y[i] + dt * vy[i]
        z_out[i] = z[i] + dt * vz[i]
        vx_out[i] = (vx[i] + t_m * fx[i]) * keep
        vy_out[i] = (vy[i] + t_m * fy[i]) * keep
        vz_out[i] = (vz[i] + t_m * fz[i]) * keep


@shared_kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, scratch, steps, band):
    """Take steps as Solver.take_steps says."""
    dt = steps.dt
    one = type(dt)(1.0)
    # Node damping, taken implicitly: v' = v - h nu v'.
    keep = one / (one + dt * coefficients.node_damping)
    for _ in range(steps.count):
        # All forces at the step's beginning; positions and velocities by them.
        set_forces(nodes, sheet, coefficients, work, dt, band)
        _update(nodes, work.force, sheet.inverse_mass, nodes_out, dt, keep, band)
        # The pole, and the attachment to the hoist.
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)
        wait(work.barrier)
        nodes, nodes_out = nodes_out, nodes


class Euler(Solver):
    """
    The method that textbooks begin with, kept to show why the others exist.

    First order. Unstable by nature: it feeds energy into every mode that nothing damps, such as
    waves across a taut sheet, at the rate dt omega^2 / 2. Where that ends badly a frame is
    refused.
    """

    order = 1
    drag_order = 1
    take_steps = staticmethod(_take_steps)
    is_parallel = True

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """
        Return the largest step [s] that is stable for stretch, which the dashpots damp.

        The amplification matrix has determinant 1 - h gamma + h^2 omega^2, at most 1 where
        h <= gamma / omega^2, which is the same for all modes whose dashpots go with their springs.
        Overdamped modes need h gamma <= 2, the rate of the air's drag included: half is left to
        that, which is at most 1. Without dashpots no step is stable; half of what the symplectic
        method takes then only delays the end.
        """
        del air
        if gamma == 0.0:
            return 1.0 / omega if omega > 0.0 else math.inf
        return min(gamma / omega**2, 1.0 / gamma) if omega > 0.0 else 1.0 / gamma

    @classmethod
    def stable_step(cls, omega: float, gamma: float, air: Air) -> float:
        """Return 0: no step is stable for waves across a taut sheet, which nothing damps."""
        del omega, gamma, air
        return 0.0
