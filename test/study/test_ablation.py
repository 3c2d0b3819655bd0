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

"""Terms that act change the picture, those that cannot change nothing, and rows resume."""

from flag_sim.cloth import Air, Cloth, Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.model import Model
from flag_sim.cloth.state import State
from flag_sim.declarations.factories import cloth_of
from flag_sim.study import plots, runner
from flag_sim.study.measures import ablation_runs, behaves, rests
from flag_sim.study.measures.ablation_runs import AblationRuns
from flag_sim.study.measures.ablation_terms import (
    CONTROL, finer, in_true_wind, settings_of, SHOTS, Term, TERMS, TrueWind)
from flag_sim.study.measures.settings import defaults
from flag_sim.study.sections import ablation
from flag_sim.study.store import Store
import numpy as np
import pytest
from support.budgets import FewRows
from support.forces import crumpled, forces

SMALL = {'grid.rows': 6, 'grid.columns': 10, 'width': 160, 'height': 120}
BY_NAME = {term.name: term for term in TERMS}
TIMES = {f'{word}_{which}' for word in ('ms', 'spread_ms') for which in ('with', 'without')}


@pytest.fixture(autouse=True)
def short(monkeypatch):
    """Shorten the long runs from 20 s to 2 s, and the stilling."""
    for module, name, value in ((ablation_runs, 'LENGTH', 2.0), (ablation_runs, 'SETTLE', 1.0),
                                (rests, 'STILLED', 1.0), (rests, 'FREE', 1.0)):
        monkeypatch.setattr(module, name, value)


def measured(name, shot='fresh', **others):
    """Measure a term of a small flag in a small picture."""
    return AblationRuns(BY_NAME[name], {**SHOTS[shot], **SMALL, **others}).measured()


def stored(folder, row):
    """Return a store with a row of the ablation."""
    store = Store(folder, {})
    store.add(ablation.NAME, {'key': 'x', **row})
    return store


@pytest.mark.parametrize('term', TERMS, ids=lambda term: term.name)
def test_one_of_on_and_off_is_the_default_and_the_reason_says_which(term):
    """And the parameters of the other one exist, and are other than the default."""
    changes = {**term.on, **term.off}
    assert not (term.on and term.off)
    assert (bool(changes) or bool(term.replace)) == (term.name != CONTROL)
    for name, value in changes.items():
        assert defaults()[name] != value
    if term.name != CONTROL:
        assert term.why.startswith('off: ' if term.on else 'on: ')
    for shot in term.shots:
        settings_of(term, SHOTS[shot])  # raises for an unknown parameter


def test_without_gravity_the_flag_does_not_sink():
    """0.2 m in 0.2 s of free fall would be some 35 pixels here; the wind bears part of it."""
    row = measured('gravity', 'calm')
    assert 1.0 < row['px_rms'] < row['px_worst'] < 80.0
    assert row['behaves'] > behaves.WITHIN
    assert row['changed'] > 0.02 and row['levels'] > 1.0


def test_the_control_changes_nothing_until_chaos_does():
    """A nanometre is 1e-7 of a pixel here, and grows at most a few thousand times in a window."""
    row = measured(CONTROL)
    assert 0.0 < row['px_worst'] < 1e-3
    assert row['changed'] < 1e-3


def test_the_pole_collision_acts_where_the_cloth_meets_the_pole_alone():
    """In the default wind the cells at the hoist seldom do; the rest is what they pass on."""
    away, behind = measured('pole collision'), measured('pole collision', 'behind')
    assert away['px_rms'] < 0.1 * behind['px_rms'] and away['px_worst'] < 0.5
    assert behind['px_rms'] > 0.1 and behind['changed'] > 0.001


def test_what_is_out_of_the_picture_changes_none():
    """The default camera does not see the platform; a term of the light moves no vertex."""
    near, far = measured('platform'), measured('platform', 'whole pole')
    assert near['changed'] == near['levels'] == 0.0 < far['changed']
    assert near['px_rms'] is near['behaves'] is near['rests'] is None


def test_transmission_is_seen_against_the_sun():
    """From the sun's side little of the back shows."""
    front, back = measured('transmission'), measured('transmission', 'against the sun')
    assert back['levels'] > 5.0 * front['levels']


def test_what_a_first_frame_makes_ready_is_not_timed(monkeypatch):
    """A node makes it once, and not in every frame."""
    runs, seen, advance = AblationRuns(BY_NAME['gravity'], SMALL), [], Cloth.advance
    start = runs.starts(1)[0]
    monkeypatch.setattr(Cloth, 'advance', lambda *some: (seen.append('move'), advance(*some)))
    monkeypatch.setattr(ablation_runs.time, 'process_time', lambda: float(
        seen.append('clock') or len(seen)))
    runs.times(start)
    assert seen[:4] == ['move', 'clock', 'move', 'clock'] and seen == seen[:4] * (len(seen) // 4)


def test_all_but_times_is_the_same_again():
    """Numbers are of the shot, not of the run."""
    one, other = measured('damping'), measured('damping')
    assert {name: value for name, value in one.items() if name not in TIMES} == {
        name: value for name, value in other.items() if name not in TIMES}
    assert all(one[name] > 0.0 for name in TIMES)


def test_a_run_that_diverges_is_told_by_dashes(tmp_path):
    """And neither ends the study nor lends its numbers to the others."""
    storm = Term('storm', {}, {'solver': 'seed', 'area_density': 1e-6, 'stretch_limit': 1e6,
                               'speed': 200.0, 'substeps_limit': 5}, ('fresh',), 'on: ')
    row = AblationRuns(storm, SMALL).measured()
    assert row['px_rms'] is row['behaves'] is row['levels'] is row['changed'] is None
    text = ablation.text(stored(tmp_path, {**row, 'term': 'wind', 'shot': 'fresh'}))
    assert '| wind | fresh | – | – | – | – |' in text


@pytest.mark.parametrize('name, shot', [
    (name, shot) for name in ("wind law, else the course project's",
                              'square of the wind, else linear') for shot in BY_NAME[name].shots])
def test_another_law_presses_as_hard(name, shot):
    """On a sheet square to the shot's wind: the sum of all forces, exact but for rounding."""
    push = []
    for settings in settings_of(BY_NAME[name], SHOTS[shot]):
        cloth = cloth_of(settings | {'start_noise': 0.0})
        push.append(forces(Model(cloth.mesh, cloth.material), cloth.positions,
                           wind=(0.0, settings['speed'], 0.0), air=cloth.air)[..., 1].sum())
    assert push[0] == pytest.approx(push[1], rel=1e-9)
    assert push[0] > 10.0


def flying(make=lambda cloth: cloth, velocity=0.0, **changes):
    """Return a Cloth in a frame's wind after one frame of one step, from a crumpled start."""
    settings = defaults(grid__rows=6, grid__columns=10, substeps=0, **changes)
    cloth = make(cloth_of(settings))
    positions, velocities = crumpled(cloth.mesh)
    cloth.place(positions, velocity * velocities)
    cloth.advance(1e-4, (6.0, 2.0, 0.0))
    return cloth


def test_the_true_wind_is_the_quadratic_law_without_the_velocity_of_the_cloth():
    """The wind's force on a moving sheet is that of the law on the same sheet at rest."""
    cloth = cloth_of(defaults(grid__rows=6, grid__columns=10))
    positions, velocities = crumpled(cloth.mesh)
    wind = (6.0, 2.0, 0.0)
    state = State(cloth.mesh)
    state.place(positions, velocities)
    model = Model(cloth.mesh, Material(stiffness=0.0, shear_stiffness=0.0, bend_stiffness=0.0,
                                       damping=0.0))
    found = np.stack([cloth.mesh.grid(axis) for axis in TrueWind(model).wind_force(
        state, Forcing(wind))], axis=-1)
    assert np.array_equal(found, forces(model, positions, wind=wind, air=Air()))
    assert not np.allclose(found, forces(model, positions, velocities, wind, air=Air()), rtol=0.1)


@pytest.mark.parametrize('node_damping', [0.0, 500.0])
def test_nothing_but_the_wind_is_another_in_the_true_wind(node_damping):
    """
    Without wind both steps are the same to the bit.

    In wind and at rest they part by the drag's implicit part, r / (1 + r) of the wind's gain in
    speed, r = dt (1/m dF/du) = 1e-4 * 2 * 0.7 * 7 / 0.1, 1 %: here is asked that 2 % be enough.
    """
    still = {'air__density': 0.0, 'node_damping': node_damping}
    one, other = flying(**still, velocity=1.0), flying(in_true_wind, 1.0, **still)
    assert np.array_equal(one.positions, other.positions)
    assert np.array_equal(one.velocities, other.velocities)
    base, one, other = (flying(make, node_damping=node_damping, **air) for make, air in (
        (in_true_wind, {'air__density': 0.0}), (lambda cloth: cloth, {}),
        (in_true_wind, {})))
    for what in ('positions', 'velocities'):
        start, default, true = (getattr(cloth, what) for cloth in (base, one, other))
        gain = np.abs(default - start).max()
        assert gain > 0.0
        assert 0.0 < np.abs(true - default).max() < 0.02 * gain


def test_a_wind_that_does_not_know_the_velocity_moves_the_cloth_more(tmp_path):
    """Its brake is gone; and it has no time, since no user can have it."""
    row = measured('wind relative to the cloth')
    # In gusts, as runs of a steady wind would all be one.
    assert row['px_rms'] > 1.0 and behaves.WITHIN < row['behaves'] < 1000.0
    assert all(row[name] is None for name in TIMES)
    key = {'term': 'wind relative to the cloth', 'shot': 'fresh'}
    assert '| – | – | on: the air brakes' in ablation.text(stored(tmp_path, key | row))


def test_runs_on_nested_grids_begin_in_the_same_state():
    """Every node of the coarse grid is one of the fine, and dashpots are the same sheet's."""
    runs = AblationRuns(BY_NAME['finer grid'], {})
    start = runs.starts(1)[0]
    fine, coarse = (runs.begin(which, start) for which in range(2))
    assert fine.positions.shape[:2] == (41, 61) == (finer()['grid.rows'], finer()['grid.columns'])
    for what in ('positions', 'velocities'):
        assert np.array_equal(getattr(fine, what)[::2, ::2], getattr(coarse, what))
    # A sheet's dashpots, in N s/m across the cells that lie beside one another: the same.
    dashpots = [Model(cloth.mesh, cloth.material).spring_c[0] for cloth in (fine, coarse)]
    assert dashpots[0] == pytest.approx(dashpots[1])


def test_an_interrupted_ablation_goes_on_where_it_was(tmp_path, monkeypatch):
    """Rows are those of the first shots, then of the others, each once."""
    monkeypatch.setattr(ablation, 'measured', lambda term, shot: {'px_rms': len(shot)})
    for rows in (5, 7, 1000):
        store = Store(tmp_path, {})
        runner.measure(ablation, store, FewRows(rows))
        keys = [row['key'] for row in store.rows(ablation.NAME)]
        assert keys[:5] == [f'{term.name}/{term.shots[0]}' for term in TERMS[:5]]
    assert sorted(keys) == sorted(f'{term.name}/{shot}' for term in TERMS for shot in term.shots)


@pytest.mark.skipif(not plots.can_draw(), reason='matplotlib is not installed')
def test_the_plots_show_what_was_measured(tmp_path):
    """Not with a row alone: a plot of one point is none."""
    row = {'term': 'ambient', 'shot': 'fresh', **measured('ambient')}
    store = stored(tmp_path, row)
    assert not list(ablation.plots(store))
    store.add(ablation.NAME, {'key': 'y', **row, 'term': 'sun'})
    for name, sentence in ablation.plots(store):
        assert (tmp_path / name).read_bytes()[:4] == b'\x89PNG'
        assert sentence
