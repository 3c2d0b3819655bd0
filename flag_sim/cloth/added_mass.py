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

    p = -M (a_n + u d(v_n)/ds + d(u w_n)/ds),    M = added_mass rho pi H / 4,

with the acceleration a and velocity v of the cloth, the apparent wind -w = W - v, u its speed
along the rows, s from hoist to fly, and ._n the part along n. For small waves y(x, t) in a wind U
that is -M (d/dt + U d/dx)^2 y (Lighthill, Note on the swimming of slender fish, 1960; for flags
Singh, Michelin and de Langre 2012, with the drag of aerodynamics beside it). M is the mean over
the width H of 2 rho sqrt(H^2/4 - z^2) for added_mass 1, of waves much longer than H.

Air cannot follow waves much shorter than H. So v_n, w_n, u and n are taken at stations along the
rows, at most STATION times H apart: means over the rows and over hats of two such lengths. A
station where normals point everywhere, as the cloth is crumpled, has so much less added mass.
Differences along the rows are upwind.

a_n is that of the step itself. With f the forces at the stations, B the means, so that v_n = B v,
and the cloth's mass m, f = -D (B a + c) and a = a_0 + m^-1 B^T f give

    (1 + D B m^-1 B^T) f = -D (B a_0 + c),

which is symmetric after scaling by the root of D, and has a row for each station: B m^-1 B^T does
not depend on the normals. Springs see the cloth with the air's mass, so that no step becomes
unstable by it.

In a step the force may add to the cloth's energy what a drag coefficient of 1 on the whole cloth
would take from the wind, but no more than that of the cloth at the wind's speed; beyond, it is
weakened. In calm air it only takes energy.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.material import Air
from flag_sim.cloth.mesh import LEAST_AREA2, LEAST_LENGTH2
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Band, NEXT, Nodes, Sheet, Vector
from flag_sim.jit.kernels import lean_kernel, shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait
import numpy as np

STATION = 0.2
"""Greatest distance of stations, by the width; so a hat is at most 0.4 of it wide."""
MOST_STATIONS = 33
"""On a long flag they are farther apart; and there are no more than columns."""


class Stations(NamedTuple):
    """The stations of a model along its rows, and arrays to compute in."""

    hat: np.ndarray         # (columns,): the first of the two stations of a column
    part: np.ndarray        # (columns,): the share of the second
    mass: np.ndarray        # (stations,): of the cloth at each [kg]
    compliance: np.ndarray  # (stations, stations): B m^-1 B^T [1/kg]
    column: np.ndarray      # flat: of each node
    free: np.ndarray        # flat: 1 where a node moves, 0 at pins and ghosts
    seen: tuple             # six flat fields: n, v_n before and after the step, u
    sums: tuple             # six (columns,): sums of the same over rows, times the mass
    means: np.ndarray       # (stations, 6): means of the same
    matrix: np.ndarray      # (stations, stations)
    force: np.ndarray       # (stations,) [N]
    kick: np.ndarray        # (columns,): change of velocity along n [m/s]

    @classmethod
    def of(cls, model: Model) -> 'Stations':
        """Return the stations of a model."""
        mesh = model.mesh
        count = math.ceil(mesh.length / (STATION * mesh.width) - 1e-9) + 1
        count = min(count, mesh.columns, MOST_STATIONS)
        at = np.linspace(0.0, count - 1.0, mesh.columns)
        hat = np.minimum(at.astype(np.int64), count - 2)
        shares = np.zeros((count, mesh.columns))
        shares[hat, np.arange(mesh.columns)] = 1.0 - (at - hat)
        shares[hat + 1, np.arange(mesh.columns)] = at - hat
        own = mesh.grid(model.mass).sum(axis=0).astype(float)
        moving = (mesh.grid(model.mass) * mesh.grid(mesh.free)).sum(axis=0).astype(float)
        mass = shares @ own
        number = mesh.pad(np.ones((mesh.rows, mesh.columns))).dtype
        column = np.zeros(mesh.size, np.int64)
        mesh.grid(column)[...] = np.arange(mesh.columns)
        return cls(hat, at - hat, mass, (shares * moving) @ shares.T / np.outer(mass, mass),
                   column, mesh.free, tuple(mesh.fields(6)), tuple(np.zeros((6, mesh.columns))),
                   np.zeros((count, 6)), np.zeros((count, count)), np.zeros(count),
                   np.zeros(mesh.columns, number))


class AddedMass(NamedTuple):
    """The air that moves with a cloth, in numbers for kernels."""

    stations: Stations
    ratio: float    # M by the cloth's mass per area
    wind: Vector    # W [m/s]
    spacing: float  # of stations [m]
    power: float    # the most that the cloth's energy may gain [W]
    energy: float   # the most that it may gain in a step [J]
    rows: np.uint64
    first: np.uint64  # node of the mesh

    @classmethod
    def of(cls, stations: Stations, model: Model, air: Air, wind: Vector) -> 'AddedMass':
        """Return the added mass of a model in a wind (x, y, z) [m/s]."""
        mesh = model.mesh
        inertia = 0.25 * math.pi * air.added_mass * air.density * mesh.width
        speed = math.sqrt(sum(float(part)**2 for part in wind))
        return cls(stations, inertia / model.material.area_density,
                   tuple(float(part) for part in wind), mesh.length / (len(stations.mass) - 1),
                   0.5 * air.density * speed**3 * mesh.length * mesh.width,
                   0.5 * float(stations.mass.sum()) * speed**2,
                   np.uint64(mesh.rows), np.uint64(mesh.first))


@shared_kernel
def add_inertia_of_air(nodes: Nodes, nodes_out: Nodes, sheet: Sheet, air: AddedMass,
                       barrier: np.ndarray, dt: float, band: Band) -> None:
    """
    Change velocities and positions after a step [s] by what the air's inertia makes of them.

    nodes: before the step. nodes_out: after it without this force, then with it.
    """
    stations = air.stations
    _see(nodes, nodes_out, sheet.weights, air.wind, stations.seen, band)
    wait(barrier)
    if air.first == band.first < band.last:  # one thread alone: that of the first nodes
        _take_means(sheet.mass, stations, air.rows, air.first, band.stride)
        _set_matrix_and_force(air, stations.means, float(dt))
        _solve(stations.matrix, stations.force)
        _set_kick(air, stations.means, float(dt))
    wait(barrier)
    _kick(nodes_out, stations.seen, stations, dt, band)


@wide_kernel
def _see(nodes, nodes_out, weights, wind, seen, band):
    """Fill seen: normals, velocities along them before and after a step, wind along the rows."""
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    vx_out, vy_out, vz_out = nodes_out.velocity
    nx, ny, nz, before, after, flow = seen
    number = x.dtype.type
    wx, wy, wz = number(wind[0]), number(wind[1]), number(wind[2])
    first, last, stride = band
    for i in range(first, last):
        e, w, s, n = i + NEXT, i - NEXT, i + stride, i - stride
        a, b, c, d = weights.across[i], weights.across[w], weights.down[i], weights.down[n]
        ax = a * (x[e] - x[i]) + b * (x[i] - x[w])
        ay = a * (y[e] - y[i]) + b * (y[i] - y[w])
        az = a * (z[e] - z[i]) + b * (z[i] - z[w])
        dx = c * (x[s] - x[i]) + d * (x[i] - x[n])
        dy = c * (y[s] - y[i]) + d * (y[i] - y[n])
        dz = c * (z[s] - z[i]) + d * (z[i] - z[n])
        px, py, pz = ay * dz - az * dy, az * dx - ax * dz, ax * dy - ay * dx
        area = math.sqrt(max(px * px + py * py + pz * pz, number(LEAST_AREA2)))
        long = math.sqrt(max(ax * ax + ay * ay + az * az, number(LEAST_LENGTH2)))
        inverse = number(1.0) / (area * long)  # one division serves both
        px, py, pz = px * (inverse * long), py * (inverse * long), pz * (inverse * long)
        nx[i], ny[i], nz[i] = px, py, pz
        before[i] = vx[i] * px + vy[i] * py + vz[i] * pz
        after[i] = vx_out[i] * px + vy_out[i] * py + vz_out[i] * pz
        flow[i] = (((wx - vx[i]) * ax + (wy - vy[i]) * ay + (wz - vz[i]) * az)
                   * (inverse * area))


@wide_kernel
def _add_rows(mass, values, sums, rows, first, stride):
    """Set sums (columns,) to the sums of mass times values over rows, from top to bottom."""
    columns = np.uint64(len(sums))
    for column in range(columns):
        sums[column] = 0.0
    for row in range(rows):
        begin = first + row * stride
        for column in range(columns):
            sums[column] += mass[begin + column] * np.float64(values[begin + column])


@lean_kernel
def _take_means(mass, stations, rows, first, stride):
    """Set stations.means to means of what was seen, weighted by mass; always in one order."""
    means = stations.means
    means[...] = 0.0
    for axis in range(6):
        sums = stations.sums[axis]
        _add_rows(mass, stations.seen[axis], sums, rows, first, stride)
        for column in range(len(sums)):
            hat, part = stations.hat[column], stations.part[column]
            means[hat, axis] += (1.0 - part) * sums[column]
            means[hat + 1, axis] += part * sums[column]
    for station in range(len(stations.mass)):
        for axis in range(6):
            means[station, axis] /= stations.mass[station]


@lean_kernel
def _set_matrix_and_force(air, means, dt):
    """Set the symmetric matrix and its right side: see the module's last formula."""
    matrix, force, mass = air.stations.matrix, air.stations.force, air.stations.mass
    compliance = air.stations.compliance
    wx, wy, wz = air.wind
    upwind_flow = upwind_v = upwind_w = 0.0
    for j in range(len(mass)):
        nx, ny, nz, before, after, flow = means[j]
        flow = max(flow, 0.0)  # none where the cloth is blown backwards
        w = before - (wx * nx + wy * ny + wz * nz)
        convection = 0.0
        if j > 0:
            convection = flow * (before - upwind_v) + flow * w - upwind_flow * upwind_w
            # No more than the air can pass in a step.
            convection /= air.spacing + 2.0 * flow * dt
        upwind_flow, upwind_v, upwind_w = flow, before, w
        root = math.sqrt(air.ratio * mass[j] * (nx * nx + ny * ny + nz * nz))
        force[j] = -root * ((after - before) / dt + convection)
        matrix[j, j] = root
    for j in range(len(mass)):
        for i in range(j):
            matrix[j, i] = matrix[j, j] * compliance[j, i] * matrix[i, i]
    for j in range(len(mass)):
        root = matrix[j, j]
        means[j, 0] = root
        matrix[j, j] = 1.0 + root * compliance[j, j] * root


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
def _set_kick(air, means, dt):
    """Set the kicks by the scaled forces in stations.force, no stronger than air.power allows."""
    stations = air.stations
    force, compliance, mass = stations.force, stations.compliance, stations.mass
    for j in range(len(mass)):
        force[j] *= means[j, 0]
    # The energy that the cloth gains is theta (linear + theta quadratic / 2): the work on the mean
    # of the velocities before and after. By just that symplectic steps change what they conserve.
    linear = quadratic = 0.0
    for j in range(len(mass)):
        linear += dt * force[j] * 0.5 * (means[j, 3] + means[j, 4])
        for i in range(len(mass)):
            quadratic += dt * dt * force[j] * compliance[j, i] * force[i]
    most, theta = min(air.power * dt, air.energy), 1.0
    if linear + 0.5 * quadratic > most:
        root = math.sqrt(linear * linear + 2.0 * quadratic * most)
        theta = 2.0 * most / (linear + root) if linear > 0.0 else (root - linear) / quadratic
    for column in range(len(stations.hat)):
        hat, part = stations.hat[column], stations.part[column]
        stations.kick[column] = theta * dt * ((1.0 - part) * force[hat] / mass[hat]
                                              + part * force[hat + 1] / mass[hat + 1])


@wide_kernel
def _kick(nodes_out, seen, stations, dt, band):
    """Add the kicks to velocities, and what they move in a step to positions."""
    x, y, z = nodes_out.position
    vx, vy, vz = nodes_out.velocity
    nx, ny, nz = seen[0], seen[1], seen[2]
    first, last, _ = band
    for i in range(first, last):
        kick = stations.free[i] * stations.kick[stations.column[i]]
        kx, ky, kz = kick * nx[i], kick * ny[i], kick * nz[i]
        vx[i] += kx
        vy[i] += ky
        vz[i] += kz
        x[i] += dt * kx
        y[i] += dt * ky
        z[i] += dt * kz
