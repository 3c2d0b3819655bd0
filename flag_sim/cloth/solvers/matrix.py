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

from flag_sim.cloth.aerodynamics import add_wind_forces, turning_flux, Wind
from flag_sim.cloth.bending import add_bending_forces, set_moments
from flag_sim.cloth.drag import drag_factor
from flag_sim.cloth.forces import Coefficients, Work
from flag_sim.cloth.mesh import LEAST_AREA2, LEAST_LENGTH2
from flag_sim.cloth.records import Band, Field, NEXT, Nodes, Sheet, Weights
from flag_sim.cloth.springs import Springs
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
    def of(cls, fields: tuple) -> 'Matrix':
        """Return a matrix in FIELDS flat fields."""
        return cls(tuple(fields[:4]), tuple(tuple(fields[i:i + 3]) for i in (4, 7, 10, 13)),
                   tuple(fields[16:22]))


class System(NamedTuple):
    """The matrix with all that its products need."""

    matrix: Matrix
    sheet: Sheet
    coefficients: Coefficients
    work: Work  # overwritten by each product
    dt: float   # the step h [s]


@inner_kernel
def _spring_terms(position, i, j, weight, stiff, damp, rest):
    """
    Return across and along of the spring from i to j, with a weight of h^2 k and h c.

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
    return tension, (size * dx, size * dy, size * dz)


@inner_kernel
def set_springs(position: Field, weights: Weights, springs: Springs, matrix: Matrix, dt: float,
                band: Band) -> None:
    """Fill the springs' part of the matrix at positions."""
    (k_a, k_d, k_x), (c_a, c_d, c_x), (rest_a, rest_d, rest_x) = springs
    k_a, k_d, k_x = dt * dt * k_a, dt * dt * k_d, dt * dt * k_x
    c_a, c_d, c_x = dt * c_a, dt * c_d, dt * c_x
    ta, td, tr, tf = matrix.across
    (ax, ay, az), (dx, dy, dz), (rx, ry, rz), (fx, fy, fz) = matrix.along
    first, last, stride = band
    for i in range(first, last):
        e, s, d = i + NEXT, i + stride, i + stride + NEXT
        ta[i], (ax[i], ay[i], az[i]) = _spring_terms(
            position, i, e, weights.across[i], k_a, c_a, rest_a)
        td[i], (dx[i], dy[i], dz[i]) = _spring_terms(
            position, i, s, weights.down[i], k_d, c_d, rest_d)
        tr[i], (rx[i], ry[i], rz[i]) = _spring_terms(
            position, s, e, weights.cell[i], k_x, c_x, rest_x)
        tf[i], (fx[i], fy[i], fz[i]) = _spring_terms(
            position, i, d, weights.cell[i], k_x, c_x, rest_x)


@inner_kernel
def _face_terms(nodes, corners, wind, drag, weight):
    """Return the vector of a face, its right angle in the first corner; drag: h times Air's."""
    number = type(drag)
    half, quarter = number(0.5), number(0.25)
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    wx, wy, wz = wind.velocity
    i, j, k = corners
    px, py, pz = x[j] - x[i], y[j] - y[i], z[j] - z[i]
    qx, qy, qz = x[k] - x[i], y[k] - y[i], z[k] - z[i]
    ax, ay, az = (half * (py * qz - pz * qy), half * (pz * qx - px * qz),
                  half * (px * qy - py * qx))
    area2 = max(ax * ax + ay * ay + az * az, number(LEAST_AREA2))
    flux = ((wx - half * vx[i] - quarter * (vx[j] + vx[k])) * ax
            + (wy - half * vy[i] - quarter * (vy[j] + vy[k])) * ay
            + (wz - half * vz[i] - quarter * (vz[j] + vz[k])) * az)
    flux -= turning_flux(nodes.position, corners, wind.spin, (ax, ay, az))
    _, rate = drag_factor(flux, area2, wind.law)
    size = math.sqrt(weight * drag * rate / area2)
    return size * ax, size * ay, size * az


@inner_kernel
def set_faces(nodes: Nodes, wind: Wind, weights: Weights, matrix: Matrix, dt: float,
              band: Band) -> None:
    """Fill the wind's part of the matrix: the derivative of the drag laws."""
    ux, uy, uz, lx, ly, lz = matrix.faces
    drag = dt * wind.drag
    first, last, stride = band
    for i in range(first, last):
        e, s, d = i + NEXT, i + stride, i + stride + NEXT
        weight = weights.cell[i]
        ux[i], uy[i], uz[i] = _face_terms(nodes, (i, e, s), wind, drag, weight)
        lx[i], ly[i], lz[i] = _face_terms(nodes, (d, s, e), wind, drag, weight)


@inner_kernel
def _multiply_springs(matrix, mass, inertia, field, product, band):
    """Set the product to that of masses and springs; each node gathers from the eight it has."""
    x, y, z = field
    ox, oy, oz = product
    ta, td, tr, tf = matrix.across
    (ax, ay, az), (dx, dy, dz), (rx, ry, rz), (fx, fy, fz) = matrix.along
    first, last, stride = band
    for i in range(first, last):
        e, w, s, n = i + NEXT, i - NEXT, i + stride, i - stride
        se, nw, sw, ne = s + NEXT, n - NEXT, s - NEXT, n + NEXT
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
def _set_face_drag(matrix, field, faces, band):
    """Fill half of what each face answers to the change of its velocity by the field."""
    x, y, z = field
    ux, uy, uz, lx, ly, lz = matrix.faces
    fux, fuy, fuz, flx, fly, flz = faces
    half, quarter = x.dtype.type(0.5), x.dtype.type(0.25)
    first, last, stride = band
    for i in range(first, last):
        e, s, d = i + NEXT, i + stride, i + stride + NEXT
        # The node in the right angle has half a share in its face's velocity, others a quarter.
        sx, sy, sz = quarter * (x[e] + x[s]), quarter * (y[e] + y[s]), quarter * (z[e] + z[s])
        g = half * ((sx + half * x[i]) * ux[i] + (sy + half * y[i]) * uy[i]
                    + (sz + half * z[i]) * uz[i])
        fux[i], fuy[i], fuz[i] = g * ux[i], g * uy[i], g * uz[i]
        g = half * ((sx + half * x[d]) * lx[i] + (sy + half * y[d]) * ly[i]
                    + (sz + half * z[d]) * lz[i])
        flx[i], fly[i], flz[i] = g * lx[i], g * ly[i], g * lz[i]


@inner_kernel
def add_drag(matrix: Matrix, field: Field, faces: tuple, product: Field, band: Band) -> None:
    """Add h G times a field to a product, G of the wind's drag; faces are overwritten."""
    _set_face_drag(matrix, field, faces, band)
    add_wind_forces(faces, product, band)


@inner_kernel
def multiply(system: System, field: Field, product: Field, band: Band) -> None:
    """Set the product of A and a field that is zero at pins and ghosts."""
    matrix, sheet, coefficients, work, dt = system
    inertia = type(dt)(1.0) + dt * coefficients.node_damping
    _multiply_springs(matrix, sheet.mass, inertia, field, product, band)
    if max(coefficients.bend) > 0.0:
        # Bending adds its force; its Hessian is minus that.
        b_across, b_down, b_twist = coefficients.bend
        bend = (-dt * dt * b_across, -dt * dt * b_down, -dt * dt * b_twist)
        set_moments(field, sheet.weights, bend, work.moments, band)
        add_bending_forces(work.moments, product, band)
    if coefficients.wind.drag > 0.0:
        add_drag(matrix, field, work.faces, product, band)
