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

from flag_sim.cloth import aerodynamics, bending, collision, Material, springs
from flag_sim.cloth.forces import Forcing, Work
from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import (conjugate, euler, implicit, lines, matrix, plate, rk4, seed,
                                    symplectic, verlet, xpbd)
from flag_sim.cloth.state import State
from llvmlite.binding import get_host_cpu_features
import numba
import pytest

pytestmark = pytest.mark.skipif(platform.machine() not in ('x86_64', 'AMD64'),
                                reason='names x86 instructions')

WIDENS = r'\bv?cvt[sp]s2[sp]d\b'
"""An instruction that makes float64 of float32."""


def loops(precision):
    """Return the loops over nodes that are vectors: {name: (kernel, arguments)}."""
    mesh = Mesh(3, 3, 1.0, 1.0, precision=precision)
    state, out, work, model = State(mesh), State(mesh), Work.of(mesh), Model(mesh, Material())
    c, span, weights, mass = model.coefficients(Forcing(), 1), mesh.span, mesh.weights, model.mass
    one, vector = mesh.number(1.0), mesh.number((1.0, 1.0, 1.0))
    x, v, x_out, v_out = state.position, state.velocity, out.position, out.velocity
    w, f, a = model.inverse_mass, work.force, tuple(mesh.fields(3))
    calls = [
        (springs.elastic_tensions, x, weights, vector, vector, work.tensions),
        (springs.damped_tensions, x, v, weights, vector, vector, vector, work.tensions),
        (springs.sum_tensions, x, work.tensions, mass, one, f),
        (bending.set_moments, x, weights, c.bend, work.moments),
        (bending._add_along, *work.moments[0], f[0]),
        (aerodynamics.wind_on_faces, x, v, vector, one, one, c.law, c.order, weights, work.faces),
        (aerodynamics._add_along, work.faces[0], work.faces[3], f[0]),
        (symplectic._move, x, v, work.tensions, work.moments, work.faces, mass, one, w, x_out,
         v_out, one, one),
        (euler._update, x, v, f, w, x_out, v_out, one, one),
        (seed._update, x, v, f, w, x_out, v_out, one, one),
        (verlet._drift, x, v, a, x_out, v_out, one, one),
        (verlet._kick, v, f, w, a, one, one),
        (rk4._begin, x, v, a, tuple(mesh.fields(3)), x_out, v_out, one),
        (rk4._end, x, x_out, v_out, one),
        (rk4._stage, x, v, a, tuple(mesh.fields(3)), f, w, x_out, v_out, one, one, one),
        (xpbd._predict, v, f, w, x_out, one, one),
        (xpbd._add_forces, f, w, x, one),
        (xpbd._advance, x, f, x_out, v_out, one),
        (plate._add_curvatures, x, weights.bend_down, one, span[2], a),
        (plate._move_curved, x, w, span[2], a),
        (plate._add_twists, x, weights.cell, one, a),
        (plate._move_twisted, x, w, a),
        (collision._set_room, x, x_out, weights.cell, vector, work.contact)]
    return named(calls, span)


def scalar_loops(precision):
    """Return the loops that gather, choose or recur too much for vectors, or sum in float64."""
    mesh = Mesh(3, 3, 1.0, 1.0, precision=precision)
    state, out, work, model = State(mesh), State(mesh), Work.of(mesh), Model(mesh, Material())
    c, span, weights, mass = model.coefficients(Forcing(), 1), mesh.span, mesh.weights, model.mass
    one, vector = mesh.number(1.0), mesh.number((1.0, 1.0, 1.0))
    x, v, x_out, v_out = state.position, state.velocity, out.position, out.velocity
    w, f, a = model.inverse_mass, work.force, tuple(mesh.fields(3))
    springs, ahead = lines.Lines.of(mesh), span[2]
    family = lines.Family(weights.down, one, one, one, ahead, ahead)
    filled = matrix.Matrix.of(tuple(mesh.fields(matrix.FIELDS)))
    calls = [
        (lines.set_lines, x, x_out, family, one, springs),
        (lines.factor_lines, w, family, springs),
        (lines.meet_lines, x, x_out, w, family, springs, a[:2]),
        (lines.pull_lines, x, w, family, springs, a[0]),
        (plate._factor_curvatures, w, weights.bend_down, one, ahead, a),
        (plate._factor_twists, w, weights.cell, one, ahead, a[:2]),
        (plate._solve_curvatures, f, ahead, a),
        (plate._solve_twists, a[:2], ahead, f),
        (matrix.set_springs, x, weights, vector, vector, vector, filled, one),
        (matrix.set_faces, x, v, vector, weights, one, c.law, filled, one),
        (matrix._multiply_springs, filled, mass, one, a, f),
        (matrix._push_faces, filled, a, work.faces),
        (conjugate.add, a, one, f),
        (conjugate._turn, a, one, f, w),
        (implicit._guess, v, w, one, one, v_out),
        (implicit._move, x, v, one, x_out),
        (implicit._set_residual, v, v_out, f, mass, one, one, a),
        (implicit._set_difference, v, v_out, a),
        (implicit._scale, a, one)]
    return named(calls, span)


def named(calls, span):
    """Return the calls by the names of their kernels."""
    return {f'{call[0].py_func.__module__}.{call[0].__name__}': (call[0], (*call[1:], span))
            for call in calls}


def machine_code(function, arguments):
    """Return what a kernel is compiled to, anew: code that is kept cannot be read."""
    options = {name: value for name, value in function.targetoptions.items() if name != 'nopython'}
    anew = numba.njit(function.py_func, pipeline_class=function._compiler.pipeline_class,
                      **options)
    anew.compile(tuple(numba.typeof(one) for one in arguments))
    return next(iter(anew.inspect_asm().values()))


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
    """All the way: only the sums over all nodes, conjugate.dot and norm2, are float64."""
    code = machine_code(*scalar_loops('float32')[name])
    assert re.search(r'\bv?\w*(mul|add|sub)\w*[sp]s\s', code)
    assert not re.search(WIDENS, code)
