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

"""What a cloth is given that is wrong: it is refused, and the cloth goes on as before."""
import math

from flag_sim.cloth import Cloth, Diverged, Material, Stepping
from flag_sim.cloth.divergence import validate
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.state import State
import numpy as np
import pytest
from support.cloths import running, WIND


def test_a_bad_state_is_not_let_out():
    """The frame's start is held, the reason is told, and the cloth goes on after a reset."""
    cloth = running()
    fast = np.zeros((9, 13, 3))
    fast[4, 5] = 1e11
    cloth.place(cloth.positions, fast)
    start = cloth.positions
    with pytest.raises(Diverged, match='beyond'):
        cloth.advance(0.02, WIND)
    assert np.array_equal(cloth.positions, start)
    cloth.reset()
    cloth.advance(0.02, WIND)
    assert np.isfinite(cloth.positions).all()


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf, 1e10])
@pytest.mark.parametrize('row, what', [(0, 'position'), (2, 'position'), (5, 'velocity')])
def test_one_bad_number_breaks_a_bound(row, what, value):
    """Not a number is out of bounds too, although it compares with nothing."""
    state = State(Mesh(3, 4, 1.0, 1.0))
    validate(state)
    state.mesh.grid(state.data[row])[1, 2] = value
    with pytest.raises(Diverged, match=f'a {what} is not finite or beyond'):
        validate(state)


@pytest.mark.parametrize('arguments, rule', [
    ({'rows': 1}, 'rows must be a whole number from 2'),
    ({'columns': 0}, 'columns must be a whole number from 2'),
    ({'rows': 2.5}, 'rows must be a whole number from 2 to 1001 [nodes], not 2.5'),
    ({'rows': 100000, 'columns': 100000},
     'rows must be a whole number from 2 to 1001 [nodes], not 100000'),
    ({'length': 0.0}, 'length must be between'),
    ({'width': math.nan}, 'width must be finite, not nan'),
    ({'hoist_top': (0.0, 1.0)}, 'hoist_top must have shape (3,), not (2,)'),
    ({'hoist_top': (0.0, 1.0, math.inf)},
     'hoist_top must be finite and at most 1e+06 in size, not inf'),
    ({'hoist_top': ('0', '1', '2')}, 'hoist_top must hold numbers, not'),
    ({'gravity': math.nan}, 'gravity must be a number from 0 to 1000 [m/s2], not nan'),
    ({'solver': 'magic'}, "seed, not 'magic'")])
def test_bad_cloths_are_refused(arguments, rule):
    """The message names the rule and the value."""
    with pytest.raises(ValueError) as error:
        Cloth(**arguments)
    assert rule in str(error.value)


@pytest.mark.parametrize('change, rule', [
    (lambda cloth: cloth.advance(0.0), 'dt must be greater than 0 and at most 3600, not 0'),
    (lambda cloth: cloth.advance(-0.1), 'dt must be greater than 0 and at most 3600, not -0.1'),
    (lambda cloth: cloth.advance(math.nan), 'dt must be finite, not nan'),
    (lambda cloth: cloth.advance(1e6), 'dt must be greater than 0 and at most 3600, not 1e+06'),
    (lambda cloth: cloth.advance(0.02, (1.0, 2.0)), 'wind must have shape (3,), not (2,)'),
    (lambda cloth: cloth.advance(0.02, (1.0, 2.0, math.nan)), 'wind must be finite'),
    (lambda cloth: cloth.advance(0.02, (0.0, 1e5, 0.0)), 'wind must be finite and at most 10000'),
    (lambda cloth: cloth.advance(0.02, 'north'), "wind must hold numbers, not 'north'"),
    (lambda cloth: cloth.regrid(1, 5), 'rows must be a whole number from 2'),
    (lambda cloth: cloth.hang((0.0, 0.0, 1.0), -1.0, 1.0), 'length must be between'),
    (lambda cloth: cloth.place(np.zeros((2, 2, 3))), 'positions must have shape (9, 13, 3)'),
    (lambda cloth: cloth.place(cloth.positions, np.full((9, 13, 3), np.nan)),
     'velocities must be finite'),
    (lambda cloth: setattr(cloth, 'solver', 'magic'), 'solver must be one of'),
    (lambda cloth: setattr(cloth, 'solver', ['rk4']), "not ['rk4']"),
    (lambda cloth: setattr(cloth, 'material', None), 'material must be of class Material'),
    (lambda cloth: setattr(cloth, 'air', 'storm'), "air must be of class Air, not 'storm'"),
    (lambda cloth: setattr(cloth, 'stepping', 5), 'stepping must be of class Stepping, not 5'),
    (lambda cloth: setattr(cloth, 'precision', 'float16'), 'precision must be one of'),
    (lambda cloth: setattr(cloth, 'stretch_limit', -1.0), 'stretch_limit must be a number from 0'),
    (lambda cloth: setattr(cloth, 'pole', (0.0, 0.0, 0.0)), 'radius of the pole must be greater'),
    (lambda cloth: setattr(cloth, 'gravity', 'down'),
     "gravity must be a number from 0 to 1000 [m/s2], not 'down'")])
def test_bad_changes_are_refused_and_change_nothing(change, rule):
    """The cloth goes on exactly as if they had not been asked for."""
    cloth, same = running(3), running(3)
    with pytest.raises(ValueError) as error:
        change(cloth)
    assert rule in str(error.value)
    cloth.advance(0.02, WIND)
    same.advance(0.02, WIND)
    assert np.array_equal(cloth.positions, same.positions)


@pytest.mark.parametrize('change', [
    lambda cloth: setattr(cloth, 'material', Material(stiffness=5.0)),
    lambda cloth: setattr(cloth, 'solver', 'rk4'),
    lambda cloth: setattr(cloth, 'precision', 'float32'),
    lambda cloth: cloth.regrid(5, 7),
    lambda cloth: cloth.hang((1.0, 2.0, 3.0), 2.0, 1.0)])
def test_a_change_that_memory_does_not_suffice_for_changes_nothing(change, monkeypatch):
    """Not even in part: what is new is made before anything old is given up."""
    cloth, same = running(3), running(3)

    def fail(*arguments):
        raise MemoryError

    with monkeypatch.context() as patch:
        for kind in SOLVERS.values():
            patch.setattr(kind, '__init__', fail)
        with pytest.raises(MemoryError):
            change(cloth)
    assert cloth.material == same.material and cloth.solver == same.solver
    assert cloth.mesh.precision == same.mesh.precision and cloth.hoist_top == same.hoist_top
    cloth.advance(0.02, WIND)
    same.advance(0.02, WIND)
    assert np.array_equal(cloth.positions, same.positions)


def test_whole_numbers_of_steps_may_come_as_floats():
    """The compiled loops over them would not take one."""
    stepping = Stepping(substeps=30.0, substeps_limit=100.0)
    assert [type(stepping.substeps), type(stepping.substeps_limit)] == [int, int]
    assert Cloth(3, 3, stepping=stepping).advance(0.01, WIND).granted == 30
    with pytest.raises(ValueError, match='substeps must be a whole number from 0 .*, not 3.5'):
        Stepping(substeps=3.5)
