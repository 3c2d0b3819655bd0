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
The wind on the faces (1.3), shared out to the nodes (1.4).

Each cell is cut into an upper face, whose right angle is the cell's upper hoist corner, and a
lower face opposite. Where the source text has F = n (n . w), a face here feels the pressure of
the air that moves against it: F = rho C_d / 2 A |u_n| u_n n, u = w - v its wind, u_n = u . n.

The node in the right angle bears half of the face's force and the others a quarter each; the
face's velocity v is the mean of the nodes' with the same shares. So the power of the force is
F . v, and a flat sheet square to the wind is accelerated alike in all its nodes, corners
included, because the shares are those of the face's mass.
"""
from flag_sim.cloth.mesh import LEAST_AREA2, ONE
from flag_sim.cloth.pressure import divisor, pressure, SEED
from flag_sim.jit.kernels import inner_kernel, kernel, wide_kernel


@inner_kernel
def _push(flux, ax, ay, az, drag, hold, law, order):
    """
    Return the factor of the area vector a in the force on a face, given the flux u . a [m3/s].

    drag: of Air [kg/m3]. hold: the step times drag, over the face's mass [s/m3]. See pressure.
    """
    area2 = max(ax * ax + ay * ay + az * az, type(flux)(LEAST_AREA2))
    s, rate = pressure(flux, area2, law)
    return drag * s * flux / (area2 * divisor(hold * rate, order))


@wide_kernel
def wind_on_faces(position, velocity, wind, drag, hold, law, order, weights, faces, span):
    """
    Fill half the wind's force [N] on the upper and the lower face of each cell (1.3).

    wind: (wx, wy, wz) [m/s]. drag, hold, law, order: see _push. faces: six flat arrays, x y z
    of the upper and of the lower faces.
    """
    x, y, z = position
    vx, vy, vz = velocity
    wx, wy, wz = wind
    # The letter of 1.3 knows the wind alone, not the cloth's own velocity.
    number = type(drag)
    half, quarter = number(0.5), number(0.0 if law == SEED else 0.25)
    own = quarter + quarter
    upper_x, upper_y, upper_z, lower_x, lower_y, lower_z = faces
    first, last, stride = span
    for i in range(first, last):
        e, s, d = i + ONE, i + stride, i + stride + ONE
        share = half * weights.cell[i]
        # Velocity of the side that both faces share: a quarter of each of its ends.
        sx = quarter * (vx[e] + vx[s])
        sy = quarter * (vy[e] + vy[s])
        sz = quarter * (vz[e] + vz[s])

        px, py, pz = x[e] - x[i], y[e] - y[i], z[e] - z[i]
        qx, qy, qz = x[s] - x[i], y[s] - y[i], z[s] - z[i]
        ax, ay, az = (half * (py * qz - pz * qy), half * (pz * qx - px * qz),
                      half * (px * qy - py * qx))
        flux = ((wx - sx - own * vx[i]) * ax + (wy - sy - own * vy[i]) * ay
                + (wz - sz - own * vz[i]) * az)
        f = share * _push(flux, ax, ay, az, drag, hold, law, order)
        upper_x[i], upper_y[i], upper_z[i] = f * ax, f * ay, f * az

        px, py, pz = x[s] - x[d], y[s] - y[d], z[s] - z[d]
        qx, qy, qz = x[e] - x[d], y[e] - y[d], z[e] - z[d]
        ax, ay, az = (half * (py * qz - pz * qy), half * (pz * qx - px * qz),
                      half * (px * qy - py * qx))
        flux = ((wx - sx - own * vx[d]) * ax + (wy - sy - own * vy[d]) * ay
                + (wz - sz - own * vz[d]) * az)
        f = share * _push(flux, ax, ay, az, drag, hold, law, order)
        lower_x[i], lower_y[i], lower_z[i] = f * ax, f * ay, f * az


@inner_kernel
def share(upper, upper_w, upper_n, lower_w, lower_n, lower_nw):
    """Return a node's share [N] of the six faces that meet in it, along one axis (1.4)."""
    half = type(upper)(0.5)
    return upper + lower_nw + half * (upper_w + lower_w + upper_n + lower_n)


@kernel
def add_faces(faces, force, span):
    """Add to each node's force [N] its share of the six faces that meet in it (1.4)."""
    for axis in range(3):
        _add_along(faces[axis], faces[axis + 3], force[axis], span)


@wide_kernel
def _add_along(upper, lower, f, span):
    first, last, stride = span
    for i in range(first, last):
        w, n = i - ONE, i - stride
        f[i] += share(upper[i], upper[w], upper[n], lower[w], lower[n], lower[n - ONE])
