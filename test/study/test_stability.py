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

"""Measured limits against eigenvalues and bounds, outcomes of known cases, maps that resume."""
import math

from flag_sim.cloth import Air, Cloth, Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.model import Model
from flag_sim.declarations.nodes import NODES
from flag_sim.study import plots, runner, stability_plots
from flag_sim.study.measures import settings, stability_trial as trial
from flag_sim.study.sections import stability_maps as maps
from flag_sim.study.store import Store
import numpy as np
import pytest
from support import limits
from support.budgets import FewRows
from support.forces import jacobian, largest_eigenvalue

PROMISING = ('symplectic', 'verlet', 'rk4')
"""Methods whose bound is a promise."""


@pytest.fixture(scope='module')
def omega():
    """Return the greatest frequency [rad/s] of the undamped trial at rest, an eigenvalue."""
    model = Model(trial.MESH, limits.MATERIALS['undamped'])
    rest = trial.MESH.rest((0.0, 0.0, 0.0))
    matrix = jacobian(model, rest, np.zeros_like(rest), 'positions')
    return math.sqrt(largest_eigenvalue(model, matrix, trial.MESH.grid(trial.MESH.free)))


@pytest.mark.parametrize('solver, reach', [('symplectic', 2.0), ('verlet', 2.0), ('seed', 2.0),
                                           ('rk4', math.sqrt(8.0))])
def test_the_measured_limit_is_that_of_theory(solver, reach, omega):
    """
    Of an undamped mode: where the stability regions end on the imaginary axis.

    The bisection is exact to 0.5 %; half a percent beyond its limit the slowest to grow, rk4,
    does so by 3 % a step, far more than it needs in 500 steps.
    """
    _, limit = limits.measured('undamped', solver, 'springs alone, first growth').values()
    assert limit * omega == pytest.approx(reach, rel=0.01)


@pytest.mark.parametrize('solver', PROMISING)
@pytest.mark.parametrize('material', limits.MATERIALS)
def test_no_measured_limit_is_below_the_bound(solver, material):
    """In still air and in wind; the bound gives away at most a factor of 2.4."""
    for forcing in ('springs alone, first growth', 'wind 40 m/s'):
        bound, limit = limits.measured(material, solver, forcing).values()
        assert bound <= limit <= 2.4 * bound


def test_a_method_without_a_limit_has_none_and_one_without_a_promise_breaks_it():
    """Among them implicit, unbounded by any step, and euler, by nature unstable when undamped."""
    assert limits.measured('undamped', 'implicit', 'wind 6 m/s') == {
        'bound_s': math.inf, 'limit_s': math.inf}
    bound, limit = limits.measured('undamped', 'euler', 'springs alone').values()
    assert limit < 0.5 * bound
    bound, limit = limits.measured('undamped', 'seed', 'wind 40 m/s').values()
    assert limit < bound


@pytest.mark.parametrize('solver', PROMISING)
def test_a_raw_method_is_stable_below_its_bound_and_diverges_far_above(solver):
    """The factor 2.4 is the one of the test above."""
    wind = Forcing(trial.wind_of(6.0))
    bound = trial.largest_step(solver, Material(), Air())
    assert trial.solver_alone(solver, Material(), wind, bound) == trial.STABLE
    assert trial.solver_alone(solver, Material(), wind, 2.4 * bound) == trial.DIVERGING


def test_a_raw_fall_is_no_divergence():
    """Kilometres in free fall are honest: nothing but gravity acts on cloth without springs."""
    fall = Forcing((0.0, 0.0, 0.0))
    limp = trial.sheet(0.0)
    assert trial.solver_alone('symplectic', limp, fall, 10.0) == trial.STABLE
    assert trial.solver_alone('symplectic', limp, fall, 10.0, far=1e5) == trial.DIVERGING


@pytest.mark.parametrize('solver, material, speed, dt, outcome', [
    ('symplectic', Material(), 6.0, 1.0 / 30.0, trial.STABLE),
    ('symplectic', trial.sheet(1e9), 6.0, 1.0, trial.SOFTENED),
    ('symplectic', trial.sheet(1e3, damping=1e6), 6.0, 0.1, trial.SOFTENED),
    ('symplectic', trial.sheet(0.0), 50.0, 0.1, trial.LIMITED),
    ('xpbd', trial.sheet(1e9), 6.0, 1.0, trial.SOFTENED),
    ('implicit', trial.sheet(1e9), 6.0, 1.0, trial.STABLE),
    ('seed', trial.sheet(1e9, 1e-6), 200.0, 1.0, trial.REFUSED)])
def test_outcomes_of_known_cases(solver, material, speed, dt, outcome):
    """Cases whose end is known without a map."""
    assert trial.through_cloth(solver, material, trial.wind_of(speed), dt) == outcome


def test_the_maps_cover_what_people_set_finely():
    """Stiffness from 1e2 to 1e5 N/m; at the last level a value is a third from the next."""
    for chart in maps.MAPS:
        for axis in (chart.x, chart.y):
            values = axis.values(maps.LEVELS - 1)
            assert values[0] == axis.low and values[-1] == pytest.approx(axis.high)
            assert max(np.diff(np.log10(values))) < 0.13
    assert (maps.STIFFNESS.low, maps.STIFFNESS.high) == (1e2, 1e5)
    declarations = {one.name: one for own in NODES.values() for one in own}
    for name, axis in (('stiffness', maps.STIFFNESS), ('damping', maps.DAMPING),
                       ('speed', maps.SPEED)):
        assert declarations[name].low <= axis.low <= axis.high <= declarations[name].high
    assert settings.MAX_GAP == declarations['max_gap'].default


def test_a_cloth_by_default_hangs_as_the_parameters_hang_it():
    """Cloth may not know of poles, so that its size and place are written twice: here held."""
    cloth = Cloth()
    assert cloth.hoist_top == pytest.approx(trial.HOIST_TOP)
    assert (cloth.mesh.length, cloth.mesh.width) == pytest.approx(
        (trial.LENGTH, trial.WIDTH))


@pytest.mark.parametrize('chart', [one for one in maps.MAPS if one.is_alone],
                         ids=lambda chart: chart.name)
def test_the_promise_holds_all_over_a_map(chart):
    """Every place of a coarse map where theory promises stability is stable."""
    kept = [(x, y) for x in chart.x.values(0) for y in chart.y.values(0)
            if chart.bound('verlet', x, y) >= 1.0]
    assert len(kept) > 15
    outcomes = {chart.outcome('verlet', *place) for place in kept}
    assert outcomes == {trial.STABLE}


def test_an_interrupted_map_goes_on_where_it_was(tmp_path):
    """With the same rows as without interruption, and a map is drawn once it is whole."""
    whole, parts = Store(tmp_path / 'whole', {}), Store(tmp_path / 'parts', {})
    runner.measure(maps, whole, FewRows(7))
    runner.measure(maps, parts, FewRows(3))
    assert maps.finest(parts.rows(maps.NAME)) == {} and maps.text(parts) == ''
    parts = Store(tmp_path / 'parts', {})
    runner.measure(maps, parts, FewRows(4))
    rows = parts.rows(maps.NAME)
    assert rows == whole.rows(maps.NAME)
    assert [*maps.finest(rows)] == ['steps']
    assert [*maps.finest(rows)['steps']] == ['symplectic']
    table, missing = maps.text(parts).splitlines()[-3::2]
    assert '0 of' in table
    assert 'steps of verlet, rk4' in missing and 'symplectic, verlet' in missing
    if plots.can_draw():
        assert [(parts.folder / name).read_bytes()[:4] for name, _ in
                maps.plots(parts)] == [b'\x89PNG']


def test_the_finest_whole_level_is_shown():
    """A level that is not finished is not mixed with the one before it."""
    axis = maps.BY_NAME['steps'].y
    rows = [{'chart': 'steps', 'solver': 'rk4', 'level': level, 'y': y, 'cells': 's'}
            for level in (0, 1) for y in axis.values(level)]
    assert {row['level'] for row in maps.finest(rows)['steps']['rk4']} == {1}
    assert {row['level'] for row in maps.finest(rows[:-1])['steps']['rk4']} == {0}


def test_letters_tell_the_outcomes_apart():
    """Each outcome has its letter, its colour and its words."""
    for different in zip(*trial.OUTCOMES):
        assert len(set(different)) == len(trial.OUTCOMES)
    assert len(set(stability_plots.COLORS.values())) == len(trial.OUTCOMES)
    assert set(stability_plots.COLORS) == set(trial.OUTCOMES)
