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

"""Extended position-based dynamics in small steps: constraints are met one after the other."""
import math

from flag_sim.cloth.forces import Coefficients, set_forces
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.kernels import kernel, wide_kernel
import numpy as np

ONE = np.uint64(1)
TINY = 1e-30


@wide_kernel
def _predict(position, velocity, force, inverse_mass, position_out, dt, keep, span):
    """
    Move the nodes by the forces from outside alone.

    keep, what the nodes' damping leaves of a velocity, must not weaken a force that the springs,
    met afterwards, will balance: the cloth at rest would seem lighter.
    """
    first, last, _ = span
    for axis in range(3):
        x, v, f, x_out = position[axis], velocity[axis], force[axis], position_out[axis]
        for i in range(first, last):
            x_out[i] = x[i] + dt * (keep * v[i] + dt * f[i] * inverse_mass[i])


@kernel
def _meet_spring(before, position, inverse_mass, i, j, rest, stiff, damp):
    """
    Move the ends i and j of a spring as its stiffness and its dashpot pull within the step.

    stiff, damp: h^2 k and h c [kg]. The multiplier of Macklin et al. 2016 (26), with compliance
    1 / k and times k h^2, so that a spring of stiffness zero needs no infinite compliance.
    """
    w = inverse_mass[i] + inverse_mass[j]
    if w * (stiff + damp) == 0.0:
        return
    number = type(stiff)
    x, y, z = position
    bx, by, bz = before
    dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    scale = number(1.0) / max(length, number(TINY))
    nx, ny, nz = dx * scale, dy * scale, dz * scale
    grown = nx * (dx - bx[j] + bx[i]) + ny * (dy - by[j] + by[i]) + nz * (dz - bz[j] + bz[i])
    pull = (stiff * (length - rest) + damp * grown) / ((stiff + damp) * w + number(1.0))
    at_i, at_j = pull * inverse_mass[i], pull * inverse_mass[j]
    x[i] += at_i * nx
    y[i] += at_i * ny
    z[i] += at_i * nz
    x[j] -= at_j * nx
    y[j] -= at_j * ny
    z[j] -= at_j * nz


@kernel
def _meet_springs(before, position, inverse_mass, weights, spring_k, spring_c, spring_rest, dt,
                  span):
    """Meet the springs that begin at each node, node after node."""
    stiff_a, stiff_d, stiff_x = dt * dt * spring_k[0], dt * dt * spring_k[1], dt * dt * spring_k[2]
    damp_a, damp_d, damp_x = dt * spring_c[0], dt * spring_c[1], dt * spring_c[2]
    first, last, stride = span
    for i in range(first, last):
        e, s, d = i + ONE, i + stride, i + stride + ONE
        share = weights.across[i]
        _meet_spring(before, position, inverse_mass, i, e, spring_rest[0], share * stiff_a,
                     share * damp_a)
        share = weights.down[i]
        _meet_spring(before, position, inverse_mass, i, s, spring_rest[1], share * stiff_d,
                     share * damp_d)
        share = weights.cell[i]
        _meet_spring(before, position, inverse_mass, e, s, spring_rest[2], share * stiff_x,
                     share * damp_x)
        _meet_spring(before, position, inverse_mass, i, d, spring_rest[2], share * stiff_x,
                     share * damp_x)


@kernel
def _meet_bending(position, inverse_mass, weights, bend, dt, span):
    """Meet the second differences of each node, which are linear in the positions: exactly."""
    across, down, twist = dt * dt * bend[0], dt * dt * bend[1], dt * dt * bend[2]
    one, two, four = type(dt)(1.0), type(dt)(2.0), type(dt)(4.0)
    w = inverse_mass
    first, last, stride = span
    for i in range(first, last):
        e, s, d = i + ONE, i + stride, i + stride + ONE
        for b, ahead, back in ((across * weights.bend_across[i], e, i - ONE),
                               (down * weights.bend_down[i], s, i - stride)):
            if b > 0.0:
                part = b / (b * (w[ahead] + four * w[i] + w[back]) + one)
                for axis in range(3):
                    x = position[axis]
                    pull = part * ((x[ahead] - x[i]) - (x[i] - x[back]))
                    x[ahead] -= w[ahead] * pull
                    x[i] += two * w[i] * pull
                    x[back] -= w[back] * pull
        b = twist * weights.cell[i]
        if b > 0.0:
            part = b / (b * (w[i] + w[e] + w[s] + w[d]) + one)
            for axis in range(3):
                x = position[axis]
                pull = part * ((x[i] - x[e]) - (x[s] - x[d]))
                x[i] -= w[i] * pull
                x[e] += w[e] * pull
                x[s] += w[s] * pull
                x[d] -= w[d] * pull


@wide_kernel
def _set_velocity(before, position, velocity, dt, span):
    """Set velocities to what the step has moved the nodes by."""
    first, last, _ = span
    for axis in range(3):
        x0, x, v = before[axis], position[axis], velocity[axis]
        for i in range(first, last):
            v[i] = (x[i] - x0[i]) / dt


@kernel
def _take_steps(position, velocity, position_out, velocity_out, wind, mass, inverse_mass, weights,
                coefficients, work, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    one = type(dt)(1.0)
    keep = one / (one + dt * coefficients.node_damping)
    k, c, rest = coefficients.spring_k, coefficients.spring_c, coefficients.spring_rest
    zero = type(dt)(0.0)
    none = (zero, zero, zero)
    outside = Coefficients(none, none, rest, none, coefficients.gravity, coefficients.drag,
                           coefficients.drag_rate, coefficients.law, coefficients.order,
                           coefficients.node_damping)
    for _ in range(count):
        set_forces(position, velocity, wind, mass, weights, outside, work, dt, span)
        _predict(position, velocity, work.force, inverse_mass, position_out, dt, keep, span)
        _meet_springs(position, position_out, inverse_mass, weights, k, c, rest, dt, span)
        if max(coefficients.bend) > 0.0:
            _meet_bending(position_out, inverse_mass, weights, coefficients.bend, dt, span)
        _set_velocity(position, position_out, velocity_out, dt, span)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class XPBD(Solver):
    """
    One sweep over all springs and curvatures in each of many small steps.

    First order. Stable in steps of any length (Macklin, Mueller, Chentanez, XPBD, 2016; Macklin et
    al., Small Steps in Physics Simulation, 2019), which long steps pay for with a cloth that is
    limper than its material and loses energy. The wind's drag is taken implicitly.
    """

    order = 1
    useful_step = 1.0 / 600.0
    take_steps = staticmethod(_take_steps)

    @staticmethod
    def largest_step(omega, gamma, drag=True):
        """Return infinity: no step is unstable."""
        del omega, gamma, drag
        return math.inf
