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

"""Tune, from the command to a params file that the nodes would take, and what can go wrong."""
import re

from flag_sim.declarations.nodes import named
from flag_sim.study import machine, search, tune
from flag_sim.study.measures import judge
from flag_sim.study.measures.judge import OTHER_GUSTS
import pytest
from support.judge_table import Table
from support.study import SMALL
import yaml


@pytest.fixture(autouse=True)
def small(monkeypatch, tmp_path):
    """Make everything small."""
    for module, name, value in SMALL:
        monkeypatch.setattr(module, name, value)
    (tmp_path / 'mine.yaml').write_text(
        '/wind:\n  ros__parameters:\n    speed: 7\n'
        '/renderer:\n  ros__parameters:\n    width: 64\n    height: 48\n'
        '    camera.target: [1, 0.0, 7.85]\n    outline: true\n')


@pytest.fixture
def table(monkeypatch):
    """Return a Table in the place of Judge; grids are nested in 121 x 81."""
    monkeypatch.setattr(judge, 'FINEST', (81, 121))
    monkeypatch.setattr(search, 'SHOTS', 3)
    monkeypatch.setattr(search, 'WINDOWS', 2)
    return Table(monkeypatch)


def assert_names_its_nodes(text):
    """Assert that a params file tells to give it to just those nodes that it has values for."""
    told = re.search('# Give it to (.*), after your own params file', text)[1]
    assert [f'/**/{node}' for node in re.split(', | and ', told)] == list(yaml.safe_load(text))


def run(folder, error_px, *more, rate=30.0):
    """Tune for a small picture into folder/tuned.yaml."""
    return tune.main(['--error-px', str(error_px), '--rate', str(rate), '--params-file',
                      str(folder / 'mine.yaml'), '--output', str(folder / 'tuned.yaml'), *more])


def refused(capsys, *arguments):
    """Return what tune says when it refuses its arguments."""
    with pytest.raises(SystemExit) as refusal:
        tune.main([str(argument) for argument in arguments])
    assert refusal.value.code == 2
    return capsys.readouterr().err


def chosen(folder):
    """Return the values of physics in folder/tuned.yaml."""
    return yaml.safe_load((folder / 'tuned.yaml').read_text())['/**/physics']['ros__parameters']


def test_the_file_is_one_that_the_nodes_take(tmp_path, capsys):
    """
    Every value is legal for its parameter and of its type; a coarse grid suffices for 20 px.

    It has the user's own parameters too: they are what its promise is for.
    """
    assert run(tmp_path, 20.0) == 0
    text = (tmp_path / 'tuned.yaml').read_text()
    out, err = capsys.readouterr()
    assert text == out and 'min on an idle machine' in err.splitlines()[0]
    assert '64 x 48' in text and '20 px are allowed.' in text and 'MISSED' not in text
    assert 'gusts of 0.3, where your shot has 0' in text
    for node, block in yaml.safe_load(text).items():
        declarations = named(node.rpartition('/')[2])
        for name, value in block['ros__parameters'].items():
            accepted = declarations[name].accept(value)
            assert accepted == value and type(accepted) is type(value), name
    wind, physics, renderer = (yaml.safe_load(text)[f'/**/{node}']['ros__parameters']
                               for node in ('wind', 'physics', 'renderer'))
    assert wind == {'speed': 7.0, 'rate': 30.0}
    assert renderer == {'width': 64, 'height': 48, 'camera.target': [1.0, 0.0, 7.85],
                        'outline': True}
    assert physics['grid.columns'] < 31
    assert [path.name for path in sorted(tmp_path.iterdir())] == ['mine.yaml', 'tuned.yaml']
    assert_names_its_nodes(text)


def test_the_promise_names_horizon_value_and_spread(table, tmp_path):
    """And all three measures, with what is allowed."""
    table.refuted = {16: 1.1}
    assert run(tmp_path, 12.5) == 0
    text = (tmp_path / 'tuned.yaml').read_text()
    assert chosen(tmp_path)['grid.columns'] == 16
    for words in ('6.7 px (RMS) after 0.2 s', '(6.2 to 6.9 px in 3', '12.5 px are allowed.',
                  'two converged runs part: 0.4 s.', 'its statistics are 1 times',
                  'Rests: 0.1 mm/s', 'Cost: 2.1 ms of processor time'):
        assert words in text, words


def test_the_error_of_the_reference_counts(table, tmp_path):
    """It is named, and what could be kept by the measured error alone is not taken for it."""
    assert run(tmp_path, 11.3) == 0  # 100 px over 16 columns, and 80 % for other shots
    assert chosen(tmp_path)['grid.columns'] == 16
    (tmp_path / 'tuned.yaml').unlink()
    table.own_px = 2.0
    assert run(tmp_path, 11.3) == 0
    assert chosen(tmp_path)['grid.columns'] == 25
    text = (tmp_path / 'tuned.yaml').read_text()
    # 4 px and 80 % on 25 columns, and the root of 7.2^2 + 2^2.
    assert 'the own error of the reference, 2 px' in text and '7.5 px.' in text
    (tmp_path / 'tuned.yaml').unlink()
    assert run(tmp_path, 1.9) == 1


def test_what_is_asked_for_beyond_the_horizon_is_said(table, tmp_path):
    """An error after two converged runs have parted is none of the settings'."""
    table.parted = 0.1
    assert run(tmp_path, 20.0) == 0
    assert 'THAT IS SOONER' in (tmp_path / 'tuned.yaml').read_text()


def test_finer_grids_are_tried_when_the_check_refutes_the_cheap_ones(table, tmp_path):
    """What keeps the budget in one shot and is wrong by far in the other is not the end."""
    table.refuted = dict.fromkeys((7, 13, 16), 30.0)
    assert run(tmp_path, 20.0) == 0
    assert chosen(tmp_path)['grid.columns'] == 25
    assert 'MISSED' not in (tmp_path / 'tuned.yaml').read_text()


@pytest.mark.parametrize('which', ['odd', 'restless'])
def test_what_does_not_behave_or_rest_is_passed_over(table, tmp_path, which):
    """However near it is after a fifth of a second."""
    setattr(table, which, (7, 13, 16))
    assert run(tmp_path, 20.0) == 0
    assert chosen(tmp_path)['grid.columns'] == 25
    (tmp_path / 'tuned.yaml').unlink()
    setattr(table, which, range(200))
    assert run(tmp_path, 20.0) == 1
    assert re.search('are allowed: MISSED|statics: MISSED',
                     (tmp_path / 'tuned.yaml').read_text())


def test_nothing_dearer_than_your_own_is_taken_where_they_keep_the_budget(table, tmp_path):
    """Although by a margin for other shots a finer grid would be safer."""
    limit = table.error_px / 31
    table.refuted = dict.fromkeys((7, 13, 16, 25, 37), 5.0)
    table.refuted[31] = 0.5
    assert run(tmp_path, 1.0001 * limit) == 0
    assert chosen(tmp_path)['grid.columns'] == 31


def test_of_what_is_no_dearer_than_your_own_the_safer_is_taken(table, tmp_path):
    """A finer grid in single precision, where your own keep the budget by less than the margin."""
    assert run(tmp_path, 1.0001 * table.error_px / 31) == 0
    values = chosen(tmp_path)
    assert (values['grid.columns'], values['precision']) == (37, 'float32')
    text = (tmp_path / 'tuned.yaml').read_text()
    assert 'MISSED' not in text and 'nothing dearer is taken' in text


def test_a_missed_budget_is_said_with_the_best_there_is(table, tmp_path):
    """Of the grids that are fast enough, the finest; and by how much it misses."""
    assert run(tmp_path, 1e-6) == 1
    text = (tmp_path / 'tuned.yaml').read_text()
    assert chosen(tmp_path)['grid.columns'] == 61
    assert '3 px: MISSED; nothing that was tried is better' in text
    (tmp_path / 'tuned.yaml').unlink()
    table.cost_ms = 20.0
    assert run(tmp_path, 1e-6, rate=30.0) == 1
    assert ': MISSED by' in (tmp_path / 'tuned.yaml').read_text()


def test_a_busy_machine_is_told(table, tmp_path, monkeypatch):
    """Costs are processor time all the same."""
    monkeypatch.setattr(machine.LoadMonitor, 'others', lambda self: 1.9)
    monkeypatch.setattr(machine, 'cores', lambda: 2)
    assert run(tmp_path, 20.0) == 0
    assert 'The machine was busy: others took 1.9' in (tmp_path / 'tuned.yaml').read_text()


def test_an_interrupted_run_goes_on(table, tmp_path, monkeypatch, capsys):
    """What was measured is not measured again, and the result is that of a whole run."""
    whole = search.Search._looked_at

    def interrupted(self, verdict):
        raise KeyboardInterrupt

    monkeypatch.setattr(search.Search, '_looked_at', interrupted)
    assert run(tmp_path, 7.5) == 130
    assert 'goes on from' in capsys.readouterr().err
    assert not (tmp_path / 'tuned.yaml').exists()
    monkeypatch.setattr(search.Search, '_looked_at', whole)
    before = list(table.seen)
    table.seen.clear()
    assert run(tmp_path, 7.5) == 0
    assert before and not set(table.seen) & set(before)
    assert not (tmp_path / 'tuned.yaml.unfinished').exists()


def test_all_shots_have_gusts_of_their_own(table, tmp_path):
    """The seeds differ, and each has all its windows."""
    run(tmp_path, 7.5)
    assert {(one[4], one[5]) for one in table.seen if one[0] == 16} == {
        (window, gusts * OTHER_GUSTS) for window in range(2) for gusts in range(3)}


def test_a_flag_that_leaves_the_picture_is_refused(tmp_path, capsys):
    """At rest its corner is in the picture, from which it falls at once."""
    (tmp_path / 'mine.yaml').write_text(
        '/renderer:\n  ros__parameters:\n    camera.target: [2.3, 0.0, 8.97]\n'
        '    camera.distance: 0.3\n')
    assert 'the camera does not see the flag' in refused(
        capsys, '--error-px', 1, '--params-file', tmp_path / 'mine.yaml', '--output',
        tmp_path / 'new.yaml')
    assert [path.name for path in tmp_path.iterdir()] == ['mine.yaml']


def test_what_cannot_be_is_refused(tmp_path, capsys):
    """Budgets that are none, files that exist, cameras that look away; nothing is left over."""
    new = tmp_path / 'new.yaml'
    for bad in ('0', '-1', 'nan', 'x'):
        assert f'must be a number above 0, not {bad}' in refused(
            capsys, '--error-px', bad, '--output', new)
    (tmp_path / 'old.yaml').write_text('mine')
    assert 'exists; it is not overwritten' in refused(
        capsys, '--error-px', 1, '--output', tmp_path / 'old.yaml')
    assert (tmp_path / 'old.yaml').read_text() == 'mine'
    assert 'there is no folder' in refused(
        capsys, '--error-px', 1, '--output', tmp_path / 'none' / 'new.yaml')
    away = tmp_path / 'away.yaml'
    away.write_text('/renderer:\n  ros__parameters:\n    camera.target: [1.1, 90.0, 7.85]\n')
    assert 'the camera does not see the flag' in refused(
        capsys, '--error-px', 1, '--params-file', away, '--output', new)
    assert 'rate must be at most 1000 Hz, not 1e+06' in refused(
        capsys, '--error-px', 1, '--rate', 1e6, '--output', new)
    assert 'seconds must be at most 1, not 3' in refused(
        capsys, '--error-px', 1, '--seconds', 3, '--output', new)
    away.write_text('/physics:\n  ros__parameters:\n    stiffness: 1.0e+9\n')
    assert 'nodes times steps a second, and this sheet needs' in refused(
        capsys, '--error-px', 1, '--params-file', away, '--output', new)
    away.write_text('/renderer:\n  ros__parameters:\n    width: -3\n')
    assert 'width must be' in refused(
        capsys, '--error-px', 1, '--params-file', away, '--output', new)
    away.write_text('/physics:\n  ros__parameters:\n    air.added_mass: 0.5\n')
    assert 'air.added_mass must be 0 here, not 0.5' in refused(
        capsys, '--error-px', 1, '--params-file', away, '--output', new)
    assert 'rate must be at most 1000 Hz, not 1000.0000001' in refused(
        capsys, '--error-px', 1, '--rate', 1000.0000001, '--output', new)
    for bad, words in ((tmp_path, 'Is a directory'), ('/dev/null', 'is not a file')):
        assert words in refused(
            capsys, '--error-px', 1, '--params-file', bad, '--output', new)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        'away.yaml', 'mine.yaml', 'old.yaml']
