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

"""Which settings are taken, from tables of costs that are made up."""
import math
from pathlib import Path

from flag_sim.declarations.factories import cloth_of
from flag_sim.study import search, settings_file
from flag_sim.study.measures import ranking, summary
from flag_sim.study.measures.reference import on_grid
from flag_sim.study.measures.settings import defaults
from flag_sim.study.search import MARGIN, predicted
from hypothesis import given, strategies as st
import numpy as np
import pytest
from scipy import stats
import yaml

CONFIG = Path(__file__).parents[2] / 'config'
VALUES = st.floats(0.01, 100.0)
TABLES = st.lists(st.tuples(VALUES, VALUES), min_size=1, max_size=30)


@given(TABLES, st.sampled_from([0.0, 0.05, 0.3]), st.sampled_from([0.0, 1.0, 20.0]))
def test_the_frontier_as_by_brute_force(table, same, least):
    """All of it are best for their cost; whoever is left out is beaten as the rule says."""
    found = ranking.frontier(table, same, least)
    assert [table[n] for n in found] == sorted(table[n] for n in found)
    better = 1.0 - ranking.MIN_GAIN
    for n, (cost, error) in enumerate(table):
        beaten = any(table[k][0] <= cost
                     and min(better * table[k][1], table[k][1] - least) <= error
                     for k in found if k != n)
        beaten |= any(cost <= dearer <= (1.0 + same) * cost and other < error
                      and error - other >= least for dearer, other in table)
        assert (n in found) == (not beaten)


def test_what_the_reference_cannot_tell_apart_is_tied():
    """The dearer of two that differ by less is no gain, and both have one rank."""
    points = [(1.0, 14.0), (2.0, 11.0), (3.0, 4.0), (4.0, 3.0)]
    assert ranking.frontier(points, 0.0) == [0, 1, 2, 3]
    assert ranking.frontier(points, 0.0, 5.0) == [0, 2]
    named = dict(zip('abcd', (error for _, error in points)))
    assert ranking.ranks(named, 0.0) == {'d': 1, 'c': 2, 'b': 3, 'a': 4}
    assert ranking.ranks(named, 5.0) == {'d': 1, 'c': 1, 'b': 3, 'a': 3}
    assert ranking.ranks({'a': 1.0, 'b': 1.0}, 0.0) == {'a': 1, 'b': 1}


def test_kendalls_tau_is_that_of_scipy():
    """Of rankings without ties and with some; of one thing there is none."""
    source = np.random.default_rng(2)
    one, other = source.random(12), source.random(12)
    assert ranking.kendall(one, other) == pytest.approx(stats.kendalltau(one, other).statistic)
    assert ranking.kendall(one, one) == 1.0 and ranking.kendall(one, -one) == -1.0
    assert ranking.kendall([1.0], [2.0]) is None
    tied = np.array([1.0, 1.0, 2.0, 5.0, 5.0]), np.array([3.0, 2.0, 2.0, 9.0, 7.0])
    assert ranking.kendall(*tied) == pytest.approx(stats.kendalltau(*tied).statistic)
    assert ranking.kendall([1.0, 1.4, 2.0], [1.4, 1.0, 2.0], 0.5) == 1.0
    assert ranking.kendall([1.0, 1.1], [3.0, 9.0], 0.5) is None


def test_pairs_in_another_order_are_named():
    """But for those that are tied in one of both."""
    one, other = {'a': 1.0, 'b': 5.0, 'c': 9.0}, {'a': 9.0, 'b': 5.0, 'c': 6.0}
    assert ranking.reversed_pairs(one, other, 0.0) == [('a', 'b'), ('a', 'c')]
    assert ranking.reversed_pairs(one, other, 4.0) == [('a', 'b')]


def test_the_own_error_of_a_reference_as_of_a_series_of_grids():
    """Errors that are halved with the spacing, or quartered, are found but for the safety."""
    for ratio in (2.0, 4.0):
        exact = [10.0 / ratio**n for n in range(3)]  # of a quarter, of half, of the reference
        found = ranking.own_error(exact[0] - exact[1], exact[1] - exact[2])
        assert found == pytest.approx(ranking.SAFETY * exact[2])
    # Neither slower than theory has it, where both have all but reached the horizon, nor faster.
    assert ranking.own_error(1.0, 1.0) == ranking.own_error(2.0, 1.0)
    assert ranking.own_error(99.0, 1.0) == ranking.own_error(4.0, 1.0)
    assert ranking.own_error(0.0, 0.0) == 0.0


def timings(source, turns, scatter, settings=60, drift=0.0, pause=0.0):
    """
    Return rows of times [ms] of settings that all cost the same but for chance.

    scatter: of each time; drift: of whole turns; pause: share of times that are ten times longer.
    """
    logs = source.normal(0.0, scatter, (settings, turns)) + source.normal(0.0, drift, turns)
    logs += math.log(10.0) * (source.random((settings, turns)) < pause)
    return [{'setting': name, 'turn': turn, 'physics_ms': 0.5 * cost, 'drawing_ms': 0.5 * cost}
            for turn, costs in enumerate(np.exp(logs.T).tolist())
            for name, cost in enumerate(costs)]


def medians(rows):
    """Return the median time of each setting, as an array."""
    return np.array([summary.quartiles(some, *summary.COST)[1]
                     for some in summary.grouped(rows, 'setting').values()])


@pytest.mark.parametrize('turns', [2, 5, 9])
@pytest.mark.parametrize('disturbance', [{}, {'drift': 0.3}, {'pause': 0.03}], ids=str)
def test_equal_costs_are_told_apart_as_seldom_as_is_said(turns, disturbance):
    """
    Of pairs of settings of one cost, 1 in 20 differs by more than the resolution.

    Two standard deviations are 4.6 %; fewer with few turns, whose median is better than the
    sqrt(pi / 2) of many: of two it is the mean, 2.5 deviations, 1.2 %, and 1.35 % as 60 pairs of
    turns know the scatter to 8 %. Pauses that hit half of a
    setting's two times move its median, 6 % of them.
    """
    source, apart, pairs = np.random.default_rng(3), 0, 0
    for _ in range(40):
        rows = timings(source, turns, 0.04, **disturbance)
        times = np.sort(medians(summary.leveled(rows)))
        one, other = np.triu_indices(len(times), 1)
        apart += np.sum(times[other] > times[one] * (1.0 + summary.resolution(rows)))
        pairs += len(one)
    expected = {2: 0.0135, 5: 0.037, 9: 0.041}[turns]
    if disturbance.get('pause') and turns == 2:
        # A setting is hit with 1 - 0.97^2 = 5.9 %, and then differs from all that are not.
        expected = 2.0 * 0.059 * 0.941 + 0.0135
    assert apart / pairs == pytest.approx(expected, rel=0.3)


def test_the_resolution_follows_the_noise():
    """Twice the scatter, twice the resolution; four times the turns, half of it; none of none."""
    source = np.random.default_rng(4)

    def found(turns, scatter):
        return np.mean([summary.resolution(timings(source, turns, scatter)) for _ in range(20)])

    # 60 settings of 4 turns each know their scatter to some 6 %, 20 runs to 1.5 %.
    assert found(4, 0.04) == pytest.approx(2.0 * found(4, 0.02), rel=0.1)
    assert found(4, 0.02) == pytest.approx(2.0 * found(16, 0.02), rel=0.15)
    assert found(4, 0.0) == 0.0
    times = summary.leveled(timings(source, 5, 0.0, drift=0.3))
    assert np.ptp([row['physics_ms'] for row in times]) < 1e-12
    diverged = [{'setting': 'a', 'turn': turn, 'physics_ms': None, 'drawing_ms': None}
                for turn in range(3)]
    quiet = timings(source, 3, 0.02)
    assert summary.resolution(quiet + diverged) == summary.resolution(quiet)
    assert summary.leveled(quiet + diverged)[:180] == summary.leveled(quiet)
    assert summary.resolution(diverged) == 0.0
    assert summary.leveled(diverged) == diverged
    assert summary.resolution(quiet[:60]) == 0.0  # one turn does not know


def test_predictions_hold_for_new_shots(monkeypatch):
    """Of shots that scatter normally 1 in 10 is above what some others predict."""
    monkeypatch.setattr(search, 'SCATTER', 0.0)
    source = np.random.default_rng(5)
    above = 0
    for _ in range(2000):
        squares = np.abs(source.normal(8.0, 1.0, 7))
        shots = np.sqrt(squares[:6, None] * [0.5, 1.5])  # of windows that differ much
        above += math.sqrt(squares[6]) > predicted(shots)
    # Student's t with 5 degrees of freedom exceeds 1.5 in 9.7 of 100; 2000 draws: +-0.7 each.
    assert 0.08 < above / 2000 < 0.115


def test_the_error_of_the_reference_is_added():
    """As squares, as it is independent of that of the settings."""
    alone = predicted(np.full((6, 2), 4.0))
    assert alone == pytest.approx(4.0 * math.sqrt(1.0 + MARGIN * search.SCATTER))
    assert predicted(np.full((6, 2), 4.0), 3.0) == pytest.approx(math.hypot(alone, 3.0))


def test_a_diverged_window_is_never_good():
    """One that left the bounds spoils the settings."""
    assert predicted(np.array([[1.0], [math.inf], [1.0]]), 3.0) == math.inf


def test_rows_of_unfinished_turns_do_not_count():
    """Only turns that all settings took are compared."""
    rows = [{'setting': name, 'turn': turn, 'x': 3.0 + turn} for turn in (0, 1)
            for name in 'ab'][:3]
    assert summary.complete(rows, 'setting') == rows[:2]
    assert summary.complete(rows[:1], 'setting') == rows[:1]
    assert summary.total(rows, 'x') == pytest.approx(math.sqrt((9 + 9 + 16) / 3))
    assert summary.total([*rows, {'x': None}], 'x') == math.inf
    assert summary.quartiles([{'x': None}], 'x') is None


def test_params_files_are_read_as_nodes_read_them(tmp_path):
    """Nested or dotted, for one node or for all; what the study does not know is named."""
    path = tmp_path / 'mine.yaml'
    path.write_text('/**:\n  ros__parameters:\n    pole.height: 12.0\n'
                    '/cam/renderer:\n  ros__parameters:\n    camera: {distance: 3.0}\n'
                    '    threads: 2\n'
                    '/wind:\n  ros__parameters:\n    pace: lockstep\n')
    settings, others = settings_file.read(path)
    assert (settings['pole.height'], settings['camera.distance']) == (12.0, 3.0)
    assert settings['drawing.threads'] == 2
    assert others == ['wind.pace']
    for text in ('[1]', '/wind: 3', 'a: [', ''):
        path.write_text(text)
        with pytest.raises(ValueError, match='is not'):
            settings_file.read(path)
    with pytest.raises(ValueError, match='cannot be read'):
        settings_file.read(tmp_path / 'none.yaml')


@pytest.mark.parametrize('name', ['preview', 'balanced', 'accurate'])
def test_a_preset_is_the_same_sheet_on_its_grid(name):
    """The ratio of damping goes with the columns, and a node would take every value."""
    found, others = settings_file.read(CONFIG / f'{name}.yaml')
    own = on_grid(defaults(), found['grid.rows'], found['grid.columns'])
    assert found['damping'] == pytest.approx(own['damping'])
    assert not others
    cloth_of(found)


def test_a_written_file_keeps_types(tmp_path):
    """A float without decimals must not become a whole number, which ROS refuses."""
    path, work = tmp_path / 'new.yaml', tmp_path / 'work'
    work.mkdir()
    values = {'a': 60.0, 'b': 0.05, 'c': 31, 'd': 'symplectic', 'e': 1e-3 / 3.0, 'f': 1e9}
    settings_file.write(path, ['what', '', 'it is'], {'physics': values}, work)
    assert path.read_text().startswith('# what\n#\n# it is\n/**/physics:\n')
    known = yaml.safe_load(path.read_text())['/**/physics']['ros__parameters']
    assert known == pytest.approx(values, abs=1e-6)
    assert [type(value) for value in known.values()] == [type(v) for v in values.values()]
    with pytest.raises(FileExistsError):
        settings_file.write(path, [], {}, work)
    with pytest.raises(ValueError, match='exists'):
        settings_file.check_new(path)
    with pytest.raises(ValueError, match='no folder'):
        settings_file.check_new(tmp_path / 'none' / 'x.yaml')
    assert sorted(p.name for p in tmp_path.iterdir()) == ['new.yaml', 'work']
    assert MARGIN > 0.0
