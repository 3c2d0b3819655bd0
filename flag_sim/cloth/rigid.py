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
Rigid motion of the cloth, which inner forces can neither give nor take.

A free cloth may shift and turn; one whose pins lie on a line, as on a pole, may turn about it; one
that is pinned otherwise can do neither.
"""
import math
from typing import NamedTuple

from flag_sim.jit.kernels import inner_kernel
import numpy as np

SUMS = {'contract', 'reassoc'}
"""In vectors, and so in another order than written; the order is the same in every run."""

STRAIGHT = 1e-5
"""How far from a line, over its length, pins may lie so that the cloth turns about it."""

HELD, HINGED, FREE = 0, 1, 2


class Freedom(NamedTuple):
    """Which rigid motions a cloth is free to make."""

    kind: int     # HELD, HINGED or FREE
    point: tuple  # of the hinge, (x, y, z) [m], measured as positions
    axis: tuple   # its direction, a unit vector


class Body(NamedTuple):
    """What inner forces leave alone: masses [kg], and which rigid motions are free."""

    mass: np.ndarray
    inverse_mass: np.ndarray
    freedom: Freedom


class Rigid(NamedTuple):
    """A rigid field: shift + turn x (position - center)."""

    center: tuple
    shift: tuple
    turn: tuple


def freedom_of(state):
    """Return the Freedom of a State, which its pins leave it."""
    none = (0.0, 0.0, 0.0)
    if not state.mesh.pinned:
        return Freedom(FREE, none, none)
    pins = np.stack([state.mesh.grid(axis)[:, 0] for axis in state.position], axis=-1)
    pins = pins.astype(np.float64)
    way = pins[-1] - pins[0]
    length = math.sqrt(way @ way)
    if not length > 0.0:
        return Freedom(HELD, none, none)
    axis = way / length
    away = np.cross(pins - pins[0], axis)
    kind = HINGED if np.abs(away).max() <= STRAIGHT * length else HELD
    return Freedom(kind, tuple(pins[0].tolist()), tuple(axis.tolist()))


@inner_kernel(fastmath=SUMS)
def mass_center(position, mass, freedom, span):
    """Return (m, center): the mass [kg] and its center, or the hinge's point [m]."""
    x, y, z = position
    first, last, _ = span
    m, cx, cy, cz = 0.0, 0.0, 0.0, 0.0
    for i in range(first, last):
        one = np.float64(mass[i])
        m += one
        cx += one * x[i]
        cy += one * y[i]
        cz += one * z[i]
    if freedom.kind == FREE:
        return m, (cx / m, cy / m, cz / m)
    return m, freedom.point


@inner_kernel(fastmath=SUMS)
def inertia(position, mass, center, span):
    """Return the moments of inertia about the center: xx, yy, zz, xy, yz, zx [kg m2]."""
    x, y, z = position
    cx, cy, cz = center
    first, last, _ = span
    xx, yy, zz, xy, yz, zx = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(first, last):
        m = np.float64(mass[i])
        rx, ry, rz = x[i] - cx, y[i] - cy, z[i] - cz
        xx += m * (ry * ry + rz * rz)
        yy += m * (rz * rz + rx * rx)
        zz += m * (rx * rx + ry * ry)
        xy -= m * rx * ry
        yz -= m * ry * rz
        zx -= m * rz * rx
    return xx, yy, zz, xy, yz, zx


@inner_kernel(fastmath=SUMS)
def momenta(position, field, mass, center, span):
    """Return the momentum and angular momentum about the center of a field, (x, y, z) each."""
    x, y, z = position
    u, v, w = field
    cx, cy, cz = center
    first, last, _ = span
    px, py, pz, lx, ly, lz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(first, last):
        m = np.float64(mass[i])
        rx, ry, rz = x[i] - cx, y[i] - cy, z[i] - cz
        mu, mv, mw = m * u[i], m * v[i], m * w[i]
        px += mu
        py += mv
        pz += mw
        lx += ry * mw - rz * mv
        ly += rz * mu - rx * mw
        lz += rx * mv - ry * mu
    return (px, py, pz), (lx, ly, lz)


@inner_kernel
def rigid_part(momentum, angular, freedom, total, moments):
    """Return (shift, turn) of the rigid field with this momentum and angular momentum."""
    xx, yy, zz, xy, yz, zx = moments
    lx, ly, lz = angular
    if freedom.kind == FREE:
        px, py, pz = momentum
        # The inverse of a symmetric matrix, by its adjugate; none where all mass is on a line.
        a, b, c = yy * zz - yz * yz, zx * yz - xy * zz, xy * yz - zx * yy
        d, e, f = xx * zz - zx * zx, xy * zx - xx * yz, xx * yy - xy * xy
        whole = xx * a + xy * b + zx * c
        scale = 1.0 / whole if whole > 1e-12 * (xx + yy + zz)**3 else 0.0
        return ((px / total, py / total, pz / total),
                (scale * (a * lx + b * ly + c * lz), scale * (b * lx + d * ly + e * lz),
                 scale * (c * lx + e * ly + f * lz)))
    if freedom.kind == HINGED:
        ax, ay, az = freedom.axis
        about = (ax * (xx * ax + xy * ay + zx * az) + ay * (xy * ax + yy * ay + yz * az)
                 + az * (zx * ax + yz * ay + zz * az))
        rate = (ax * lx + ay * ly + az * lz) / about if about > 0.0 else 0.0
        return (0.0, 0.0, 0.0), (rate * ax, rate * ay, rate * az)
    return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@inner_kernel
def add_rigid(position, inverse_mass, rigid, field, span):
    """Add a rigid field to a field, but at pins and ghosts."""
    x, y, z = position
    u, v, w = field
    (cx, cy, cz), (px, py, pz), (wx, wy, wz) = rigid.center, rigid.shift, rigid.turn
    first, last, _ = span
    for i in range(first, last):
        if inverse_mass[i] > 0.0:
            rx, ry, rz = x[i] - cx, y[i] - cy, z[i] - cz
            u[i] += px + wy * rz - wz * ry
            v[i] += py + wz * rx - wx * rz
            w[i] += pz + wx * ry - wy * rx


@inner_kernel
def rigid_of(position, field, body, total, center, moments, span):
    """Return the rigid part of a field; total, center and moments as above."""
    momentum, angular = momenta(position, field, body.mass, center, span)
    shift, turn = rigid_part(momentum, angular, body.freedom, total, moments)
    return Rigid(center, shift, turn)


@inner_kernel
def take_rigid(position, field, body, total, center, moments, span):
    """Take its rigid part from a field."""
    _, (px, py, pz), (wx, wy, wz) = rigid_of(position, field, body, total, center, moments, span)
    back = Rigid(center, (-px, -py, -pz), (-wx, -wy, -wz))
    add_rigid(position, body.inverse_mass, back, field, span)
