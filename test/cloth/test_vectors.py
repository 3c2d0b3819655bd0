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

"""The loops over the nodes are compiled to vectors of the cloth's own precision."""
import platform
import re

from flag_sim.cloth import aerodynamics, bending, Material, proximity, springs, turning
from flag_sim.cloth.forces import Forcing, Work
from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import (conjugate, elementwise, euler, galerkin, implicit, lines,
                                    matrix, plate, plate_lines, rigid, rk4, seed, sums, symplectic,
                                    verlet, xpbd)
from flag_sim.cloth.state import State
from llvmlite.binding import get_host_cpu_features
import numba
from numba.core.compiler_lock import global_compiler_lock
import numpy as np
import pytest

pytestmark = pytest.mark.skipif(platform.machine() not in ('x86_64', 'AMD64'),
                                reason='names x86 instructions')

WIDENS = r'\bv?cvt[sp]s2[sp]d\b'
"""An instruction that makes float64 of float32."""


class Case:
    """Arguments for every loop over the nodes, in one precision."""

    def __init__(self, precision):
        mesh = Mesh(3, 3, 1.0, 1.0, precision=precision)
        model = Model(mesh, Material())
        self.mesh, self.sheet, self.weights = mesh, model.sheet, mesh.weights
        self.nodes, self.out, self.work = State(mesh).nodes, State(mesh).nodes, Work.of(mesh)
        self.c = model.coefficients(Forcing(), 1)
        self.mass, self.w = model.mass, model.inverse_mass
        self.one = mesh.number(1.0)
        self.below = mesh.band().stride
        self.matrix = matrix.Matrix.of(tuple(mesh.fields(matrix.FIELDS)))
        self.lines = lines.Lines.of(mesh)
        self.family = lines.Family(self.weights.down, self.one, self.one, self.one, self.below,
                                   self.below)

    def field(self):
        """Return a new field."""
        return tuple(self.mesh.fields(3))


def loops(precision):
    """Return the loops over nodes that are vectors: {name: (kernel, arguments)}."""
    case = Case(precision)
    nodes, out, work, one = case.nodes, case.out, case.work, case.one
    c, weights, mass, w = case.c, case.weights, case.mass, case.w
    x, v, f, a = nodes.position, nodes.velocity, work.force, case.field()
    stage = State(case.mesh).nodes
    calls = [
        (springs.elastic_tensions, x, weights, c.springs, work.tensions),
        (springs.damped_tensions, nodes, weights, c.springs, work.tensions),
        (springs.set_springs_and_weight, x, work.tensions, mass, (one, one, one), f),
        (bending.set_moments, x, weights, c.bend, work.moments),
        (bending._add_along, work.moments[0], f[0]),
        (aerodynamics._set_forces, nodes, c.wind, None, one, weights, work.faces),
        (aerodynamics._set_forces, nodes, c.wind, c.wind.spin, one, weights, work.faces),
        (aerodynamics._add_along, work.faces[0], work.faces[3], f[0]),
        (symplectic._move, nodes, out, work.tensions, work.moments, work.faces, case.sheet,
         symplectic.StepFactors(one, one, (one, one, one))),
        (euler._update, nodes, f, w, out, one, one),
        (seed._update, nodes, f, w, out, one, one),
        (verlet._drift, nodes, a, out, one, one),
        (verlet._kick, v, f, w, a, one, one),
        (rk4._begin, nodes, stage, out, one),
        (rk4._end, x, out, one),
        (rk4._stage, nodes, stage, f, w, out, (one, one, one)),
        (xpbd._predict, v, f, w, a, one, one),
        (xpbd._advance, x, f, out, one),
        (springs.set_weight, mass, (one, one, one), f),
        (plate_lines.move_twisted, x, w, a),
        (lines.set_lines, x, a, case.family, one, case.lines),
        (lines.apply_impulses, x, w, case.family, case.lines),
        (matrix.set_springs, x, weights, c.springs, case.matrix, one),
        (matrix.set_faces, nodes, c.wind, weights, case.matrix, one),
        (matrix._multiply_springs, case.matrix, mass, one, a, f),
        (matrix._set_face_drag, case.matrix, a, work.faces),
        (conjugate._turn, a, one, f, w),
        (proximity.set_room, x, out.position, c.limits, work.contact),
        (turning.turn_nodes, nodes, out, c.limits.turn, mass),
        (elementwise.scale, a, one),
        (elementwise.add, a, one, f),
        (elementwise.add_weighted, a, one, w, f),
        (elementwise.set_weighted, w, f, a),
        (elementwise.set_difference, v, f, a),
        (elementwise.set_sum, x, one, v, a),
        (elementwise.set_combination, one, f, one, v, a)]
    first, last, _ = band = case.mesh.band()
    return {**named(calls, band), **named(pieces(case), first, last)}


def pieces(case):
    """Return calls of the loops over a piece, of lines that lie side by side."""
    one, below, weights, w = case.one, case.below, case.weights, case.w
    x, v, a, b = case.nodes.position, case.nodes.velocity, case.field(), case.field()
    factors, family, springs = case.field(), case.family, case.lines
    return [
        (lines._factor_piece, w, family, springs, springs.ahead),
        (lines._eliminate_piece, x, v, family, springs, a[:2], b[:2]),
        (lines._move_piece, (x, v), w, family, springs, a[:2], b[:2]),
        (lines._set_impulses, x, v, family, springs, a[0], a[1]),
        (lines._move_row, x, v, w, springs, a[0], a[1]),
        (plate_lines.set_curvatures, x, v, weights.bend_down, one, below, a),
        (plate_lines.eliminate_curvatures, factors, below, a, b),
        (plate_lines.insert_curvatures, factors, below, a, b),
        (plate_lines.move_curved, x, w, below, a),
        (plate_lines.set_twists, x, v, weights.cell, one, below, a),
        (plate_lines.eliminate_twists, factors[:2], below, a, b),
        (plate_lines.insert_twists, factors[:2], below, a, b)]


def scalar_loops(precision):
    """Return the loops that gather, choose or recur too much for vectors, or sum in float64."""
    case = Case(precision)
    nodes, out, one, below, weights, w = (case.nodes, case.out, case.one, case.below, case.weights,
                                          case.w)
    v, f, a = nodes.velocity, case.work.force, case.field()
    system = matrix.System(case.matrix, case.sheet, case.c, case.work, one)
    first, last, stride = band = case.mesh.band()
    calls = [
        (plate._factor_curvatures, w, weights.bend_down, one, below, a),
        (plate._factor_twists, w, weights.cell, one, below, a[:2]),
        (implicit._guess, v, w, (one, one, one), one, out.velocity),
        (implicit._set_residual, v, out.velocity, f, system, a)]
    rows = [
        (lines._factor_rows, w, case.family, case.lines),
        (lines._solve_rows, case.lines, a[0], a[1]),
        (plate_lines.solve_curvatures_of_rows, f, a),
        (plate_lines.solve_twists_of_rows, f[:2], a)]
    return {**named(calls, band), **named(rows, first, last, stride)}


def named(calls, *last):
    """
    Return the calls by the names of their kernels, of which some do without an argument.

    last: the last arguments of all.
    """
    return {f'{call[0].py_func.__module__}.{call[0].__name__}'
            + ' without' * any(one is None for one in call): (call[0], (*call[1:], *last))
            for call in calls}


def machine_code(function, arguments):
    """
    Return what a kernel is compiled to, anew: code that is kept cannot be read.

    As other kernels call it: without the wrapper for Python, which takes longer to compile.
    """
    options = {name: value for name, value in function.targetoptions.items() if name != 'nopython'}
    anew = numba.njit(function.py_func, pipeline_class=function._compiler.pipeline_class,
                      **{**options, 'no_cpython_wrapper': True})
    compiled = anew._compiler.compile(tuple(numba.typeof(one) for one in arguments), None)
    with global_compiler_lock:
        compiled.library.finalize()
    return compiled.library.get_asm_str()


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('name', list(loops('float64')))
def test_hot_loops_are_vectors_of_their_precision(name, precision):
    """
    Packed arithmetic, in the widest registers there are, and no other precision on the way.

    A literal such as 0.5 is a float64, and would silently take a float32 loop to half its lanes.
    Roots of float64 alone are begun in float32.
    """
    function, arguments = loops(precision)[name]
    code = machine_code(function, arguments)
    packed = {'float64': 'pd', 'float32': 'ps'}[precision]
    register = 'zmm' if get_host_cpu_features().get('avx512f') else '[xy]mm'
    stores = re.findall(rf'\bv?mov[au]{packed}\s+%{register}\d+, \S*\(', code)
    assert len(stores) >= 1
    assert re.search(rf'\bv?\w*(mul|add|sub|div)\w*{packed}\s.*%{register}', code)
    if precision == 'float32':
        assert not re.search(WIDENS, code)


@pytest.mark.parametrize('name', list(scalar_loops('float32')))
def test_other_loops_in_float32_stay_in_it(name):
    """All the way: only the sums over all nodes, see sums, are float64."""
    code = machine_code(*scalar_loops('float32')[name])
    assert re.search(r'\bv?\w*(mul|add|sub)\w*[sp]s\s', code)
    assert not re.search(WIDENS, code)


def sums_of(case):
    """Return the loops that sum over all nodes."""
    whole, room = case.mesh.band(), sums.Sums.of(galerkin.SYSTEM + 5)
    segment = sums.Segment(*whole, at=np.uint64(0))
    x, v, f, one = case.nodes.position, case.nodes.velocity, case.work.force, case.one
    three = (1.0, 1.0, 1.0)
    return named([
        (sums._add_dot, x, v), (sums._add_norm2, x, case.mass),
        (rigid._add_mass_center, x, case.mass), (rigid._add_moments, x, case.mass, three),
        (rigid._add_momenta, x, v, case.mass, three),
        (galerkin._add_products, x, v, f, case.mass),
        (galerkin._add_work_of_plate, x, v, f, case.weights, (one, one, one)),
        (galerkin._add_work_of_lines, x, v, case.family, case.lines)], room.lanes, segment)


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('name', list(sums_of(Case('float64'))))
def test_sums_are_vectors_too(name, precision):
    """Of float64, whatever the fields are."""
    code = machine_code(*sums_of(Case(precision))[name])
    register = 'zmm' if get_host_cpu_features().get('avx512f') else '[xy]mm'
    assert re.search(rf'\bv?\w*(mul|add|sub)\w*pd\s.*%{register}', code)
