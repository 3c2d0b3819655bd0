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
"""
The inertia of the air that moves with the cloth: Lighthill's reactive force, with its convection.

Air that a flag meets keeps, while it passes along the rows, the velocity across the cloth that it
got on the way: the force on the cloth, per area and along its normal n, is

    p = -M (n . a + u n . dv/ds + d(u n . w)/ds),    M = added_mass rho pi H / 4,

with the acceleration a and velocity v of the cloth, its velocity w = v - W against the air, the
speed u of the air along the rows, and s from hoist to fly. For small waves y(x, t) in a wind U
that is -M (d/dt + U d/dx)^2 y (Lighthill, Note on the swimming of slender fish, 1960; for flags
Singh, Michelin and de Langre 2012, with the drag of aerodynamics beside it). M is the mean over
the width H of 2 rho sqrt(H^2/4 - z^2) for added_mass 1, of waves much longer than H. It is the
same in each frame of reference: a steady motion of all adds to v what it adds to W, and a turning
one, with spin, spin x X to both v and the cloth's velocities in the frame.

Air cannot follow waves much shorter than H. So all of that is taken of whole strips of the cloth,
at stations (see stations). A strip that is curled has a chord of less than H and a normal of less
than 1, n . n times the added mass. Differences along the rows are upwind.

a is that of the step itself. With f the forces at the stations, B v = n . v there, and the
cloth's mass m, f = -D (B a + c) and a = a_0 + m^-1 B^T f give

    (1 + D B m^-1 B^T) f = -D (B a_0 + c),

which is symmetric after scaling by the root of D, and has a row for each station. Springs see the
cloth with the air's mass, so that no step becomes unstable by it.

In a step the force may add to the cloth's energy, as it is seen from the pole, what a drag
coefficient of 1 on the whole cloth would take from the wind, but no more than that of the cloth at
the wind's speed; beyond, it is weakened. In calm air it only takes energy.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Band, Nodes, Sheet, Vector
from flag_sim.cloth.stations import (
    CHANGE, CHORD, kick, POSITION, set_kicks, Stations, sum_columns, take_means, TANGENT, VELOCITY)
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel, shared_kernel
from flag_sim.parallel.barrier import wait
import numpy as np


class AddedMass(NamedTuple):
    """The air that moves with a cloth, in numbers for kernels."""

    stations: Stations
    ratio: float         # M by the cloth's mass per area
    wind: Vector         # W where positions are measured from [m/s]
    spin: Vector         # of the frame of reference [rad/s]
    spacing: float       # of stations [m]
    power: float         # the most that the cloth's energy may gain [W]
    energy: float        # the most that it may gain in a step [J]
    rows: np.uint64
    grid: Band           # all nodes
    matrix: np.ndarray   # (stations, stations), to compute in
    force: np.ndarray    # (stations,) [N], to compute in
    normals: np.ndarray  # (stations, 3), to compute in

    @classmethod
    def of(cls, stations: Stations, model: Model, forcing: Forcing) -> 'AddedMass':
        """Return the added mass of a model under a forcing."""
        mesh, air, count = model.mesh, forcing.air, len(stations.mass)
        inertia = 0.25 * math.pi * air.added_mass * air.density * mesh.width
        wind = np.asarray(forcing.wind) - np.cross(forcing.spin, forcing.lever)
        if air.law == 'seed':
            wind = wind - forcing.drift
        # Of the strongest wind that any part of the cloth meets.
        speed = math.hypot(*wind) + math.hypot(*forcing.spin) * mesh.length
        return cls(stations, inertia / model.material.area_density, tuple(wind.tolist()),
                   tuple(float(part) for part in forcing.spin), mesh.length / (count - 1),
                   0.5 * air.density * speed**3 * mesh.length * mesh.width,
                   0.5 * float(stations.mass.sum()) * speed**2, np.uint64(mesh.rows), mesh.band(),
                   np.zeros((count, count)), np.zeros(count), np.zeros((count, 3)))


@shared_kernel
def add_inertia_of_air(nodes: Nodes, nodes_out: Nodes, sheet: Sheet, air: AddedMass,
                       barrier: np.ndarray, dt: float, band: Band) -> None:
    """
    Change velocities and positions after a step [s] by what the air's inertia makes of them.

    nodes: before the step. nodes_out: after it by all other forces, then by this one, too; not
    yet turned with the frame (see turning), nor brought back by the pole.
    """
    sum_columns(nodes, nodes_out, sheet.mass, air.stations.sums, air.rows, air.grid, band)
    wait(barrier)
    if air.grid.first == band.first < band.last:  # one thread alone: that of the first nodes
        take_means(nodes, air.stations, air.rows, air.grid)
        _set_forces(air, float(dt))
        _set_matrix(air)
        _solve(air.matrix, air.force)
        _set_changes(air, float(dt))
        set_kicks(air.stations, air.normals)
    wait(barrier)
    kick(nodes_out, air.stations.kicks, dt, air.grid, band)


@lean_inner_kernel
def _vector(mean, begin):
    return mean[begin], mean[begin + 1], mean[begin + 2]


@lean_inner_kernel
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@lean_inner_kernel
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lean_inner_kernel
def _within_one(a):
    """Return a vector, no longer than 1: strips that are stretched do not have more air."""
    size = math.sqrt(max(_dot(a, a), 1.0))
    return a[0] / size, a[1] / size, a[2] / size


@lean_kernel
def _set_forces(air, dt):
    """Set the normals, and the right side of the system by the root of D: see the module."""
    means, normals, force = air.stations.means, air.normals, air.force
    upwind_flow = upwind_w = 0.0
    before = 0.0, 0.0, 0.0
    for j in range(len(force)):
        mean = means[j]
        along = _within_one(_vector(mean, TANGENT))
        n = _within_one(_cross(along, _vector(mean, CHORD)))
        turning = _cross(air.spin, _vector(mean, POSITION))
        v = mean[VELOCITY] + turning[0], mean[VELOCITY + 1] + turning[1], \
            mean[VELOCITY + 2] + turning[2]
        against = v[0] - air.wind[0], v[1] - air.wind[1], v[2] - air.wind[2]
        flow = max(-_dot(against, along), 0.0)  # none where the cloth is blown backwards
        w = _dot(n, against)
        convection = 0.0
        if j > 0:
            growth = v[0] - before[0], v[1] - before[1], v[2] - before[2]
            convection = flow * _dot(n, growth) + flow * w - upwind_flow * upwind_w
            # No more than the air can pass in a step.
            convection /= air.spacing + 2.0 * flow * dt
        upwind_flow, upwind_w, before = flow, w, v
        normals[j, 0], normals[j, 1], normals[j, 2] = n
        force[j] = -math.sqrt(air.ratio * air.stations.mass[j]) * (
            _dot(n, _vector(mean, CHANGE)) / dt + convection)


@lean_kernel
def _set_matrix(air):
    """Set the lower triangle of the symmetric matrix 1 + D^1/2 B m^-1 B^T D^1/2."""
    matrix, mass, normals = air.matrix, air.stations.mass, air.normals
    for j in range(len(mass)):
        for i in range(j + 1):
            matrix[j, i] = (air.ratio * math.sqrt(mass[j] * mass[i])
                            * air.stations.compliance[j, i] * _dot(normals[j], normals[i]))
        matrix[j, j] += 1.0


@lean_kernel
def _solve(matrix, force):
    """Solve matrix x = force (Cholesky, in the lower triangle); force becomes x."""
    count = len(force)
    for j in range(count):
        for k in range(j):
            matrix[j, j] -= matrix[j, k] * matrix[j, k]
        matrix[j, j] = math.sqrt(matrix[j, j])
        for i in range(j + 1, count):
            for k in range(j):
                matrix[i, j] -= matrix[i, k] * matrix[j, k]
            matrix[i, j] /= matrix[j, j]
    for j in range(count):
        for k in range(j):
            force[j] -= matrix[j, k] * force[k]
        force[j] /= matrix[j, j]
    for j in range(count - 1, -1, -1):
        for k in range(j + 1, count):
            force[j] -= matrix[k, j] * force[k]
        force[j] /= matrix[j, j]


@lean_kernel
def _set_changes(air, dt):
    """Turn normals into changes of velocity [m/s], by forces no stronger than power allows."""
    means, normals, force = air.stations.means, air.normals, air.force
    compliance, mass = air.stations.compliance, air.stations.mass
    for j in range(len(force)):
        force[j] *= math.sqrt(air.ratio * mass[j])
    # The energy that the cloth gains is theta (linear + theta quadratic / 2): the work on the mean
    # of the velocities before and after. By just that symplectic steps change what they conserve.
    linear = quadratic = 0.0
    for j in range(len(force)):
        n = normals[j]
        linear += dt * force[j] * (_dot(n, _vector(means[j], VELOCITY))
                                   + 0.5 * _dot(n, _vector(means[j], CHANGE)))
        for i in range(len(force)):
            quadratic += (dt * dt * force[j] * compliance[j, i] * force[i]
                          * _dot(n, normals[i]))
    most, theta = min(air.power * dt, air.energy), 1.0
    if linear + 0.5 * quadratic > most:
        root = math.sqrt(linear * linear + 2.0 * quadratic * most)
        theta = 2.0 * most / (linear + root) if linear > 0.0 else (root - linear) / quadratic
    for j in range(len(force)):
        for axis in range(3):
            normals[j, axis] *= theta * dt * force[j] / mass[j]
