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
The wind on the faces (eq. 1.3), spread over their nodes (eq. 1.4).

Each cell is cut into an upper face, whose right angle is the cell's upper hoist corner, and a
lower face opposite. Where the source text has F = n (n . w), a face here feels the drag of the
air that moves against it: F = 1/2 rho C_d A |u_n| u_n n, where u = w - v is the wind relative to
the face and u_n = u . n.

The node in the right angle bears half of the face's force and the others a quarter each; the
face's velocity v is the mean of the nodes' velocities with the same shares. So the power of the
force is F . v, and a flat sheet square to the wind is accelerated alike in all its nodes, corners
included, because the shares are those of the face's mass.
"""
from typing import NamedTuple

from flag_sim.cloth.drag import divisor, drag_factor, SEED
from flag_sim.cloth.mesh import LEAST_AREA2
from flag_sim.cloth.records import Band, Field, NEXT, Nodes, Vector, Weights
from flag_sim.jit.kernels import inner_kernel, lean_kernel, wide_kernel
import numpy as np


class Wind(NamedTuple):
    """The wind and the numbers that its force on a face follows from."""

    velocity: Vector  # [m/s]
    drag: float       # of Air [kg/m3]; zero: no wind
    drag_rate: float  # the same over a face's mass [1/m3]
    law: int          # drag.QUADRATIC, LINEAR or SEED
    order: int        # of the method, to which the drag is kept from overshooting
    spin: Vector      # of the frame of reference, against whose air faces turn [rad/s]


@inner_kernel
def _force_per_area(flux, area, wind, dt):
    """
    Return what times the area vector [m2] is the force on a face [Pa], given the flux [m3/s].

    dt: the step [s] in which the force may not overshoot; see drag.
    """
    ax, ay, az = area
    area2 = max(ax * ax + ay * ay + az * az, type(flux)(LEAST_AREA2))
    s, rate = drag_factor(flux, area2, wind.law)
    return wind.drag * s * flux / (area2 * divisor(dt * wind.drag_rate * rate, wind.order))


@inner_kernel
def turning_flux(position: Field, corners: tuple, spin: Vector, area: Vector) -> float:
    """
    Return the flux [m3/s] through a face that its frame's spin alone would make in still air.

    corners: its nodes, the right angle first; area: its area vector [m2].
    """
    x, y, z = position
    i, j, k = corners
    half, quarter = x.dtype.type(0.5), x.dtype.type(0.25)
    cx = half * x[i] + quarter * (x[j] + x[k])
    cy = half * y[i] + quarter * (y[j] + y[k])
    cz = half * z[i] + quarter * (z[j] + z[k])
    sx, sy, sz = spin
    return ((sy * cz - sz * cy) * area[0] + (sz * cx - sx * cz) * area[1]
            + (sx * cy - sy * cx) * area[2])


@lean_kernel
def set_face_forces(nodes: Nodes, wind: Wind, dt: float, weights: Weights, faces: tuple,
                    band: Band) -> None:
    """
    Fill half the wind's force [N] on the upper and the lower face of each cell (eq. 1.3).

    dt: the step that the drag is taken implicitly over [s], zero for the momentary force. faces:
    six flat arrays, x y z of the upper and of the lower faces.
    """
    sx, sy, sz = wind.spin
    if sx != 0.0 or sy != 0.0 or sz != 0.0:
        _set_forces(nodes, wind, wind.spin, dt, weights, faces, band)
    else:
        _set_forces(nodes, wind, None, dt, weights, faces, band)


@wide_kernel
def _set_forces(nodes, wind, spin, dt, weights, faces, band):
    """Fill faces; spin: None where there is none, for which numba compiles a loop of its own."""
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    wx, wy, wz = wind.velocity
    # Equation 1.3 as published uses the wind alone, not the cloth's own velocity.
    number = type(dt)
    half, quarter = number(0.5), number(0.0 if wind.law == SEED else 0.25)
    own = quarter + quarter
    upper_x, upper_y, upper_z, lower_x, lower_y, lower_z = faces
    first, last, stride = band
    for i in range(first, last):
        e, s, d = i + NEXT, i + stride, i + stride + NEXT
        share = half * weights.cell[i]
        # Velocity of the side that both faces have: a quarter of each of its ends.
        sx = quarter * (vx[e] + vx[s])
        sy = quarter * (vy[e] + vy[s])
        sz = quarter * (vz[e] + vz[s])

        px, py, pz = x[e] - x[i], y[e] - y[i], z[e] - z[i]
        qx, qy, qz = x[s] - x[i], y[s] - y[i], z[s] - z[i]
        ax, ay, az = (half * (py * qz - pz * qy), half * (pz * qx - px * qz),
                      half * (px * qy - py * qx))
        flux = ((wx - sx - own * vx[i]) * ax + (wy - sy - own * vy[i]) * ay
                + (wz - sz - own * vz[i]) * az)
        if spin is not None:
            flux -= turning_flux(nodes.position, (i, e, s), spin, (ax, ay, az))
        f = share * _force_per_area(flux, (ax, ay, az), wind, dt)
        upper_x[i], upper_y[i], upper_z[i] = f * ax, f * ay, f * az

        px, py, pz = x[s] - x[d], y[s] - y[d], z[s] - z[d]
        qx, qy, qz = x[e] - x[d], y[e] - y[d], z[e] - z[d]
        ax, ay, az = (half * (py * qz - pz * qy), half * (pz * qx - px * qz),
                      half * (px * qy - py * qx))
        flux = ((wx - sx - own * vx[d]) * ax + (wy - sy - own * vy[d]) * ay
                + (wz - sz - own * vz[d]) * az)
        if spin is not None:
            flux -= turning_flux(nodes.position, (d, s, e), spin, (ax, ay, az))
        f = share * _force_per_area(flux, (ax, ay, az), wind, dt)
        lower_x[i], lower_y[i], lower_z[i] = f * ax, f * ay, f * az


@inner_kernel
def node_wind_force(upper: np.ndarray, lower: np.ndarray, i: np.uint64,
                    stride: np.uint64) -> float:
    """
    Return the force [N] of the six faces that meet in node i along one axis (eq. 1.4).

    upper, lower: half the force on the faces of each cell along that axis.
    """
    half = upper.dtype.type(0.5)
    w, n = i - NEXT, i - stride
    return upper[i] + lower[n - NEXT] + half * (upper[w] + lower[w] + upper[n] + lower[n])


@lean_kernel
def add_wind_forces(faces: tuple, force: Field, band: Band) -> None:
    """Add to each node's force [N] that of the six faces that meet in it (eq. 1.4)."""
    for axis in range(3):
        _add_along(faces[axis], faces[axis + 3], force[axis], band)


@wide_kernel
def _add_along(upper, lower, f, band):
    first, last, stride = band
    for i in range(first, last):
        f[i] += node_wind_force(upper, lower, i, stride)
