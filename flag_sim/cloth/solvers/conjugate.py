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
from flag_sim.cloth.records import Band, Field
from flag_sim.cloth.solvers.elementwise import add
from flag_sim.cloth.solvers.matrix import multiply, System
from flag_sim.cloth.solvers.sums import dot, norm2, Sums
from flag_sim.jit.kernels import inner_kernel, wide_kernel


@wide_kernel
def _turn(direction, kept, residual, inverse_mass, band):
    """Set the next direction: M^-1 residual and a part of the last direction that is kept."""
    first, last, _ = band
    for axis in range(3):
        d, r = direction[axis], residual[axis]
        for i in range(first, last):
            d[i] = inverse_mass[i] * r[i] + kept * d[i]


@inner_kernel
def solve(system: System, residual: Field, direction: Field, product: Field, solution: Field,
          sums: Sums, limits: tuple[float, int], band: Band) -> None:
    """
    Improve the solution [m/s] until its residual is small.

    residual: b - A solution [N s], kept up to date. direction, product: overwritten. limits:
    of the residual, sqrt(r^T M^-1 r), as a part of that at the beginning, and of iterations.

    Nodes without inverse mass, pins and ghosts, have no direction and so keep their solution.
    """
    inverse_mass, number = system.sheet.inverse_mass, type(system.dt)
    tolerance, limit = limits
    left = norm2(residual, inverse_mass, sums, band)
    enough = tolerance * tolerance * left
    _turn(direction, number(0.0), residual, inverse_mass, band)
    for _ in range(limit):
        if not left > enough:
            break
        multiply(system, direction, product, band)
        length = number(left / dot(direction, product, sums, band))
        add(solution, length, direction, band)
        add(residual, -length, product, band)
        before, left = left, norm2(residual, inverse_mass, sums, band)
        _turn(direction, number(left / before), residual, inverse_mass, band)
