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
The best that two fields of increments span: the end of a step of xpbd.

The best increments d are those of least energy |d - d*|^2_M / 2 + d K d / 2 - f d, with d* the
predicted ones, K and f the stiffness and the forces of springs and bending, times h^2. Their
residual is orthogonal to both fields (Galerkin's condition), which is why energy cannot grow: see
xpbd.
"""
from flag_sim.cloth.records import Band, Field, NEXT, Vector, Weights
from flag_sim.cloth.solvers.elementwise import set_combination
from flag_sim.cloth.solvers.rigid import (
    add_rigid, Body, FOUR, inertia_of, rigid_of, SUMS, take_rigid, THREE, TWO, WIDTH)
from flag_sim.cloth.solvers.sums import begin_sums, end_sums, segments_of, total
from flag_sim.jit.kernels import inner_kernel, shared_kernel, wide_kernel
from flag_sim.parallel.barrier import wait
import numpy as np

PARALLEL_TOLERANCE = 1e-9
"""Fraction of a field's square below which the field counts as parallel to another one."""
SYSTEM = SUMS
"""The first of this method's own sums, after those of rigid."""


@inner_kernel
def _difference(x, before, i, after):
    """Return the second difference of a field at node i, along one axis."""
    return np.float64((x[after] - x[i]) - (x[i] - x[before]))


@inner_kernel
def _twist(x, i, e, s, d):
    """Return the twist of a field on the cell whose corners are i, e, s and d, along one axis."""
    return np.float64((x[i] - x[e]) - (x[s] - x[d]))


@wide_kernel
def _add_work_of_lines(a, b, family, lines, lanes, segment):
    """
    Add (a K a, a K b, b K b, f a, f b) of two fields of increments to a segment's sums.

    K: h^2 times the springs' Hessian and h times that of the dashpots; f: h^2 times the forces.
    """
    ax, ay, az = a
    bx, by, bz = b
    nx, ny, nz = lines.direction
    impulse, weight, tail, head = lines.impulse, family.weight, family.tail, family.head
    stiffness = np.float64(family.elastic) + np.float64(family.viscous)
    first, last, _, at = segment
    for start in range(first, last, WIDTH):
        for i in range(start, min(start + WIDTH, last)):
            n, j, k = at + (i - start), i + tail, i + head
            f = np.float64(nx[i] * (ax[k] - ax[j]) + ny[i] * (ay[k] - ay[j])
                           + nz[i] * (az[k] - az[j]))
            g = np.float64(nx[i] * (bx[k] - bx[j]) + ny[i] * (by[k] - by[j])
                           + nz[i] * (bz[k] - bz[j]))
            s = stiffness * weight[i]
            lanes[n] += s * f * f
            lanes[n + WIDTH] += s * f * g
            lanes[n + TWO] += s * g * g
            lanes[n + THREE] -= 2.0 * impulse[i] * f
            lanes[n + FOUR] -= 2.0 * impulse[i] * g


@wide_kernel
def _add_work_of_plate(position, a, b, weights, bend, lanes, segment):
    """
    Add (a K a, a K b, b K b, f a, f b) of two fields of increments to a segment's sums.

    K: h^2 times the Hessian of bending, of constants bend [kg]; f: h^2 times its forces.
    """
    across, down, twist = np.float64(bend[0]), np.float64(bend[1]), np.float64(bend[2])
    first, last, stride, at = segment
    for axis in range(3):
        x, u, v = position[axis], a[axis], b[axis]
        for start in range(first, last, WIDTH):
            for i in range(start, min(start + WIDTH, last)):
                n = at + (i - start)
                e, w, s, o, d = i + NEXT, i - NEXT, i + stride, i - stride, i + stride + NEXT
                k = across * weights.bend_across[i]
                c, f, g = _difference(x, w, i, e), _difference(u, w, i, e), _difference(v, w, i, e)
                aa, ab, bb, fa, fb = k * f * f, k * f * g, k * g * g, k * c * f, k * c * g
                k = down * weights.bend_down[i]
                c, f, g = _difference(x, o, i, s), _difference(u, o, i, s), _difference(v, o, i, s)
                aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
                fa, fb = fa + k * c * f, fb + k * c * g
                k = twist * weights.cell[i]
                c, f, g = _twist(x, i, e, s, d), _twist(u, i, e, s, d), _twist(v, i, e, s, d)
                lanes[n] += aa + k * f * f
                lanes[n + WIDTH] += ab + k * f * g
                lanes[n + TWO] += bb + k * g * g
                lanes[n + THREE] -= fa + k * c * f
                lanes[n + FOUR] -= fb + k * c * g


@wide_kernel
def _add_products(a, b, c, mass, lanes, segment):
    """Add (a M a, a M b, b M b, a M c, b M c) of three fields to a segment's sums."""
    first, last, _, at = segment
    for axis in range(3):
        u, v, w = a[axis], b[axis], c[axis]
        for start in range(first, last, WIDTH):
            for i in range(start, min(start + WIDTH, last)):
                n, m = at + (i - start), np.float64(mass[i])
                f, g = np.float64(u[i]), np.float64(v[i])
                lanes[n] += m * f * f
                lanes[n + WIDTH] += m * f * g
                lanes[n + TWO] += m * g * g
                lanes[n + THREE] += m * f * w[i]
                lanes[n + FOUR] += m * g * w[i]


@inner_kernel
def _parts(system):
    """Solve [[aa, ab], [ab, bb]] (f, g) = (a_rhs, b_rhs), by the first alone if both are alike."""
    aa, ab, bb, a_rhs, b_rhs = system
    if not aa > 0.0:
        return 0.0, b_rhs / bb if bb > 0.0 else 0.0
    left = bb - ab * ab / aa
    g = (b_rhs - ab / aa * a_rhs) / left if left > PARALLEL_TOLERANCE * bb else 0.0
    return (a_rhs - ab * g) / aa, g


@shared_kernel
def set_best(position: Field, body: Body, weights: Weights, bend: Vector, families: tuple,
             scratch: tuple, bands: tuple[Band, Band], barrier: np.ndarray) -> None:
    """
    Set scratch.predicted to the best increments that scratch.free and scratch.forced span.

    bend: constants of bending, times h^2 [kg]. families: of springs, whose lines are in
    scratch.lines; see xpbd.Scratch. Rigid motion is set apart: no inner force acts on it, and it
    stays as predicted. bands: a thread's nodes, and all. All threads of the barrier call it
    together.
    """
    a, b, predicted, sums = scratch.free, scratch.forced, scratch.predicted, scratch.sums
    band, whole = bands
    inertia = inertia_of(position, body, sums, bands, barrier)
    rigid_a, rigid_b, rigid = rigid_of(position, (a, b, predicted), body, inertia, sums, bands,
                                       barrier)
    take_rigid(position, body.inverse_mass, rigid_a, a, band)
    take_rigid(position, body.inverse_mass, rigid_b, b, band)
    take_rigid(position, body.inverse_mass, rigid, predicted, band)
    wait(barrier)

    for number in range(*segments_of(band, whole)):
        segment = begin_sums(sums, SYSTEM, 5, number, whole)
        _add_products(a, b, predicted, body.mass, sums.lanes, segment)
        for one in range(4):
            _add_work_of_lines(a, b, families[one], scratch.lines[one], sums.lanes, segment)
        if max(bend) > 0.0:
            _add_work_of_plate(position, a, b, weights, bend, sums.lanes, segment)
        end_sums(sums, SYSTEM, 5, number)
    wait(barrier)
    f, g = _parts((total(sums, SYSTEM, whole), total(sums, SYSTEM + 1, whole),
                   total(sums, SYSTEM + 2, whole), total(sums, SYSTEM + 3, whole),
                   total(sums, SYSTEM + 4, whole)))
    number = type(bend[0])
    set_combination(number(f), a, number(g), b, predicted, band)
    add_rigid(position, body.inverse_mass, rigid, predicted, band)
