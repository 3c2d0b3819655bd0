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

A family's lines have no node in common, so threads share them (see lanes), and wait for one
another only from one family to the next.
"""
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import LEAST_LENGTH2, Mesh
from flag_sim.cloth.records import Band, Field, NEXT
from flag_sim.cloth.solvers.lanes import (
    count_pieces, lanes_of, piece, row_range, ROWS, rows_of)
from flag_sim.jit.kernels import inner_kernel, kernel, wide_kernel
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


@wide_kernel
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
def factor_lines(inverse_mass: np.ndarray, family: Family, lines: Lines,
                 bands: tuple[Band, Band]) -> None:
    """
    Factor the systems of project_lines; no pivots are needed, as the diagonal outweighs the rest.

    Two springs that follow each other meet in a node of inverse mass w. With the cosine c between
    them, the impulses p of a line have

        p - s w c p_before + s (w + w') p - s w' c' p_after = p_alone.

    bands: whose lines are factored, and all nodes.
    """
    band, whole = bands
    back = family.head - family.tail
    if back == NEXT:
        row, last_row = rows_of(band, whole)
        while row < last_row:
            begin, end = row_range(row, last_row, whole)
            _factor_rows(inverse_mass, family, lines, begin, end, whole.stride)
            row += ROWS
    else:
        lanes = lanes_of(back, band, whole)
        count = count_pieces(whole.first, whole.last, lanes[2])
        for n in range(count):
            begin, end = piece(count - 1 - n, whole.first, whole.last, lanes)
            _factor_piece(inverse_mass, family, lines, lines.ahead, begin, end)


@inner_kernel
def _factors(i, inverse_mass, family, direction, passed_before):
    """Return behind, inverse and ahead of the spring i, given what the one before handed on."""
    nx, ny, nz = direction
    number = type(family.rest)
    one, stiffness = number(1.0), number(0.5) * (family.elastic + family.viscous)
    back = family.head - family.tail
    j, k = i - back, i + back
    s = family.weight[i] * stiffness
    ahead = s * inverse_mass[i + family.head]
    own = s * inverse_mass[i + family.tail]
    before = own * (nx[i] * nx[j] + ny[i] * ny[j] + nz[i] * nz[j])
    pivot = one / (one + ahead + own - before * passed_before)
    return before, pivot, pivot * ahead * (nx[i] * nx[k] + ny[i] * ny[k] + nz[i] * nz[k])


@wide_kernel
def _factor_piece(inverse_mass, family, lines, passed, begin, end):
    """Factor a piece. passed: lines.ahead, of which it reads what it does not write."""
    back = family.head - family.tail
    for i in range(begin, end):
        lines.behind[i], lines.inverse[i], lines.ahead[i] = _factors(
            i, inverse_mass, family, lines.direction, passed[i - back])


@inner_kernel
def _factor_rows(inverse_mass, family, lines, begin, end, stride):
    """Factor rows, in all of them one node after the other."""
    for column in range(begin, begin + stride):
        for i in range(column, end, stride):
            lines.behind[i], lines.inverse[i], lines.ahead[i] = _factors(
                i, inverse_mass, family, lines.direction, lines.ahead[i - NEXT])


@kernel
def project_lines(forced: Field, free: Field, inverse_mass: np.ndarray, family: Family,
                  lines: Lines, impulses: tuple, bands: tuple[Band, Band]) -> None:
    """
    Let the springs act, half as stiff as they are, on two fields of increments at once.

    forced is under the springs' force; free only meets their stiffness, as if all were at rest.
    impulses: two flat fields to compute in, zero at ghosts. bands: whose lines act, and all
    nodes.
    """
    band, whole = bands
    back = family.head - family.tail
    p, q = impulses
    if back == NEXT:
        row, last_row = rows_of(band, whole)
        while row < last_row:
            begin, end = row_range(row, last_row, whole)
            _set_impulses(forced, free, family, lines, p, q, begin, end)
            _solve_rows(lines, p, q, begin, end, whole.stride)
            _move_row(forced, free, inverse_mass, lines, p, q, begin, end)
            row += ROWS
    else:
        lanes = lanes_of(back, band, whole)
        count = count_pieces(whole.first, whole.last, lanes[2])
        for n in range(count):
            begin, end = piece(count - 1 - n, whole.first, whole.last, lanes)
            _eliminate_piece(forced, free, family, lines, impulses, impulses, begin, end)
        # To before the first node, as a node is moved with the spring that ends at it.
        start = whole.first - family.head
        for n in range(count_pieces(start, whole.last, lanes[2])):
            begin, end = piece(n, start, whole.last, lanes)
            _move_piece((forced, free), inverse_mass, family, lines, impulses, impulses, begin,
                        end)


@inner_kernel
def _impulses(i, forced, free, family, lines):
    """Return the impulses that the spring i would have alone."""
    ux, uy, uz = forced
    vx, vy, vz = free
    nx, ny, nz = lines.direction
    a, b = i + family.tail, i + family.head
    s = family.weight[i] * (type(family.rest)(0.5) * (family.elastic + family.viscous))
    return (lines.impulse[i] + s * (nx[i] * (ux[b] - ux[a]) + ny[i] * (uy[b] - uy[a])
                                    + nz[i] * (uz[b] - uz[a])),
            s * (nx[i] * (vx[b] - vx[a]) + ny[i] * (vy[b] - vy[a]) + nz[i] * (vz[b] - vz[a])))


@wide_kernel
def _eliminate_piece(forced, free, family, lines, impulses, before, begin, end):
    """Set the impulses of a piece, given those of the piece before: the same fields once more."""
    (p, q), (p_before, q_before) = impulses, before
    behind, inverse = lines.behind, lines.inverse
    back = family.head - family.tail
    for i in range(begin, end):
        alone_p, alone_q = _impulses(i, forced, free, family, lines)
        p[i] = inverse[i] * (alone_p + behind[i] * p_before[i - back])
        q[i] = inverse[i] * (alone_q + behind[i] * q_before[i - back])


@wide_kernel
def _move_piece(fields, inverse_mass, family, lines, impulses, after, begin, end):
    """Set the impulses of a piece, given those of the piece after; move the nodes between."""
    (ux, uy, uz), (vx, vy, vz) = fields
    (p, q), (p_after, q_after) = impulses, after
    nx, ny, nz = lines.direction
    ahead = lines.ahead
    head, back = family.head, family.head - family.tail
    for i in range(begin, end):
        k, node = i + back, i + head
        p_k, q_k = p_after[k], q_after[k]
        p_i, q_i = p[i] + ahead[i] * p_k, q[i] + ahead[i] * q_k
        p[i], q[i] = p_i, q_i
        w = inverse_mass[node]
        ux[node] += w * (p_k * nx[k] - p_i * nx[i])
        uy[node] += w * (p_k * ny[k] - p_i * ny[i])
        uz[node] += w * (p_k * nz[k] - p_i * nz[i])
        vx[node] += w * (q_k * nx[k] - q_i * nx[i])
        vy[node] += w * (q_k * ny[k] - q_i * ny[i])
        vz[node] += w * (q_k * nz[k] - q_i * nz[i])


@wide_kernel
def _set_impulses(forced, free, family, lines, p, q, begin, end):
    """Set the impulses that springs would have alone."""
    for i in range(begin, end):
        p[i], q[i] = _impulses(i, forced, free, family, lines)


@inner_kernel
def _solve_rows(lines, p, q, begin, end, stride):
    """Solve the systems of rows, in all of them one node after the other."""
    behind, inverse, ahead = lines.behind, lines.inverse, lines.ahead
    for column in range(begin, begin + stride):
        for i in range(column, end, stride):
            j = i - NEXT
            p[i] = inverse[i] * (p[i] + behind[i] * p[j])
            q[i] = inverse[i] * (q[i] + behind[i] * q[j])
    for n in range(stride):
        for i in range(begin + stride - NEXT - n, end, stride):
            j = i + NEXT
            p[i] += ahead[i] * p[j]
            q[i] += ahead[i] * q[j]


@wide_kernel
def _move_row(forced, free, inverse_mass, lines, p, q, begin, end):
    """Move each node by the impulses of the two springs of a row that meet in it."""
    ux, uy, uz = forced
    vx, vy, vz = free
    nx, ny, nz = lines.direction
    for i in range(begin, end):
        j, w = i - NEXT, inverse_mass[i]
        ux[i] += w * (p[i] * nx[i] - p[j] * nx[j])
        uy[i] += w * (p[i] * ny[i] - p[j] * ny[j])
        uz[i] += w * (p[i] * nz[i] - p[j] * nz[j])
        vx[i] += w * (q[i] * nx[i] - q[j] * nx[j])
        vy[i] += w * (q[i] * ny[i] - q[j] * ny[j])
        vz[i] += w * (q[i] * nz[i] - q[j] * nz[j])


@wide_kernel
def apply_impulses(field: Field, inverse_mass: np.ndarray, family: Family, lines: Lines,
                   band: Band) -> None:
    """Move a field of increments by the springs' whole impulses, as if nothing gave way."""
    x, y, z = field
    nx, ny, nz = lines.direction
    impulse, tail, head = lines.impulse, family.tail, family.head
    two = type(family.rest)(2.0)
    first, last, _ = band
    for i in range(first, last):
        a, b, w = i - tail, i - head, inverse_mass[i]
        p, q = two * impulse[a], two * impulse[b]
        x[i] += w * (p * nx[a] - q * nx[b])
        y[i] += w * (p * ny[a] - q * ny[b])
        z[i] += w * (p * nz[a] - q * nz[b])
