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
Strips of a cloth from edge to edge, as the air that moves with it sees them, at stations along it.

A station stands for the strip around it: for means over rows and over hats, which reach to the
stations before and after. Of a strip there are where it is, how it moves, its tangent along the
rows, and the chord from its upper to its lower edge, by the width. The vector product of both is
its normal: one where the strip is flat, shorter where it is curled or crumpled.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import Mesh, SMALLEST_BAND
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Band, Nodes
from flag_sim.jit.kernels import lean_kernel, wide_kernel
import numpy as np

STATION = 0.2
"""Greatest distance of stations, by the width; so a hat is at most 0.4 of it wide."""
MOST_STATIONS = 33
"""On a long flag they are farther apart; and there are no more than columns."""
WHOLE = 16
"""Columns that are summed at once: one or two vectors."""
PIECE = SMALLEST_BAND
"""Nodes that are moved at once."""
POSITION, VELOCITY, CHANGE, CHORD, TANGENT = range(0, 15, 3)
"""Where means of vectors begin; CHANGE is that of velocities by the other forces in a step."""


class Stations(NamedTuple):
    """The stations of a model along its rows, and arrays to compute in."""

    mass: np.ndarray        # (stations,): of the cloth at each [kg]
    compliance: np.ndarray  # (stations, stations): of strips whose normals are alike [1/kg]
    span: np.ndarray        # (stations, 2): the first column of each, and that after its last
    weight: np.ndarray      # (stations, columns): a mean is that of sums over rows [1/kg]
    slope: np.ndarray       # (stations, columns): of the same for a mean derivative [1/(kg m)]
    own: np.ndarray         # (columns,): mass of a column, by the width [kg/m]
    hat: np.ndarray         # (stride,): the first of the two stations of a column
    shares: np.ndarray      # (2, stride): its shares of both; zero where no node moves
    sums: tuple             # nine (columns or more,): of mass times vectors over rows
    means: np.ndarray       # (stations, 15)
    kicks: tuple            # x, y, z (stride + PIECE,): change of velocity by columns [m/s]

    @classmethod
    def of(cls, model: Model) -> 'Stations':
        """Return the stations of a model."""
        mesh = model.mesh
        count = math.ceil(mesh.length / (STATION * mesh.width) - 1e-9) + 1
        count = min(count, mesh.columns, MOST_STATIONS)
        at = np.linspace(0.0, count - 1.0, mesh.columns)
        hat = np.minimum(at.astype(np.int64), count - 2)
        hats = np.zeros((count, mesh.columns))
        hats[hat, np.arange(mesh.columns)] = 1.0 - (at - hat)
        hats[hat + 1, np.arange(mesh.columns)] = at - hat
        own = mesh.grid(model.mass).sum(axis=0).astype(float)
        free = mesh.grid(mesh.free)[0].astype(float)
        mass = hats @ own
        weight = hats / mass[:, None]
        slope = (weight * own) @ np.gradient(np.eye(mesh.columns), mesh.dx, axis=0) / own
        seen = (weight != 0.0) | (slope != 0.0)
        span = np.stack([seen.argmax(axis=1), mesh.columns - seen[:, ::-1].argmax(axis=1)], axis=1)
        shares = np.zeros((2, mesh.stride))
        shares[:, :-1] = free * (1.0 - (at - hat)), free * (at - hat)
        number = model.mass.dtype
        return cls(mass, (hats * own * free) @ hats.T / np.outer(mass, mass), span, weight, slope,
                   own / mesh.width, np.append(hat, 0), shares,
                   tuple(np.zeros((9, _whole(mesh)), number)), np.zeros((count, 15)),
                   tuple(np.zeros((3, mesh.stride + PIECE), number)))


def _whole(mesh: Mesh) -> int:
    """
    Return how many columns are summed: whole vectors of them, where there are enough.

    Those too many are nodes of the next row, or ghosts, and looked at by nobody.
    """
    return -(-mesh.columns // WHOLE) * WHOLE if mesh.stride >= WHOLE else mesh.columns


@wide_kernel
def sum_columns(nodes: Nodes, nodes_out: Nodes, mass: np.ndarray, sums: tuple, rows: np.uint64,
                grid: Band, band: Band) -> None:
    """
    Set sums to those over rows of mass times position, velocity, and change of velocity.

    Each thread has its share of columns, as it has of the nodes from grid.first to grid.last.
    """
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    vx_out, vy_out, vz_out = nodes_out.velocity
    sx, sy, sz, svx, svy, svz, sax, say, saz = sums
    piece = np.uint64(WHOLE)
    count, whole = np.uint64(len(sx)), grid.last - grid.first
    begin = count * (band.first - grid.first) // whole // piece * piece
    end = count * (band.last - grid.first) // whole // piece * piece
    if band.last == grid.last:
        end = count
    for column in range(begin, end):
        sx[column] = sy[column] = sz[column] = 0.0
        svx[column] = svy[column] = svz[column] = 0.0
        sax[column] = say[column] = saz[column] = 0.0
    for row in range(rows):
        start = grid.first + row * grid.stride
        for column in range(begin, end):
            i = start + column
            m = mass[i]
            sx[column] += m * x[i]
            sy[column] += m * y[i]
            sz[column] += m * z[i]
            svx[column] += m * vx[i]
            svy[column] += m * vy[i]
            svz[column] += m * vz[i]
            sax[column] += m * (vx_out[i] - vx[i])
            say[column] += m * (vy_out[i] - vy[i])
            saz[column] += m * (vz_out[i] - vz[i])


@lean_kernel
def take_means(nodes: Nodes, stations: Stations, rows: np.uint64, grid: Band) -> None:
    """Set stations.means from the sums, and the chords of the strips from their edges."""
    x, y, z = nodes.position
    sx, sy, sz, svx, svy, svz, sax, say, saz = stations.sums
    below = (rows - np.uint64(1)) * grid.stride
    means = stations.means
    for j in range(len(stations.mass)):
        px = py = pz = vx = vy = vz = ax = ay = az = cx = cy = cz = tx = ty = tz = 0.0
        for column in range(stations.span[j, 0], stations.span[j, 1]):
            weight, slope = stations.weight[j, column], stations.slope[j, column]
            upper = grid.first + np.uint64(column)
            lower = upper + below
            own = weight * stations.own[column]
            px += weight * sx[column]
            py += weight * sy[column]
            pz += weight * sz[column]
            vx += weight * svx[column]
            vy += weight * svy[column]
            vz += weight * svz[column]
            ax += weight * sax[column]
            ay += weight * say[column]
            az += weight * saz[column]
            cx += own * (x[lower] - x[upper])
            cy += own * (y[lower] - y[upper])
            cz += own * (z[lower] - z[upper])
            tx += slope * sx[column]
            ty += slope * sy[column]
            tz += slope * sz[column]
        mean = means[j]
        mean[0], mean[1], mean[2], mean[3], mean[4], mean[5] = px, py, pz, vx, vy, vz
        mean[6], mean[7], mean[8], mean[9], mean[10], mean[11] = ax, ay, az, cx, cy, cz
        mean[12], mean[13], mean[14] = tx, ty, tz


@lean_kernel
def set_kicks(stations: Stations, changes: np.ndarray) -> None:
    """Set stations.kicks from changes of velocity at the stations, (stations, 3 or more) [m/s]."""
    hat, shares, count = stations.hat, stations.shares, len(stations.hat)
    for axis in range(3):
        kicks = stations.kicks[axis]
        for column in range(count):
            j = hat[column]
            kicks[column] = (shares[0, column] * changes[j, axis]
                             + shares[1, column] * changes[j + 1, axis])
        # They go on as rows do, one after the other.
        for column in range(count, len(kicks)):
            kicks[column] = kicks[column - count]


@wide_kernel
def kick(nodes_out: Nodes, kicks: tuple, dt: float, grid: Band, band: Band) -> None:
    """Add the kicks to velocities of a band, and what they move in a step to positions."""
    x, y, z = nodes_out.position
    vx, vy, vz = nodes_out.velocity
    kx, ky, kz = kicks
    piece, begin = np.uint64(PIECE), band.first
    while begin < band.last:
        shift = (begin - grid.first) % grid.stride
        for i in range(begin, min(begin + piece, band.last)):
            k = i - begin + shift
            vx[i] += kx[k]
            vy[i] += ky[k]
            vz[i] += kz[k]
            x[i] += dt * kx[k]
            y[i] += dt * ky[k]
            z[i] += dt * kz[k]
        begin += piece
