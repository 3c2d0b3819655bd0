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

"""Extended position-based dynamics in small steps: constraints are met line after line."""
import math

from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import Coefficients, set_forces
from flag_sim.cloth.mesh import LEAST_LENGTH2, ONE
from flag_sim.cloth.solvers.plate import factor_plate, meet_plate, Plate
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.kernels import kernel, wide_kernel
import numpy as np


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
def _set_lines(before, position, weight, stiff, damp, rest, tail, head, lines, span):
    """Set each spring's direction, and its multiplier [kg m] if nothing gave way."""
    x, y, z = position
    bx, by, bz = before
    nx, ny, nz, multiplier, _ = lines
    one, least = type(stiff)(1.0), type(stiff)(LEAST_LENGTH2)
    first, last, _ = span
    for i in range(first, last):
        a, b = i + tail, i + head
        dx, dy, dz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        length = math.sqrt(max(dx * dx + dy * dy + dz * dz, least))
        scale = one / length
        dx, dy, dz = scale * dx, scale * dy, scale * dz
        nx[i], ny[i], nz[i] = dx, dy, dz
        grown = length - (dx * (bx[b] - bx[a]) + dy * (by[b] - by[a]) + dz * (bz[b] - bz[a]))
        multiplier[i] = weight[i] * (stiff * (length - rest) + damp * grown)


@kernel
def _solve_lines(inverse_mass, weight, stiffness, tail, head, back, lines, span):
    """
    Find the Lagrange multipliers p [kg m] of springs that give way to one another in their lines.

    Two springs that follow each other meet in a node, so each line has a tridiagonal system,
    p - s w c p_before + s (w + w') p - s w' c' p_after = p_0, with the multipliers p_0 of springs
    to which nothing gives way (see _set_lines), and the cosines c between neighbours. Gaussian
    elimination needs no pivots, as its diagonal outweighs the rest.
    """
    nx, ny, nz, multiplier, passed = lines
    one = type(stiffness)(1.0)
    first, last, _ = span
    for i in range(first, last):
        j = i - back
        s = weight[i] * stiffness
        ahead = s * inverse_mass[i + head]
        c = nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j]
        behind = s * inverse_mass[i + tail]
        scale = one / (one + ahead + behind * (one - c * c * passed[j]))
        multiplier[i] = scale * (multiplier[i] + behind * c * multiplier[j])
        passed[i] = scale * ahead
    for n in range(last - first):
        i = last - ONE - n
        j = i + back
        c = nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j]
        multiplier[i] += passed[i] * c * multiplier[j]


@kernel
def _move_lines(position, inverse_mass, tail, head, lines, span):
    """Move each node by the multipliers of the two springs of a line that meet in it."""
    multiplier = lines[3]
    first, last, _ = span
    for axis in range(3):
        x, n = position[axis], lines[axis]
        for i in range(first, last):
            a, b = i - tail, i - head
            x[i] += inverse_mass[i] * (multiplier[a] * n[a] - multiplier[b] * n[b])


@kernel
def _meet_lines(before, position, inverse_mass, weight, k, c, rest, dt, tail, head, lines, span):
    """
    Meet all springs from node i + tail to i + head, each line of them as a whole.

    The end of a line's spring is the beginning of the next one's. With the multiplier of Macklin
    et al. 2016 (26), but with compliance 1 / k and times k h^2, so that a spring of stiffness
    zero needs no infinite compliance.
    """
    stiff, damp = dt * dt * k, dt * c
    if stiff + damp > 0.0:
        _set_lines(before, position, weight, stiff, damp, rest, tail, head, lines, span)
        _solve_lines(inverse_mass, weight, stiff + damp, tail, head, head - tail, lines, span)
        _move_lines(position, inverse_mass, tail, head, lines, span)


@kernel
def _meet_springs(before, position, inverse_mass, weights, spring_k, spring_c, spring_rest, dt,
                  lines, span):
    """Meet diagonals, then columns, then rows: those that carry the cloth are right in the end."""
    k_a, k_d, k_x = spring_k
    c_a, c_d, c_x = spring_c
    a, d, x = spring_rest
    stride = span[2]
    none = np.uint64(0)
    _meet_lines(before, position, inverse_mass, weights.cell, k_x, c_x, x, dt, ONE, stride, lines,
                span)
    _meet_lines(before, position, inverse_mass, weights.cell, k_x, c_x, x, dt, none, stride + ONE,
                lines, span)
    _meet_lines(before, position, inverse_mass, weights.down, k_d, c_d, d, dt, none, stride,
                lines, span)
    _meet_lines(before, position, inverse_mass, weights.across, k_a, c_a, a, dt, none, ONE, lines,
                span)


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
                coefficients, work, lines, plate, dt, count, span):
    """Take count steps, each from one pair of arrays to the other."""
    one = type(dt)(1.0)
    keep = one / (one + dt * coefficients.node_damping)
    k, c, rest = coefficients.spring_k, coefficients.spring_c, coefficients.spring_rest
    zero = type(dt)(0.0)
    none = (zero, zero, zero)
    # Drag keeps from overshooting as in a method of order 2: taken over steps as long as these to
    # order 1, a wind that only holds the cloth up, and changes no velocity, would be too weak.
    outside = Coefficients(none, none, rest, none, coefficients.gravity, coefficients.drag,
                           coefficients.drag_rate, coefficients.law, 2, coefficients.node_damping,
                           coefficients.limits)
    is_plate = max(coefficients.bend) > 0.0
    if is_plate:
        factor_plate(inverse_mass, weights, coefficients.bend, dt, plate, span)
    for _ in range(count):
        set_forces(position, velocity, wind, mass, weights, outside, work, dt, span)
        _predict(position, velocity, work.force, inverse_mass, position_out, dt, keep, span)
        if is_plate:
            meet_plate(position_out, inverse_mass, weights, coefficients.bend, dt, plate, span)
        _meet_springs(position, position_out, inverse_mass, weights, k, c, rest, dt, lines, span)
        _set_velocity(position, position_out, velocity_out, dt, span)
        collide(position, position_out, velocity_out, coefficients.limits, work.contact, span)
        position, position_out = position_out, position
        velocity, velocity_out = velocity_out, velocity


class XPBD(Solver):
    """
    One sweep over all curvatures and lines of springs in each of many small steps.

    First order. Stable in steps of any length (Macklin, Mueller, Chentanez, XPBD, 2016; Macklin et
    al., Small Steps in Physics Simulation, 2019). Met spring after spring, a hanging strip would
    be too long by the factor 1 + h^2 k / m, as a sweep takes weight on by a node or two. So the
    springs of a line are met together, by elimination (Deul, Kugelstadt, Weiler, Bender, Direct
    Position-Based Solver for Stiff Rods, 2018): a strip hangs right, however long, in any steps.
    Between lines that cross an error of first order is left, about g h (h + c / k) a column.
    Curvatures are met by elimination too, so that the plate is the same on every grid; twists
    are a little too soft (see plate). The wind's drag is taken implicitly. Long steps lose energy.
    """

    order = 1
    scratch = 5
    useful_step = 1.0 / 600.0
    take_steps = staticmethod(_take_steps)

    def __init__(self, model):
        super().__init__(model)
        self._scratch = (*self._scratch, Plate.of(model))

    @staticmethod
    def largest_step(omega, gamma, air):
        """Return infinity: no step is unstable."""
        del omega, gamma, air
        return math.inf
