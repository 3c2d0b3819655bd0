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
The matrix of backward Euler: what a change of velocity does to the forces over a step.

    A = (1 + h nu) M + h C + h G + h^2 K

with the masses M, the nodes' damping nu, the springs' dashpots C, the wind's drag G, and the
Hessian K of springs and bending. It is never formed: each node gathers its product with a field
from its neighbours. All five terms are symmetric and none is negative, so neither is A.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.aerodynamics import add_faces
from flag_sim.cloth.bending import add_moments, set_moments
from flag_sim.cloth.mesh import LEAST_AREA2, LEAST_LENGTH2, ONE
from flag_sim.cloth.pressure import pressure
from flag_sim.jit.kernels import inner_kernel

FIELDS = 22
"""Flat fields that a Matrix lies in."""


class Matrix(NamedTuple):
    """
    Flat fields that hold A at one state, but for bending, which is the same at all.

    A spring in direction n adds to the force that its ends feel from each other, for a change of
    velocity d between them, across d + (along . d) along; four springs begin at each node. A face
    adds face (face . d) for the change d of its own velocity.
    """

    across: tuple   # h^2 T of the springs across, down, rising, falling [kg]; T: tension
    along: tuple    # sqrt(h^2 (k - T) + h c) n, x y z of each of the same [sqrt(kg)]
    faces: tuple    # sqrt(h dF/du_n) n, x y z of upper, then of lower faces [sqrt(kg)]

    @classmethod
    def of(cls, fields):
        """Return a matrix in FIELDS flat fields."""
        return cls(tuple(fields[:4]), tuple(tuple(fields[i:i + 3]) for i in (4, 7, 10, 13)),
                   tuple(fields[16:22]))


@inner_kernel
def _set_spring(position, i, j, at, weight, stiff, damp, rest, across, along):
    """
    Set what the spring from i to j, with a share of h^2 k and h c, does to its ends.

    The Hessian of k (l - L)^2 / 2 is k n n^T + T (1 - n n^T), T = k (1 - L / l). A spring that is
    pressed together has negative T: it would rather buckle. T is taken to be zero there (Choi and
    Ko, Stable but Responsive Cloth, 2002), else A could be singular or worse.
    """
    x, y, z = position
    dx, dy, dz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    number = type(stiff)
    one, zero = number(1.0), number(0.0)
    inverse = one / math.sqrt(max(dx * dx + dy * dy + dz * dz, number(LEAST_LENGTH2)))
    tension = weight * stiff * max(one - rest * inverse, zero)
    size = math.sqrt(weight * (stiff + damp) - tension) * inverse
    across[at] = tension
    along[0][at], along[1][at], along[2][at] = size * dx, size * dy, size * dz


@inner_kernel
def set_springs(position, weights, spring_k, spring_c, spring_rest, matrix, dt, span):
    """Fill the springs' part of the matrix at positions."""
    k_a, k_d, k_x = dt * dt * spring_k[0], dt * dt * spring_k[1], dt * dt * spring_k[2]
    c_a, c_d, c_x = dt * spring_c[0], dt * spring_c[1], dt * spring_c[2]
    rest_a, rest_d, rest_x = spring_rest
    across, along = matrix.across, matrix.along
    first, last, stride = span
    for i in range(first, last):
        e, s, d = i + ONE, i + stride, i + stride + ONE
        _set_spring(position, i, e, i, weights.across[i], k_a, c_a, rest_a, across[0], along[0])
        _set_spring(position, i, s, i, weights.down[i], k_d, c_d, rest_d, across[1], along[1])
        _set_spring(position, s, e, i, weights.cell[i], k_x, c_x, rest_x, across[2], along[2])
        _set_spring(position, i, d, i, weights.cell[i], k_x, c_x, rest_x, across[3], along[3])


@inner_kernel
def _set_face(position, velocity, wind, i, j, k, at, weight, drag, law, nx, ny, nz):
    """Set what the face with its right angle in i does to its nodes; drag: h times that of Air."""
    number = type(drag)
    half, quarter = number(0.5), number(0.25)
    x, y, z = position
    vx, vy, vz = velocity
    px, py, pz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    qx, qy, qz = x[k] - x[i], y[k] - y[i], z[k] - z[i]
    ax, ay, az = (half * (py * qz - pz * qy), half * (pz * qx - px * qz),
                  half * (px * qy - py * qx))
    area2 = max(ax * ax + ay * ay + az * az, number(LEAST_AREA2))
    flux = ((wind[0] - half * vx[i] - quarter * (vx[j] + vx[k])) * ax
            + (wind[1] - half * vy[i] - quarter * (vy[j] + vy[k])) * ay
            + (wind[2] - half * vz[i] - quarter * (vz[j] + vz[k])) * az)
    _, rate = pressure(flux, area2, law)
    size = math.sqrt(weight * drag * rate / area2)
    nx[at], ny[at], nz[at] = size * ax, size * ay, size * az


@inner_kernel
def set_faces(position, velocity, wind, weights, drag, law, matrix, dt, span):
    """Fill the wind's part of the matrix: the derivative of the laws of `pressure`."""
    ux, uy, uz, lx, ly, lz = matrix.faces
    first, last, stride = span
    for i in range(first, last):
        e, s, d = i + ONE, i + stride, i + stride + ONE
        weight = weights.cell[i]
        _set_face(position, velocity, wind, i, e, s, i, weight, dt * drag, law, ux, uy, uz)
        _set_face(position, velocity, wind, d, s, e, i, weight, dt * drag, law, lx, ly, lz)


@inner_kernel
def _multiply_springs(matrix, mass, inertia, field, product, span):
    """Set the product to that of masses and springs; each node gathers from the eight it has."""
    x, y, z = field
    ox, oy, oz = product
    ta, td, tr, tf = matrix.across
    (ax, ay, az), (dx, dy, dz), (rx, ry, rz), (fx, fy, fz) = matrix.along
    first, last, stride = span
    for i in range(first, last):
        e, w, s, n = i + ONE, i - ONE, i + stride, i - stride
        se, nw, sw, ne = s + ONE, n - ONE, s - ONE, n + ONE
        m = inertia * mass[i]
        px, py, pz = m * x[i], m * y[i], m * z[i]

        ux, uy, uz = x[i] - x[e], y[i] - y[e], z[i] - z[e]
        g, t = ux * ax[i] + uy * ay[i] + uz * az[i], ta[i]
        px, py, pz = px + t * ux + g * ax[i], py + t * uy + g * ay[i], pz + t * uz + g * az[i]
        ux, uy, uz = x[i] - x[w], y[i] - y[w], z[i] - z[w]
        g, t = ux * ax[w] + uy * ay[w] + uz * az[w], ta[w]
        px, py, pz = px + t * ux + g * ax[w], py + t * uy + g * ay[w], pz + t * uz + g * az[w]

        ux, uy, uz = x[i] - x[s], y[i] - y[s], z[i] - z[s]
        g, t = ux * dx[i] + uy * dy[i] + uz * dz[i], td[i]
        px, py, pz = px + t * ux + g * dx[i], py + t * uy + g * dy[i], pz + t * uz + g * dz[i]
        ux, uy, uz = x[i] - x[n], y[i] - y[n], z[i] - z[n]
        g, t = ux * dx[n] + uy * dy[n] + uz * dz[n], td[n]
        px, py, pz = px + t * ux + g * dx[n], py + t * uy + g * dy[n], pz + t * uz + g * dz[n]

        # A diagonal is kept where the upper hoist corner of its cell is.
        ux, uy, uz = x[i] - x[sw], y[i] - y[sw], z[i] - z[sw]
        g, t = ux * rx[w] + uy * ry[w] + uz * rz[w], tr[w]
        px, py, pz = px + t * ux + g * rx[w], py + t * uy + g * ry[w], pz + t * uz + g * rz[w]
        ux, uy, uz = x[i] - x[ne], y[i] - y[ne], z[i] - z[ne]
        g, t = ux * rx[n] + uy * ry[n] + uz * rz[n], tr[n]
        px, py, pz = px + t * ux + g * rx[n], py + t * uy + g * ry[n], pz + t * uz + g * rz[n]

        ux, uy, uz = x[i] - x[se], y[i] - y[se], z[i] - z[se]
        g, t = ux * fx[i] + uy * fy[i] + uz * fz[i], tf[i]
        px, py, pz = px + t * ux + g * fx[i], py + t * uy + g * fy[i], pz + t * uz + g * fz[i]
        ux, uy, uz = x[i] - x[nw], y[i] - y[nw], z[i] - z[nw]
        g, t = ux * fx[nw] + uy * fy[nw] + uz * fz[nw], tf[nw]
        ox[i], oy[i], oz[i] = (px + t * ux + g * fx[nw], py + t * uy + g * fy[nw],
                               pz + t * uz + g * fz[nw])


@inner_kernel
def _push_faces(matrix, field, faces, span):
    """Fill half of what each face answers to the change of its velocity by the field."""
    x, y, z = field
    ux, uy, uz, lx, ly, lz = matrix.faces
    fux, fuy, fuz, flx, fly, flz = faces
    half, quarter = x.dtype.type(0.5), x.dtype.type(0.25)
    first, last, stride = span
    for i in range(first, last):
        e, s, d = i + ONE, i + stride, i + stride + ONE
        # The node in the right angle has half a share in its face's velocity, others a quarter.
        sx, sy, sz = quarter * (x[e] + x[s]), quarter * (y[e] + y[s]), quarter * (z[e] + z[s])
        g = half * ((sx + half * x[i]) * ux[i] + (sy + half * y[i]) * uy[i]
                    + (sz + half * z[i]) * uz[i])
        fux[i], fuy[i], fuz[i] = g * ux[i], g * uy[i], g * uz[i]
        g = half * ((sx + half * x[d]) * lx[i] + (sy + half * y[d]) * ly[i]
                    + (sz + half * z[d]) * lz[i])
        flx[i], fly[i], flz[i] = g * lx[i], g * ly[i], g * lz[i]


@inner_kernel
def add_drag(matrix, field, faces, product, span):
    """Add h G times a field to a product, G of the wind's drag; faces are overwritten."""
    _push_faces(matrix, field, faces, span)
    add_faces(faces, product, span)


@inner_kernel
def multiply(matrix, mass, weights, coefficients, work, field, product, dt, span):
    """Set the product of A and a field that is zero at pins and ghosts; work is overwritten."""
    inertia = type(dt)(1.0) + dt * coefficients.node_damping
    _multiply_springs(matrix, mass, inertia, field, product, span)
    if max(coefficients.bend) > 0.0:
        # Bending adds its force; its Hessian is minus that.
        b_across, b_down, b_twist = coefficients.bend
        bend = (-dt * dt * b_across, -dt * dt * b_down, -dt * dt * b_twist)
        set_moments(field, weights, bend, work.moments, span)
        add_moments(work.moments, product, span)
    if coefficients.drag > 0.0:
        add_drag(matrix, field, work.faces, product, span)
