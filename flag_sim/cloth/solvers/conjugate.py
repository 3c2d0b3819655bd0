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
Conjugate gradients for A y = b with the masses as preconditioner (Hestenes and Stiefel, 1952).

M is the preconditioner because the cloth is a uniform grid, whose nodes hardly differ. A's own
diagonal (Jacobi) takes more iterations than M: 29 for 24 at the defaults, 155 for 129 at stiffness
1e5, four times as many on cells longer than wide by 13. The 3 x 3 blocks on the diagonal take 20
and 106, but half as many again as M on those cells, and would have to be made in each step and
read in each iteration. With M each iterate keeps the momentum of a free cloth, as internal forces
have no sum.

Iterations of others, counted on a flag in the wind, 61 x 41 nodes and steps of 1/300 s, where M
takes 248 at stiffness 1e5 and 491 at 1e6: symmetric Gauss-Seidel 72 and 120, by recurrences that
are no vectors; a V-cycle of multigrid 20 and 24, at the price of some six products each; additive
multilevel (BPX) 63 and 77, of some two. Two to three times less work would still be dearer
than symplectic (see implicit).
"""
from flag_sim.cloth.solvers.matrix import multiply
from flag_sim.jit.kernels import inner_kernel
import numpy as np

# In vectors, and so in another order than written; the order is the same in every run.
SUMS = {'contract', 'reassoc'}


@inner_kernel(fastmath=SUMS)
def dot(a, b, span):
    """Return the sum of a . b over all nodes, in float64 whatever the fields are."""
    ax, ay, az = a
    bx, by, bz = b
    first, last, _ = span
    total = 0.0
    for i in range(first, last):
        total += (np.float64(ax[i]) * bx[i] + np.float64(ay[i]) * by[i]
                  + np.float64(az[i]) * bz[i])
    return total


@inner_kernel(fastmath=SUMS)
def norm2(a, weight, span):
    """Return the sum of weight a . a over all nodes, in float64 whatever the fields are."""
    x, y, z = a
    first, last, _ = span
    total = 0.0
    for i in range(first, last):
        ax, ay, az = np.float64(x[i]), np.float64(y[i]), np.float64(z[i])
        total += weight[i] * (ax * ax + ay * ay + az * az)
    return total


@inner_kernel
def add(field, factor, other, span):
    """Add a factor times another field to a field."""
    first, last, _ = span
    for axis in range(3):
        f, o = field[axis], other[axis]
        for i in range(first, last):
            f[i] += factor * o[i]


@inner_kernel
def _turn(direction, kept, residual, inverse_mass, span):
    """Set the next direction: M^-1 residual and a part of the last direction that is kept."""
    first, last, _ = span
    for axis in range(3):
        d, r = direction[axis], residual[axis]
        for i in range(first, last):
            d[i] = inverse_mass[i] * r[i] + kept * d[i]


@inner_kernel
def solve(matrix, mass, inverse_mass, weights, coefficients, work, residual, direction, product,
          solution, tolerance, limit, dt, span):
    """
    Improve the solution [m/s] until its residual is small, at most `limit` times.

    residual: b - A solution [N s], kept up to date. direction, product: overwritten. tolerance:
    of the residual, sqrt(r^T M^-1 r), as a part of that at the beginning.

    Nodes without inverse mass, pins and ghosts, have no direction and so keep their solution.
    """
    left = norm2(residual, inverse_mass, span)
    enough = tolerance * tolerance * left
    number = type(dt)
    _turn(direction, number(0.0), residual, inverse_mass, span)
    for _ in range(limit):
        if not left > enough:
            break
        multiply(matrix, mass, weights, coefficients, work, direction, product, dt, span)
        length = number(left / dot(direction, product, span))
        add(solution, length, direction, span)
        add(residual, -length, product, span)
        before, left = left, norm2(residual, inverse_mass, span)
        _turn(direction, number(left / before), residual, inverse_mass, span)
