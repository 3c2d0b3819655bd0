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
from flag_sim.cloth.solvers.lines import work_of_lines
from flag_sim.cloth.solvers.rigid import add_rigid, Body, inertia_of, rigid_of, take_rigid
from flag_sim.jit.kernels import inner_kernel, kernel
import numpy as np

PARALLEL_TOLERANCE = 1e-9
"""Fraction of a field's square below which the field counts as parallel to another one."""


@inner_kernel
def _difference(x, before, i, after):
    """Return the second difference of a field at node i, along one axis."""
    return np.float64((x[after] - x[i]) - (x[i] - x[before]))


@inner_kernel
def _twist(x, i, e, s, d):
    """Return the twist of a field on the cell whose corners are i, e, s and d, along one axis."""
    return np.float64((x[i] - x[e]) - (x[s] - x[d]))


@kernel
def _work_of_plate(position, a, b, weights, bend, band):
    """
    Return (a K a, a K b, b K b, f a, f b) of two fields of increments, in float64.

    K: h^2 times the Hessian of bending, of constants bend [kg]; f: h^2 times its forces.
    """
    across, down, twist = np.float64(bend[0]), np.float64(bend[1]), np.float64(bend[2])
    aa, ab, bb, fa, fb = 0.0, 0.0, 0.0, 0.0, 0.0
    first, last, stride = band
    for axis in range(3):
        x, u, v = position[axis], a[axis], b[axis]
        for i in range(first, last):
            e, w, s, n, d = i + NEXT, i - NEXT, i + stride, i - stride, i + stride + NEXT
            k = across * weights.bend_across[i]
            c, f, g = _difference(x, w, i, e), _difference(u, w, i, e), _difference(v, w, i, e)
            aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
            fa, fb = fa - k * c * f, fb - k * c * g
            k = down * weights.bend_down[i]
            c, f, g = _difference(x, n, i, s), _difference(u, n, i, s), _difference(v, n, i, s)
            aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
            fa, fb = fa - k * c * f, fb - k * c * g
            k = twist * weights.cell[i]
            c, f, g = _twist(x, i, e, s, d), _twist(u, i, e, s, d), _twist(v, i, e, s, d)
            aa, ab, bb = aa + k * f * f, ab + k * f * g, bb + k * g * g
            fa, fb = fa - k * c * f, fb - k * c * g
    return aa, ab, bb, fa, fb


@inner_kernel
def _products(a, b, c, mass, band):
    """Return (a M a, a M b, b M b, a M c, b M c) of three fields, in float64."""
    aa, ab, bb, ac, bc = 0.0, 0.0, 0.0, 0.0, 0.0
    first, last, _ = band
    for axis in range(3):
        u, v, w = a[axis], b[axis], c[axis]
        for i in range(first, last):
            m, f, g = np.float64(mass[i]), np.float64(u[i]), np.float64(v[i])
            aa += m * f * f
            ab += m * f * g
            bb += m * g * g
            ac += m * f * w[i]
            bc += m * g * w[i]
    return aa, ab, bb, ac, bc


@inner_kernel
def _parts(system):
    """Solve [[aa, ab], [ab, bb]] (f, g) = (a_rhs, b_rhs), by the first alone if both are alike."""
    aa, ab, bb, a_rhs, b_rhs = system
    if not aa > 0.0:
        return 0.0, b_rhs / bb if bb > 0.0 else 0.0
    left = bb - ab * ab / aa
    g = (b_rhs - ab / aa * a_rhs) / left if left > PARALLEL_TOLERANCE * bb else 0.0
    return (a_rhs - ab * g) / aa, g


@inner_kernel
def _added(system, work):
    """Return the sum of two systems (aa, ab, bb, a_rhs, b_rhs)."""
    aa, ab, bb, a_rhs, b_rhs = system
    k_aa, k_ab, k_bb, f_a, f_b = work
    return aa + k_aa, ab + k_ab, bb + k_bb, a_rhs + f_a, b_rhs + f_b


@kernel
def set_best(position: Field, body: Body, weights: Weights, bend: Vector, families: tuple,
             scratch: tuple, band: Band) -> None:
    """
    Set scratch.predicted to the best increments that scratch.free and scratch.forced span.

    bend: constants of bending, times h^2 [kg]. families: of springs, whose lines are in
    scratch.lines; see xpbd.Scratch. Rigid motion is set apart: no inner force acts on it, and it
    stays as predicted.
    """
    a, b, predicted = scratch.free, scratch.forced, scratch.predicted
    inertia = inertia_of(position, body, band)
    rigid = rigid_of(position, predicted, body, inertia, band)
    for field in (a, b, predicted):
        take_rigid(position, field, body, inertia, band)

    system = _products(a, b, predicted, body.mass, band)
    for one in range(4):
        system = _added(system, work_of_lines(a, b, families[one], scratch.lines[one], band))
    if max(bend) > 0.0:
        system = _added(system, _work_of_plate(position, a, b, weights, bend, band))
    f, g = _parts(system)
    number = type(bend[0])
    set_combination(number(f), a, number(g), b, predicted, band)
    add_rigid(position, body.inverse_mass, rigid, predicted, band)
