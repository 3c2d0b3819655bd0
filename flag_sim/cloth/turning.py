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
The turn of the pole in a step, and what it does to the nodes.

The cloth is computed in the pole's own frame of reference (see pole_frame). While that turns at
spin [rad/s], a node at X from the point that it turns about, moving at w in the frame, moves at
u = w + spin x X in one that does not turn. A method takes each step of h, from X and w, as if the
frame stood still; d is what forces have then added to the way h w, and c to the velocity. The
nodes are afterwards brought to where a node without forces would be, which goes straight on by
h u and is seen from a frame that has turned, and d and c are added to that:

    X' = Q (X + h u) + P d,
    w' = Q u + P c - spin x X'.

Q is the turn back by h spin, and P by what was left of it when the forces acted: all of it for
methods that take them at the step's beginning, half of it for their mean (Solver.force_time).
These are the Coriolis and the centrifugal force. Free motion is exact for any turn, so that
nothing can grow by it, and methods of second order keep theirs.
"""
import functools
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Band, Nodes, Vector
from flag_sim.jit.kernels import lean_inner_kernel, wide_kernel
import numpy as np


class Turn(NamedTuple):
    """The turn of a step of h [s], in the numbers of a mesh and in the pole's axes."""

    size: float    # of the angle [rad]; zero: the pole does not turn
    time: float    # h, by the unit of time that velocities have
    angle: Vector  # h spin [rad], along the axis
    rate: Vector   # spin, by the same unit of time
    lever: Vector  # from the point that it turns about to the state's origin [m]
    whole: tuple   # Q - 1, its three rows; 1 is taken off for the sake of rounding
    rest: tuple    # P - 1
    shift: Vector  # (Q - 1) lever [m]

    @classmethod
    def of(cls, mesh: Mesh, spin: Vector, lever: Vector, dt: float, force_time: float) -> 'Turn':
        """
        Return the turn of a step of dt [s] at spin [rad/s].

        lever: see the field; force_time: see Solver.
        """
        if not any(spin):
            return cls.none(mesh.precision)
        number, angle = mesh.number, np.multiply(dt, spin)
        whole, rest = (rotation(-part * angle) - np.eye(3) for part in (1.0, 1.0 - force_time))
        return cls(number(math.hypot(*angle)), number(dt), number(tuple(angle.tolist())),
                   number(tuple(spin)), number(tuple(lever)), *(
                       tuple(number(tuple(row)) for row in rows.tolist())
                       for rows in (whole, rest)),
                   number(tuple((whole @ lever).tolist())))

    @classmethod
    @functools.cache
    def none(cls, precision: str) -> 'Turn':
        """Return the turn of a pole that does not turn, in numbers of a precision."""
        zero = np.dtype(precision).type(0.0)
        zeros = (zero, zero, zero)
        rows = (zeros, zeros, zeros)
        return cls(zero, zero, zeros, zeros, zeros, rows, rows, zeros)


def rotation(turn: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) that turns by a vector (3,) [rad] along its axis (Rodrigues)."""
    x, y, z = turn
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    size = math.hypot(x, y, z)
    # (1 - cos a) / a^2 by the half angle, as the difference would be rounded away.
    sine = math.sin(size) / size if size > 0.0 else 1.0
    half = math.sin(0.5 * size) / (0.5 * size) if size > 0.0 else 1.0
    return np.eye(3) + sine * across + 0.5 * half * half * (across @ across)


@lean_inner_kernel
def in_steps(turn: Turn) -> Turn:
    """Return a turn for velocities in metres per step."""
    return Turn(turn.size, type(turn.size)(1.0), turn.angle, turn.angle, turn.lever, turn.whole,
                turn.rest, turn.shift)


@lean_inner_kernel
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@lean_inner_kernel
def _times(rows, a):
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = rows
    return (xx * a[0] + xy * a[1] + xz * a[2], yx * a[0] + yy * a[1] + yz * a[2],
            zx * a[0] + zy * a[1] + zz * a[2])


@wide_kernel
def turn_nodes(nodes: Nodes, nodes_out: Nodes, turn: Turn, free: np.ndarray, band: Band) -> None:
    """Bring the nodes of a band, which a step took from nodes to nodes_out, to X' and w'."""
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    x_out, y_out, z_out = nodes_out.position
    vx_out, vy_out, vz_out = nodes_out.velocity
    time, rate, (lx, ly, lz), (sx, sy, sz) = turn.time, turn.rate, turn.lever, turn.shift
    first, last, _ = band
    for i in range(first, last):
        mx, my, mz = time * vx[i], time * vy[i], time * vz[i]
        d = x_out[i] - x[i] - mx, y_out[i] - y[i] - my, z_out[i] - z[i] - mz
        c = vx_out[i] - vx[i], vy_out[i] - vy[i], vz_out[i] - vz[i]
        # The way of a node without forces, h u, and what the frame's turn takes off velocities.
        gx, gy, gz = _cross(turn.angle, (x[i] + lx, y[i] + ly, z[i] + lz))
        way = mx + gx, my + gy, mz + gz
        ax, ay, az = _cross(rate, way)
        bx, by, bz = _cross(rate, d)
        qx, qy, qz = _times(turn.whole, (x[i] + way[0], y[i] + way[1], z[i] + way[2]))
        px, py, pz = _times(turn.rest, d)
        ux, uy, uz = _times(turn.whole, (vx[i] - ax, vy[i] - ay, vz[i] - az))
        wx, wy, wz = _times(turn.rest, (c[0] - bx, c[1] - by, c[2] - bz))
        # Pins stand still in the frame.
        moves = free[i]
        x_out[i] += moves * (gx + qx + px + sx)
        y_out[i] += moves * (gy + qy + py + sy)
        z_out[i] += moves * (gz + qz + pz + sz)
        vx_out[i] += moves * (ux + wx - ax - bx)
        vy_out[i] += moves * (uy + wy - ay - by)
        vz_out[i] += moves * (uz + wz - az - bz)
