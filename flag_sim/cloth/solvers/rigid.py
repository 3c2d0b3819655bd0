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
from flag_sim.cloth.solvers.sums import (
    begin_sums, end_sums, LANES, segments_of, Sums, total)
from flag_sim.cloth.state import State
from flag_sim.jit.kernels import inner_kernel, shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait
import numpy as np

STRAIGHTNESS_TOLERANCE = 1e-5
"""How far pins may lie from a line, over its length, for the cloth to turn about it."""

FIXED, HINGED, FREE = 0, 1, 2

MASS, MOMENTS, MOMENTA = 0, 4, 10
"""Which sums are whose: of mass and center, of inertia, of three fields' momenta."""
SUMS = MOMENTA + 18
"""How many there are."""
WIDTH, TWO, THREE, FOUR, FIVE = (np.uint64(LANES * n) for n in range(1, 6))
"""From the lanes of a sum to those of the following ones."""


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


@wide_kernel
def _add_mass_center(position, mass, lanes, segment):
    """Add to a segment's sums: the mass [kg], and that times x, y and z."""
    x, y, z = position
    first, last, _, at = segment
    for start in range(first, last, WIDTH):
        for i in range(start, min(start + WIDTH, last)):
            n, m = at + (i - start), np.float64(mass[i])
            lanes[n] += m
            lanes[n + WIDTH] += m * x[i]
            lanes[n + TWO] += m * y[i]
            lanes[n + THREE] += m * z[i]


@wide_kernel
def _add_moments(position, mass, center, lanes, segment):
    """Add to a segment's sums: moments of inertia, xx, yy, zz, xy, yz, zx [kg m2]."""
    x, y, z = position
    cx, cy, cz = center
    first, last, _, at = segment
    for start in range(first, last, WIDTH):
        for i in range(start, min(start + WIDTH, last)):
            n, m = at + (i - start), np.float64(mass[i])
            rx, ry, rz = x[i] - cx, y[i] - cy, z[i] - cz
            lanes[n] += m * (ry * ry + rz * rz)
            lanes[n + WIDTH] += m * (rz * rz + rx * rx)
            lanes[n + TWO] += m * (rx * rx + ry * ry)
            lanes[n + THREE] -= m * rx * ry
            lanes[n + FOUR] -= m * ry * rz
            lanes[n + FIVE] -= m * rz * rx


@shared_kernel
def inertia_of(position: Field, body: Body, sums: Sums, bands: tuple[Band, Band],
               barrier: np.ndarray) -> Inertia:
    """
    Return the Inertia of a body whose nodes are at positions.

    bands: what a thread sums, and all nodes. All threads of the barrier call it together.
    """
    band, whole = bands
    for number in range(*segments_of(band, whole)):
        segment = begin_sums(sums, MASS, 4, number, whole)
        _add_mass_center(position, body.mass, sums.lanes, segment)
        end_sums(sums, MASS, 4, number)
    wait(barrier)
    m, center = total(sums, MASS, whole), body.freedom.point
    if body.freedom.kind == FREE:
        center = (total(sums, MASS + 1, whole) / m, total(sums, MASS + 2, whole) / m,
                  total(sums, MASS + 3, whole) / m)
    for number in range(*segments_of(band, whole)):
        segment = begin_sums(sums, MOMENTS, 6, number, whole)
        _add_moments(position, body.mass, center, sums.lanes, segment)
        end_sums(sums, MOMENTS, 6, number)
    wait(barrier)
    return Inertia(m, center, (
        total(sums, MOMENTS, whole), total(sums, MOMENTS + 1, whole),
        total(sums, MOMENTS + 2, whole), total(sums, MOMENTS + 3, whole),
        total(sums, MOMENTS + 4, whole), total(sums, MOMENTS + 5, whole)))


@wide_kernel
def _add_momenta(position, field, mass, center, lanes, segment):
    """Add to a segment's sums: momentum and angular momentum about the center of a field."""
    x, y, z = position
    u, v, w = field
    cx, cy, cz = center
    first, last, _, at = segment
    for start in range(first, last, WIDTH):
        for i in range(start, min(start + WIDTH, last)):
            n, m = at + (i - start), np.float64(mass[i])
            rx, ry, rz = x[i] - cx, y[i] - cy, z[i] - cz
            mu, mv, mw = m * u[i], m * v[i], m * w[i]
            lanes[n] += mu
            lanes[n + WIDTH] += mv
            lanes[n + TWO] += mw
            lanes[n + THREE] += ry * mw - rz * mv
            lanes[n + FOUR] += rz * mu - rx * mw
            lanes[n + FIVE] += rx * mv - ry * mu


@inner_kernel
def _rigid_part(sums, at, freedom, inertia, whole):
    """Return the rigid field with the momentum and angular momentum of the sums from `at` on."""
    mass, center, (xx, yy, zz, xy, yz, zx) = inertia
    lx, ly, lz = (total(sums, at + 3, whole), total(sums, at + 4, whole),
                  total(sums, at + 5, whole))
    if freedom.kind == FREE:
        px, py, pz = (total(sums, at, whole), total(sums, at + 1, whole),
                      total(sums, at + 2, whole))
        # The inverse of a symmetric matrix, by its adjugate; none where all mass is on a line.
        a, b, c = yy * zz - yz * yz, zx * yz - xy * zz, xy * yz - zx * yy
        d, e, f = xx * zz - zx * zx, xy * zx - xx * yz, xx * yy - xy * xy
        whole = xx * a + xy * b + zx * c
        scale = 1.0 / whole if whole > 1e-12 * (xx + yy + zz)**3 else 0.0
        return Rigid(center, (px / mass, py / mass, pz / mass),
                     (scale * (a * lx + b * ly + c * lz), scale * (b * lx + d * ly + e * lz),
                      scale * (c * lx + e * ly + f * lz)))
    if freedom.kind == HINGED:
        ax, ay, az = freedom.axis
        about = (ax * (xx * ax + xy * ay + zx * az) + ay * (xy * ax + yy * ay + yz * az)
                 + az * (zx * ax + yz * ay + zz * az))
        rate = (ax * lx + ay * ly + az * lz) / about if about > 0.0 else 0.0
        return Rigid(center, (0.0, 0.0, 0.0), (rate * ax, rate * ay, rate * az))
    return Rigid(center, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@wide_kernel
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


@shared_kernel
def rigid_of(position: Field, fields: tuple, body: Body, inertia: Inertia, sums: Sums,
             bands: tuple[Band, Band], barrier: np.ndarray) -> tuple:
    """
    Return the rigid parts of three fields.

    bands: what a thread sums, and all nodes. All threads of the barrier call it together.
    """
    band, whole = bands
    for number in range(*segments_of(band, whole)):
        for one in range(3):
            segment = begin_sums(sums, MOMENTA + 6 * one, 6, number, whole)
            _add_momenta(position, fields[one], body.mass, inertia.center, sums.lanes, segment)
            end_sums(sums, MOMENTA + 6 * one, 6, number)
    wait(barrier)
    return (_rigid_part(sums, MOMENTA, body.freedom, inertia, whole),
            _rigid_part(sums, MOMENTA + 6, body.freedom, inertia, whole),
            _rigid_part(sums, MOMENTA + 12, body.freedom, inertia, whole))


@inner_kernel
def take_rigid(position: Field, inverse_mass: np.ndarray, rigid: Rigid, field: Field,
               band: Band) -> None:
    """Take a rigid field from a field, but at pins and ghosts."""
    center, (px, py, pz), (wx, wy, wz) = rigid
    back = Rigid(center, (-px, -py, -pz), (-wx, -wy, -wz))
    add_rigid(position, inverse_mass, back, field, band)
