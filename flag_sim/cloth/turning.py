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
u = w + spin x X in one that does not turn. A method takes each step as if the frame stood still;
afterwards the nodes are brought to where a node that nothing acts on would be: it goes straight
on by h u, and is seen from a frame that has turned by h spin. With Q the turn back by as much,

    X' = Q (X_w + g),    g = h spin x X,
    w' = Q (w_w - spin x (X_w - X + g)),

X_w and w_w the method's. That holds the Coriolis and the centrifugal force, and is exact for any
turn: nothing can grow by it. It is first order in the step, whatever the method's own order.
"""
import functools
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Band, Field, Nodes, Vector
from flag_sim.jit.kernels import lean_inner_kernel, wide_kernel
import numpy as np


class Turn(NamedTuple):
    """The turn of a step of h [s], in the numbers of a mesh and in the pole's axes."""

    size: float    # of the angle [rad]; zero: the pole does not turn
    angle: Vector  # h spin [rad], along the axis
    rate: Vector   # spin, by the unit of time that velocities have
    lever: Vector  # from the point that it turns about to the state's origin [m]
    back: tuple    # Q - 1, its three rows; 1 is taken off for the sake of rounding
    shift: Vector  # (Q - 1) lever [m]

    @classmethod
    def of(cls, mesh: Mesh, spin: Vector, lever: Vector, dt: float) -> 'Turn':
        """Return the turn of a step of dt [s] at spin [rad/s]; lever: see the field."""
        if not any(spin):
            return cls.none(mesh.precision)
        angle = tuple(dt * one for one in spin)
        size = math.hypot(*angle)
        back = rotation(np.negative(angle)) - np.eye(3)
        number = mesh.number
        return cls(number(size), number(angle), number(tuple(spin)), number(tuple(lever)),
                   tuple(number(tuple(row)) for row in back.tolist()),
                   number(tuple((back @ lever).tolist())))


    @classmethod
    @functools.cache
    def none(cls, precision: str) -> 'Turn':
        """Return the turn of a pole that does not turn, in numbers of a precision."""
        zero = np.dtype(precision).type(0.0)
        zeros = (zero, zero, zero)
        return cls(zero, zeros, zeros, zeros, (zeros, zeros, zeros), zeros)


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
    return Turn(turn.size, turn.angle, turn.angle, turn.lever, turn.back, turn.shift)


@wide_kernel
def turn_nodes(position: Field, nodes_out: Nodes, turn: Turn, free: np.ndarray,
               band: Band) -> None:
    """Bring the nodes of a band, which a step took from position to nodes_out, to X' and w'."""
    x, y, z = position
    x_out, y_out, z_out = nodes_out.position
    vx, vy, vz = nodes_out.velocity
    px, py, pz = turn.angle
    rx, ry, rz = turn.rate
    lx, ly, lz = turn.lever
    sx, sy, sz = turn.shift
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = turn.back
    first, last, _ = band
    for i in range(first, last):
        ox, oy, oz = x[i] + lx, y[i] + ly, z[i] + lz
        gx, gy, gz = py * oz - pz * oy, pz * ox - px * oz, px * oy - py * ox
        qx, qy, qz = x_out[i] + gx, y_out[i] + gy, z_out[i] + gz
        dx, dy, dz = qx - x[i], qy - y[i], qz - z[i]
        ux = vx[i] - (ry * dz - rz * dy)
        uy = vy[i] - (rz * dx - rx * dz)
        uz = vz[i] - (rx * dy - ry * dx)
        # Pins stand still in the frame.
        moves = free[i]
        x_out[i] += moves * (gx + (xx * qx + xy * qy + xz * qz) + sx)
        y_out[i] += moves * (gy + (yx * qx + yy * qy + yz * qz) + sy)
        z_out[i] += moves * (gz + (zx * qx + zy * qy + zz * qz) + sz)
        vx[i] = moves * (ux + (xx * ux + xy * uy + xz * uz))
        vy[i] = moves * (uy + (yx * ux + yy * uy + yz * uz))
        vz[i] = moves * (uz + (zx * ux + zy * uy + zz * uz))
