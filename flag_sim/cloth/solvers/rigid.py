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

from flag_sim.cloth.records import Band, Field, Vector
from flag_sim.cloth.state import State
from flag_sim.jit.kernels import inner_kernel
import numpy as np

STRAIGHTNESS_TOLERANCE = 1e-5
"""How far pins may lie from a line, over its length, for the cloth to turn about it."""

FIXED, HINGED, FREE = 0, 1, 2


class Freedom(NamedTuple):
    """Which rigid motions a cloth is free to make."""

    kind: int      # FIXED, HINGED or FREE
    point: Vector  # of the hinge [m], measured as positions
    axis: Vector   # its direction, a unit vector


class Body(NamedTuple):
    """What inner forces leave alone: masses [kg], and which rigid motions are free."""

    mass: np.ndarray
    inverse_mass: np.ndarray
    freedom: Freedom


class Rigid(NamedTuple):
    """A rigid field: shift + turn x (position - center)."""

    center: Vector  # [m], measured as positions
    shift: Vector   # in the field's unit
    turn: Vector    # the same per metre


class Inertia(NamedTuple):
    """What a body sets against rigid motion, where its nodes are."""

    mass: float      # of the whole body [kg]
    center: Vector   # of its mass, or the hinge's point [m]
    moments: tuple   # about the center: xx, yy, zz, xy, yz, zx [kg m2]


def freedom_of(state: State) -> Freedom:
    """Return the Freedom of a State, which its pins leave it."""
    none = (0.0, 0.0, 0.0)
    if not state.mesh.pinned:
        return Freedom(FREE, none, none)
    pins = np.stack([state.mesh.grid(axis)[:, 0] for axis in state.position], axis=-1)
    pins = pins.astype(np.float64)
    way = pins[-1] - pins[0]
    length = math.sqrt(way @ way)
    if not length > 0.0:
        return Freedom(FIXED, none, none)
    axis = way / length
    away = np.cross(pins - pins[0], axis)
    kind = HINGED if np.abs(away).max() <= STRAIGHTNESS_TOLERANCE * length else FIXED
    return Freedom(kind, tuple(pins[0].tolist()), tuple(axis.tolist()))


@inner_kernel
def _mass_center(position, mass, freedom, band):
    """Return (m, center): the mass [kg] and its center, or the hinge's point [m]."""
    x, y, z = position
    first, last, _ = band
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


@inner_kernel
def _moments(position, mass, center, band):
    """Return the moments of inertia about the center: xx, yy, zz, xy, yz, zx [kg m2]."""
    x, y, z = position
    cx, cy, cz = center
    first, last, _ = band
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


@inner_kernel
def inertia_of(position: Field, body: Body, band: Band) -> Inertia:
    """Return the Inertia of a body whose nodes are at positions."""
    mass, center = _mass_center(position, body.mass, body.freedom, band)
    return Inertia(mass, center, _moments(position, body.mass, center, band))


@inner_kernel
def _momenta(position, field, mass, center, band):
    """Return the momentum and angular momentum about the center of a field, (x, y, z) each."""
    x, y, z = position
    u, v, w = field
    cx, cy, cz = center
    first, last, _ = band
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
def _rigid_part(momentum, angular, freedom, inertia):
    """Return (shift, turn) of the rigid field with this momentum and angular momentum."""
    total, _, (xx, yy, zz, xy, yz, zx) = inertia
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
def add_rigid(position: Field, inverse_mass: np.ndarray, rigid: Rigid, field: Field,
              band: Band) -> None:
    """Add a rigid field to a field, but at pins and ghosts."""
    x, y, z = position
    u, v, w = field
    (cx, cy, cz), (px, py, pz), (wx, wy, wz) = rigid.center, rigid.shift, rigid.turn
    first, last, _ = band
    for i in range(first, last):
        if inverse_mass[i] > 0.0:
            rx, ry, rz = x[i] - cx, y[i] - cy, z[i] - cz
            u[i] += px + wy * rz - wz * ry
            v[i] += py + wz * rx - wx * rz
            w[i] += pz + wx * ry - wy * rx


@inner_kernel
def rigid_of(position: Field, field: Field, body: Body, inertia: Inertia, band: Band) -> Rigid:
    """Return the rigid part of a field."""
    momentum, angular = _momenta(position, field, body.mass, inertia.center, band)
    shift, turn = _rigid_part(momentum, angular, body.freedom, inertia)
    return Rigid(inertia.center, shift, turn)


@inner_kernel
def take_rigid(position: Field, field: Field, body: Body, inertia: Inertia, band: Band) -> None:
    """Take its rigid part from a field."""
    center, (px, py, pz), (wx, wy, wz) = rigid_of(position, field, body, inertia, band)
    back = Rigid(center, (-px, -py, -pz), (-wx, -wy, -wz))
    add_rigid(position, body.inverse_mass, back, field, band)
