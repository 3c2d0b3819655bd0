"""The loops over the nodes are compiled to vectors of the cloth's own precision."""
import platform
import re

from flag_sim.cloth import bending, forces, Material, springs, wind
from flag_sim.cloth.forces import Forcing, Work
from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import euler, rk4, seed, symplectic, verlet, xpbd
from flag_sim.cloth.state import State
from llvmlite.binding import get_host_cpu_features
import numba
import pytest

pytestmark = pytest.mark.skipif(platform.machine() not in ('x86_64', 'AMD64'),
                                reason='names x86 instructions')


def loops(precision):
    """Return every loop over nodes with arguments for it: {name: (kernel, arguments)}."""
    mesh = Mesh(3, 3, 1.0, 1.0, precision=precision)
    state, out, work, model = State(mesh), State(mesh), Work.of(mesh), Model(mesh, Material())
    c, span, weights, mass = model.coefficients(Forcing(), 1), mesh.span, mesh.weights, model.mass
    one, vector = mesh.number(1.0), mesh.number((1.0, 1.0, 1.0))
    x, v, x_out, v_out = state.position, state.velocity, out.position, out.velocity
    w, f, a = model.inverse_mass, work.force, tuple(mesh.fields(3))
    calls = [
        (forces._set_weights, mass, one, f),
        (springs.elastic_tensions, x, weights, vector, vector, work.tensions),
        (springs.damped_tensions, x, v, weights, vector, vector, vector, work.tensions),
        (springs.sum_tensions, x, work.tensions, mass, one, f),
        (bending.set_moments, x, weights, c.bend, work.moments),
        (bending._add_along, *work.moments[0], f[0]),
        (wind.wind_on_faces, x, v, vector, one, one, c.law, c.order, weights, work.faces),
        (wind._add_along, work.faces[0], work.faces[3], f[0]),
        (symplectic._update, x, v, f, w, x_out, v_out, one, one),
        (euler._update, x, v, f, w, x_out, v_out, one, one),
        (seed._update, x, v, f, w, x_out, v_out, one, one),
        (verlet._drift, x, v, a, x_out, v_out, one, one),
        (verlet._kick, v, f, w, a, one, one),
        (rk4._begin, x, one, a, x_out),
        (rk4._stage, x, v, a, tuple(mesh.fields(3)), f, w, x_out, v_out, one, one, one),
        (xpbd._predict, x, v, f, w, x_out, one, one),
        (xpbd._set_velocity, x, x_out, v, one)]
    return {f'{call[0].py_func.__module__}.{call[0].__name__}': (call[0], (*call[1:], span))
            for call in calls}


NAMES = list(loops('float64'))


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('name', NAMES)
def test_hot_loops_are_vectors_of_their_precision(name, precision):
    """
    Packed arithmetic, in the widest registers there are, and no other precision on the way.

    A literal such as 0.5 is a float64, and would silently take a float32 loop to half its lanes.
    Roots of float64 alone are begun in float32.
    """
    function, arguments = loops(precision)[name]
    # Compiled anew, as it is: code that is kept cannot be read.
    options = {name: value for name, value in function.targetoptions.items() if name != 'nopython'}
    anew = numba.njit(function.py_func, pipeline_class=function._compiler.pipeline_class,
                      **options)
    anew.compile(tuple(numba.typeof(one) for one in arguments))
    code = next(iter(anew.inspect_asm().values()))
    packed = {'float64': 'pd', 'float32': 'ps'}[precision]
    register = 'zmm' if get_host_cpu_features().get('avx512f') else '[xy]mm'
    stores = re.findall(rf'\bv?mov[au]{packed}\s+%{register}\d+, \S*\(', code)
    assert len(stores) >= 1
    if name != 'flag_sim.cloth.forces._set_weights':
        assert re.search(rf'\bv?\w*(mul|add|sub|div)\w*{packed}\s.*%{register}', code)
    if precision == 'float32':
        assert not re.search(r'\bv?(cvtss2sd|cvtps2pd)\b', code)
