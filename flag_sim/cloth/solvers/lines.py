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
Lines of springs that are solved as wholes: in a line the end of a spring begins the next one.

All of it is linear in the nodes' increments d [m] of one step, as every spring keeps the direction
n that it has when the step begins. A spring from a to b then grows by n . (d_b - d_a), and its
impulse, along n, turns nothing: the angular momentum of the nodes is kept, whatever is solved in
which order, and however roughly (see xpbd).
"""
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import LEAST_LENGTH2, Mesh
from flag_sim.cloth.records import Band, Field, NEXT
from flag_sim.jit.kernels import inner_kernel, kernel
import numpy as np


class Family(NamedTuple):
    """The springs of one direction, from the nodes i + tail to i + head."""

    weight: np.ndarray  # the springs' shares (see mesh.Weights)
    elastic: float      # h^2 k, of steps of h [kg]
    viscous: float      # h c, of the dashpots [kg]
    rest: float         # length at rest [m]
    tail: np.uint64
    head: np.uint64


class Lines(NamedTuple):
    """
    A family's springs in one step, and the factors of their tridiagonal systems; flat fields.

    A solve takes half of the springs' stiffness, s = (h^2 k + h c) / 2: see sweep in xpbd.
    """

    direction: Field      # x, y, z of n
    impulse: np.ndarray   # h^2 k (length - rest) / 2, the half one if nothing moves [kg m]
    behind: np.ndarray    # s w c: what the spring before in the line gives way
    inverse: np.ndarray   # the inverse pivots
    ahead: np.ndarray     # and the band above them

    @classmethod
    def of(cls, mesh: Mesh) -> 'Lines':
        """Return the fields for a mesh, with nothing in them."""
        fields = mesh.fields(7)
        return cls(tuple(fields[:3]), *fields[3:])


@kernel
def set_lines(position: Field, predicted: Field, family: Family, tensest: float, lines: Lines,
              band: Band) -> None:
    """
    Set each spring's direction n and impulse.

    Its length is that which the predicted increments lead to but for what they add along n: a
    spring that turns grows, which n . d does not know. tensest: greatest tension over length that
    the step can carry, times h^2 / 2 [kg]; a greater tension is taken for that much.
    """
    x, y, z = position
    u, v, w = predicted
    nx, ny, nz = lines.direction
    impulse, weight, tail, head = lines.impulse, family.weight, family.tail, family.head
    number = type(family.rest)
    one, none, half, least = number(1.0), number(0.0), number(0.5), number(LEAST_LENGTH2)
    elastic, rest = half * family.elastic, family.rest
    first, last, _ = band
    for i in range(first, last):
        a, b = i + tail, i + head
        dx, dy, dz = x[b] - x[a], y[b] - y[a], z[b] - z[a]
        length = math.sqrt(max(dx * dx + dy * dy + dz * dz, least))
        scale = one / length
        dx, dy, dz = scale * dx, scale * dy, scale * dz
        nx[i], ny[i], nz[i] = dx, dy, dz
        ux, uy, uz = u[b] - u[a], v[b] - v[a], w[b] - w[a]
        along = dx * ux + dy * uy + dz * uz
        across2 = max(ux * ux + uy * uy + uz * uz - along * along, none)
        straight = abs(length + along)
        turned = across2 / (straight + math.sqrt(straight * straight + across2) + least)
        impulse[i] = weight[i] * min(elastic * (length + turned - rest), tensest * length)


@kernel
def factor_lines(inverse_mass: np.ndarray, family: Family, lines: Lines, band: Band) -> None:
    """
    Factor the systems of _solve_lines; no pivots are needed, as the diagonal outweighs the rest.

    Two springs that follow each other meet in a node of inverse mass w. With the cosine c between
    them, the impulses p of a line have

        p - s w c p_before + s (w + w') p - s w' c' p_after = p_alone.
    """
    nx, ny, nz = lines.direction
    behind, inverse, passed = lines.behind, lines.inverse, lines.ahead
    weight, tail, head = family.weight, family.tail, family.head
    number = type(family.rest)
    one, stiffness = number(1.0), number(0.5) * (family.elastic + family.viscous)
    back = head - tail
    first, last, _ = band
    for i in range(first, last):
        j, k = i - back, i + back
        s = weight[i] * stiffness
        ahead = s * inverse_mass[i + head]
        own = s * inverse_mass[i + tail]
        before = own * (nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j])
        pivot = one / (one + ahead + own - before * passed[j])
        behind[i], inverse[i] = before, pivot
        passed[i] = pivot * ahead * (nx[i] * nx[k] + ny[i] * ny[k] + nz[i] * nz[k])


@kernel
def project_lines(forced: Field, free: Field, inverse_mass: np.ndarray, family: Family,
                  lines: Lines, impulses: tuple, band: Band) -> None:
    """
    Let the springs act, half as stiff as they are, on two fields of increments at once.

    forced is under the springs' force; free only meets their stiffness, as if all were at rest.
    impulses: two flat fields to compute in.
    """
    p, q = impulses
    _set_impulses(forced, free, family, lines, p, q, band)
    _solve_lines(lines, family.head - family.tail, p, q, band)
    for axis in range(3):
        _move(forced[axis], lines.direction[axis], p, inverse_mass, family.tail, family.head, band)
        _move(free[axis], lines.direction[axis], q, inverse_mass, family.tail, family.head, band)


@inner_kernel
def _set_impulses(forced, free, family, lines, p, q, band):
    """Set the impulses that springs would have alone."""
    ux, uy, uz = forced
    vx, vy, vz = free
    nx, ny, nz = lines.direction
    impulse, weight, tail, head = lines.impulse, family.weight, family.tail, family.head
    stiffness = type(family.rest)(0.5) * (family.elastic + family.viscous)
    first, last, _ = band
    for i in range(first, last):
        a, b = i + tail, i + head
        s = weight[i] * stiffness
        p[i] = impulse[i] + s * (nx[i] * (ux[b] - ux[a]) + ny[i] * (uy[b] - uy[a])
                                 + nz[i] * (uz[b] - uz[a]))
        q[i] = s * (nx[i] * (vx[b] - vx[a]) + ny[i] * (vy[b] - vy[a]) + nz[i] * (vz[b] - vz[a]))


@inner_kernel
def _solve_lines(lines, back, p, q, band):
    """Solve the tridiagonal systems for two right sides at once: each alone would wait as long."""
    behind, inverse, ahead = lines.behind, lines.inverse, lines.ahead
    first, last, _ = band
    for i in range(first, last):
        j = i - back
        p[i] = inverse[i] * (p[i] + behind[i] * p[j])
        q[i] = inverse[i] * (q[i] + behind[i] * q[j])
    for n in range(last - first):
        i = last - NEXT - n
        j = i + back
        p[i] += ahead[i] * p[j]
        q[i] += ahead[i] * q[j]


@inner_kernel
def _move(d, n, p, inverse_mass, tail, head, band):
    """Move each node by the impulses of the two springs of a line that meet in it."""
    first, last, _ = band
    for i in range(first, last):
        a, b = i - tail, i - head
        d[i] += inverse_mass[i] * (p[a] * n[a] - p[b] * n[b])


@kernel
def apply_impulses(field: Field, inverse_mass: np.ndarray, family: Family, lines: Lines,
                   doubled: np.ndarray, band: Band) -> None:
    """
    Move a field of increments by the springs' whole impulses, as if nothing gave way.

    doubled: a flat field to compute in.
    """
    impulse = lines.impulse
    two = type(family.rest)(2.0)
    first, last, _ = band
    for i in range(first, last):
        doubled[i] = two * impulse[i]
    for axis in range(3):
        _move(field[axis], lines.direction[axis], doubled, inverse_mass, family.tail,
              family.head, band)


@kernel
def work_of_lines(a: Field, b: Field, family: Family, lines: Lines, band: Band) -> tuple:
    """
    Return (a K a, a K b, b K b, f a, f b) of two fields of increments, in float64.

    K: h^2 times the springs' Hessian and h times that of the dashpots; f: h^2 times the forces.
    """
    ax, ay, az = a
    bx, by, bz = b
    nx, ny, nz = lines.direction
    impulse, weight, tail, head = lines.impulse, family.weight, family.tail, family.head
    stiffness = np.float64(family.elastic) + np.float64(family.viscous)
    aa, ab, bb, fa, fb = 0.0, 0.0, 0.0, 0.0, 0.0
    first, last, _ = band
    for i in range(first, last):
        j, k = i + tail, i + head
        f = np.float64(nx[i] * (ax[k] - ax[j]) + ny[i] * (ay[k] - ay[j])
                       + nz[i] * (az[k] - az[j]))
        g = np.float64(nx[i] * (bx[k] - bx[j]) + ny[i] * (by[k] - by[j])
                       + nz[i] * (bz[k] - bz[j]))
        s = stiffness * weight[i]
        aa += s * f * f
        ab += s * f * g
        bb += s * g * g
        fa -= 2.0 * impulse[i] * f
        fb -= 2.0 * impulse[i] * g
    return aa, ab, bb, fa, fb
