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
from typing import NamedTuple

from flag_sim.cloth.added_mass import add_inertia_of_air, AddedMass
from flag_sim.cloth.aerodynamics import node_wind_force
from flag_sim.cloth.bending import bending_force
from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import begin_element_forces, Forcing
from flag_sim.cloth.material import Air
from flag_sim.cloth.mesh import SMALLEST_BAND
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Band, NEXT, Vector
from flag_sim.cloth.solvers.solver import ONE_THREAD, Solver
from flag_sim.cloth.springs import spring_force
from flag_sim.cloth.state import State
from flag_sim.cloth.stations import Stations
from flag_sim.jit.kernels import inner_kernel, shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait
from flag_sim.parallel.thread_pool import ThreadPool
import numpy as np

PIECE = np.uint64(SMALLEST_BAND)
STRIP = np.uint64(40 * SMALLEST_BAND)
"""
Nodes whose elements are computed before they are summed, where there are many more.

All that belongs to them, some 350 bytes a node, is then still in the cache.
"""


class StepFactors(NamedTuple):
    """What a step multiplies by."""

    dt: float              # [s]
    damping_factor: float  # the part of a velocity that node damping leaves in a step
    gravity: Vector        # g times a unit vector upwards [m/s2]


@wide_kernel
def _move(nodes, nodes_out, tensions, moments, faces, sheet, factors, band):
    """
    Sum the forces on each node (eq. 1.6) and move it.

    Pins and ghosts have no inverse mass and do not move. One loop, so that no force is written to
    memory and read again: this saves about 10 % of a step. tensions, moments, faces: of Work; the
    last two None where they are not to be summed, for which numba compiles a loop of its own.
    """
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    x_out, y_out, z_out = nodes_out.position
    vx_out, vy_out, vz_out = nodes_out.velocity
    dt, damping_factor, (gx, gy, gz) = factors
    mass, inverse_mass = sheet.mass, sheet.inverse_mass
    first, last, stride = band
    for i in range(first, last):
        # Springs (eq. 1.2) and weight (eq. 1.1).
        fx = spring_force(x, tensions, i, stride) - gx * mass[i]
        fy = spring_force(y, tensions, i, stride) - gy * mass[i]
        fz = spring_force(z, tensions, i, stride) - gz * mass[i]
        # Bending.
        if moments is not None:
            fx += bending_force(moments[0], i, stride)
            fy += bending_force(moments[1], i, stride)
            fz += bending_force(moments[2], i, stride)
        # The wind on the faces around the node (eqs. 1.3, 1.4).
        if faces is not None:
            fx += node_wind_force(faces[0], faces[3], i, stride)
            fy += node_wind_force(faces[1], faces[4], i, stride)
            fz += node_wind_force(faces[2], faces[5], i, stride)
        t_m = dt * inverse_mass[i]            # a = t F / m: eqs. 1.7, 1.8
        # v = v0 + a: eq. 1.9
        vx_new = (vx[i] + t_m * fx) * damping_factor
        vy_new = (vy[i] + t_m * fy) * damping_factor
        vz_new = (vz[i] + t_m * fz) * damping_factor
        vx_out[i], vy_out[i], vz_out[i] = vx_new, vy_new, vz_new
        x_out[i] = x[i] + dt * vx_new         # x = x0 + v: eq. 1.10, with v in metres per second
        y_out[i] = y[i] + dt * vy_new
        z_out[i] = z[i] + dt * vz_new


@shared_kernel
def _move_band(nodes, nodes_out, sheet, coefficients, work, factors, scratch, band):
    """
    Move the nodes of a band by all forces, to where pole and attachment let them be.

    scratch: where air moves along, its inertia comes first.
    """
    tensions, moments, faces = work.tensions, work.moments, work.faces
    is_bent, is_blown = max(coefficients.bend) > 0.0, coefficients.wind.drag > 0.0
    # The sum of the forces on each node, with its weight; the node's new velocity and position.
    if is_bent and is_blown:
        _move(nodes, nodes_out, tensions, moments, faces, sheet, factors, band)
    elif is_bent:
        _move(nodes, nodes_out, tensions, moments, None, sheet, factors, band)
    elif is_blown:
        _move(nodes, nodes_out, tensions, None, faces, sheet, factors, band)
    else:
        _move(nodes, nodes_out, tensions, None, None, sheet, factors, band)
    # The pole, and the attachment to the hoist.
    if scratch is None:
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)


@inner_kernel
def _strip(begin, end, band):
    """Return as a Band the nodes of a band from one on to another, not included."""
    return Band(begin, max(min(end, band.last), begin), band.stride)


@shared_kernel
def _take_steps(nodes, nodes_out, sheet, coefficients, work, scratch, steps, band):
    """Take steps as Solver.take_steps says."""
    dt = steps.dt
    one = type(dt)(1.0)
    # Node damping, taken implicitly: v' = v - h nu v'.
    factors = StepFactors(dt, one / (one + dt * coefficients.node_damping), coefficients.gravity)
    first, last, stride = band
    # In whole pieces, so that nodes are computed by the same instructions in strips of any size.
    margin = (stride // PIECE + NEXT) * PIECE
    is_large = last > first + STRIP
    inner = first + margin if is_large else first
    for _ in range(steps.count):
        # Tensions of the springs, moments of bending and the wind's force on the faces. In a band
        # that is large, nodes that have all of theirs are moved while these are in the cache.
        begin, moved = first, inner
        while begin < last:
            strip = _strip(begin, begin + STRIP, band)
            begin_element_forces(nodes, sheet.weights, coefficients, work, dt, strip)
            begin = strip.last
            if is_large and begin > moved + margin and begin < last:
                ready = _strip(moved, begin - margin, band)
                _move_band(nodes, nodes_out, sheet, coefficients, work, factors, scratch, ready)
                moved = ready.last
        wait(work.barrier)
        # The other nodes need elements of the bands before and after, too.
        if inner > first:
            _move_band(nodes, nodes_out, sheet, coefficients, work, factors, scratch,
                       _strip(first, inner, band))
        _move_band(nodes, nodes_out, sheet, coefficients, work, factors, scratch,
                   _strip(moved, last, band))
        wait(work.barrier)
        # The air that moves with the cloth; scratch is None where none does.
        if scratch is not None:
            add_inertia_of_air(nodes, nodes_out, sheet, scratch, work.barrier, dt, band)
            collide(nodes, nodes_out, coefficients.limits, work.contact, band)
            wait(work.barrier)
        nodes, nodes_out = nodes_out, nodes


class Symplectic(Solver):
    """
    The source text's method (eqs. 1.7 to 1.11) with corrected units.

    First order; conditionally stable: see largest_step. Springs and bending are explicit, the drag
    of the wind and the nodes' own damping implicit. Without damping it keeps the energy within a
    bound forever, since it is symplectic.
    """

    order = 1
    drag_order = 1
    take_steps = staticmethod(_take_steps)
    is_parallel = True
    moves_air = True
    _stations: Stations | None = None

    @classmethod
    def new_scratch(cls, model: Model) -> None:
        """Return None: there are no stations until air moves with the cloth."""
        return None

    def advance(self, state: State, spare: State, forcing: Forcing, dt: float, count: int,
                pool: ThreadPool = ONE_THREAD) -> State:
        """Take steps as Solver.advance does, with the inertia of the air where it is asked for."""
        self._scratch = self._air(forcing) if forcing.air.moves_along else None
        return super().advance(state, spare, forcing, dt, count, pool)

    def _air(self, forcing):
        """Return the AddedMass under a forcing."""
        if self._stations is None:
            self._stations = Stations.of(self.model)
        return AddedMass.of(self._stations, self.model, forcing)

    @classmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """
        Return the largest stable step [s] for frequencies and damping rates up to omega and gamma.

        A mode obeys v' = v - h (omega^2 x + gamma v), x' = x + h v'. Its amplification matrix has
        determinant 1 - h gamma and trace 2 - h gamma - h^2 omega^2: both its eigenvalues are
        within the unit circle (Jury) where h^2 omega^2 + 2 h gamma <= 4. The drag of the air adds
        its own rate to h gamma, and takes up 2 greatest_rate of the 4.
        """
        room = 4.0 - 2.0 * air.greatest_rate(cls.drag_order)
        rate = gamma + math.sqrt(gamma**2 + room * omega**2)
        return room / rate if rate > 0.0 else math.inf
