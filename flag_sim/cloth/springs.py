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
The membrane: springs along rows, columns and both diagonals, each with a dashpot (eq. 1.2).

A spring's force is written as tension times the vector between its ends, tension in N/m. One pass
finds the tension of the four springs that begin at a node, a second sums the eight that meet in
it: each root is taken once, and opposite forces are equal to the last bit.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import LEAST_LENGTH2
from flag_sim.cloth.records import Band, Field, NEXT, Nodes, Vector, Weights
from flag_sim.jit.kernels import inner_kernel, wide_kernel
import numba
from numba.extending import overload
import numpy as np


class Springs(NamedTuple):
    """The numbers of the springs: across, down and diagonal, each."""

    k: Vector     # spring constants [N/m]
    c: Vector     # of the dashpots [N s/m]
    rest: Vector  # lengths at rest [m]


def spring_constants(stiffness: float, shear_stiffness: float, dx: float, dy: float) -> Vector:
    """
    Return (across, down, diagonal) spring constants [N/m] of a sheet on cells of dx by dy [m].

    Stretch a cell uniformly and compare its energy with the sheet's: diagonals of
    k_d = G (dx2 + dy2) / (2 dx dy) give C12 = C66 = G at any aspect, and add G dx2/dy2 to C11 and
    G dy2/dx2 to C22. The springs along the threads make that up to C11 = C22 = K + G. They cannot
    be negative: beyond (dx/dy)2 = 1 + K/G, or its inverse, the sheet is too stiff along the cell's
    long side, C11 = G dx2/dy2. With K = 2 G cells may be 1.7 times as long as wide.
    """
    aspect = dx / dy
    across = max(stiffness + shear_stiffness * (1.0 - aspect**2), 0.0) / aspect
    down = max(stiffness + shear_stiffness * (1.0 - aspect**-2), 0.0) * aspect
    diagonal = 0.5 * shear_stiffness * (aspect + 1.0 / aspect)
    return across, down, diagonal


def dashpot_constants(spring_k: Vector, damping: float, mass: float) -> Vector:
    """
    Return the dashpots [N s/m] that damp each spring, between two nodes of mass [kg], by a ratio.

    Two nodes on a spring move against each other with the reduced mass m/2, so the critical
    dashpot is 2 sqrt(k m / 2). On the borders k and m are both halved, and so is the dashpot.
    """
    return tuple(2.0 * damping * math.sqrt(0.5 * k * mass) for k in spring_k)


def _refined(x, estimate):
    """Return 1 / sqrt(x) in the precision of x, from an estimate in float32."""


@overload(_refined, jit_options={'fastmath': {'contract'}})
def _refine(x, estimate):
    if x == numba.float32:
        return lambda x, estimate: estimate

    def refine(x, estimate):
        # Householder's step of third order: 24 bits become all of float64's 53.
        rest = 1.0 - x * estimate * estimate
        return estimate + estimate * (rest * (0.5 + 0.375 * rest))
    return refine


@inner_kernel
def _inverse_lengths(a2, b2, c2, d2):
    """
    Return 1 / sqrt of four squared lengths [1/m].

    Roots and divisions are the slow part, in float64 above all: they are taken in float32 and then
    refined, and one division serves all four.
    """
    tiny = type(a2)(LEAST_LENGTH2)
    a2, b2, c2, d2 = max(a2, tiny), max(b2, tiny), max(c2, tiny), max(d2, tiny)
    a, b = math.sqrt(np.float32(a2)), math.sqrt(np.float32(b2))
    c, d = math.sqrt(np.float32(c2)), math.sqrt(np.float32(d2))
    ab, cd = a * b, c * d
    inverse = np.float32(1.0) / (ab * cd)
    ab, cd = inverse * cd, inverse * ab
    return (_refined(a2, ab * b), _refined(b2, ab * a), _refined(c2, cd * d),
            _refined(d2, cd * c))


@wide_kernel
def elastic_tensions(position: Field, weights: Weights, springs: Springs, tensions: tuple,
                     band: Band) -> None:
    """
    Fill the tensions [N/m] of the springs that begin at each node: k x / l (eq. 1.2).

    tensions: of the springs across, down, rising and falling, four flat arrays. The falling
    diagonal of a cell begins at its upper hoist corner; the rising one, from the corner below to
    the corner after that, is kept there too.
    """
    x, y, z = position
    across, down, rising, falling = tensions
    k_a, k_d, k_x = springs.k
    rest_a, rest_d, rest_x = springs.rest
    kl_a, kl_d, kl_x = k_a * rest_a, k_d * rest_d, k_x * rest_x
    first, last, stride = band
    for i in range(first, last):
        e, s, d = i + NEXT, i + stride, i + stride + NEXT
        ax, ay, az = x[e] - x[i], y[e] - y[i], z[e] - z[i]
        dx, dy, dz = x[s] - x[i], y[s] - y[i], z[s] - z[i]
        rx, ry, rz = x[e] - x[s], y[e] - y[s], z[e] - z[s]
        fx, fy, fz = x[d] - x[i], y[d] - y[i], z[d] - z[i]
        a, b, r, f = _inverse_lengths(ax * ax + ay * ay + az * az, dx * dx + dy * dy + dz * dz,
                                      rx * rx + ry * ry + rz * rz, fx * fx + fy * fy + fz * fz)
        across[i] = weights.across[i] * (k_a - kl_a * a)
        down[i] = weights.down[i] * (k_d - kl_d * b)
        rising[i] = weights.cell[i] * (k_x - kl_x * r)
        falling[i] = weights.cell[i] * (k_x - kl_x * f)


@wide_kernel
def damped_tensions(nodes: Nodes, weights: Weights, springs: Springs, tensions: tuple,
                    band: Band) -> None:
    """
    Fill the tensions [N/m] of the springs that begin at each node, with their dashpots.

    The friction of the source's algorithm (sec. 2.1): proportional to the relative velocity of the
    ends and along the spring, so that it does not slow a cloth that moves or turns as a whole.
    """
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    across, down, rising, falling = tensions
    k_a, k_d, k_x = springs.k
    c_a, c_d, c_x = springs.c
    rest_a, rest_d, rest_x = springs.rest
    kl_a, kl_d, kl_x = k_a * rest_a, k_d * rest_d, k_x * rest_x
    first, last, stride = band
    for i in range(first, last):
        e, s, d = i + NEXT, i + stride, i + stride + NEXT
        ax, ay, az = x[e] - x[i], y[e] - y[i], z[e] - z[i]
        dx, dy, dz = x[s] - x[i], y[s] - y[i], z[s] - z[i]
        rx, ry, rz = x[e] - x[s], y[e] - y[s], z[e] - z[s]
        fx, fy, fz = x[d] - x[i], y[d] - y[i], z[d] - z[i]
        a, b, r, f = _inverse_lengths(ax * ax + ay * ay + az * az, dx * dx + dy * dy + dz * dz,
                                      rx * rx + ry * ry + rz * rz, fx * fx + fy * fy + fz * fz)
        # Length times the rate at which it grows.
        av = ax * (vx[e] - vx[i]) + ay * (vy[e] - vy[i]) + az * (vz[e] - vz[i])
        dv = dx * (vx[s] - vx[i]) + dy * (vy[s] - vy[i]) + dz * (vz[s] - vz[i])
        rv = rx * (vx[e] - vx[s]) + ry * (vy[e] - vy[s]) + rz * (vz[e] - vz[s])
        fv = fx * (vx[d] - vx[i]) + fy * (vy[d] - vy[i]) + fz * (vz[d] - vz[i])
        across[i] = weights.across[i] * (k_a - kl_a * a + c_a * av * (a * a))
        down[i] = weights.down[i] * (k_d - kl_d * b + c_d * dv * (b * b))
        rising[i] = weights.cell[i] * (k_x - kl_x * r + c_x * rv * (r * r))
        falling[i] = weights.cell[i] * (k_x - kl_x * f + c_x * fv * (f * f))


@inner_kernel
def spring_force(x: np.ndarray, tensions: tuple, i: np.uint64, stride: np.uint64) -> float:
    """
    Return the force [N] of the eight springs on node i along one axis (eq. 1.2).

    x: that coordinate of all nodes [m]. tensions: as elastic_tensions fills them. n, s, w and e
    are the nodes towards the upper and the lower edge, the hoist and the fly.
    """
    across, down, rising, falling = tensions
    e, w, s, n = i + NEXT, i - NEXT, i + stride, i - stride
    se, nw, sw, ne = s + NEXT, n - NEXT, s - NEXT, n + NEXT
    return (across[i] * (x[e] - x[i]) + across[w] * (x[w] - x[i])
            + down[i] * (x[s] - x[i]) + down[n] * (x[n] - x[i])
            + falling[i] * (x[se] - x[i]) + falling[nw] * (x[nw] - x[i])
            + rising[w] * (x[sw] - x[i]) + rising[n] * (x[ne] - x[i]))


@wide_kernel
def set_springs_and_weight(position: Field, tensions: tuple, mass: np.ndarray,
                           gravity: Vector, force: Field, band: Band) -> None:
    """
    Set each node's force [N]: its weight (eq. 1.1) plus its eight springs' force (eq. 1.2).

    gravity: g times a unit vector upwards [m/s2].
    """
    x, y, z = position
    fx, fy, fz = force
    gx, gy, gz = gravity
    first, last, stride = band
    for i in range(first, last):
        fx[i] = spring_force(x, tensions, i, stride) - gx * mass[i]
        fy[i] = spring_force(y, tensions, i, stride) - gy * mass[i]
        fz[i] = spring_force(z, tensions, i, stride) - gz * mass[i]


@wide_kernel
def set_weight(mass: np.ndarray, gravity: Vector, force: Field, band: Band) -> None:
    """Set each node's force [N] to its weight (eq. 1.1) alone."""
    fx, fy, fz = force
    gx, gy, gz = gravity
    zero = type(gx)(0.0)
    first, last, _ = band
    for i in range(first, last):
        fx[i], fy[i] = zero - gx * mass[i], zero - gy * mass[i]
        fz[i] = zero - gz * mass[i]
