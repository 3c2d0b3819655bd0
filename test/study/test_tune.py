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
from pathlib import Path
import re

from flag_sim.declarations.nodes import named
from flag_sim.study import search, tune
from flag_sim.study.measures.trials import Trials
from flag_sim.study.store import Store
import pytest
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


def test_the_file_is_one_that_the_nodes_take(tmp_path, capsys):
    """
    Every value is legal for its parameter and of its type; a coarse grid suffices for 20 px.

    It has the user's own parameters too: they are what its promise is for.
    """
    assert run(tmp_path, 20.0) == 0
    text = (tmp_path / 'tuned.yaml').read_text()
    assert text == capsys.readouterr().out
    assert '64 x 48' in text and '20 px are allowed.' in text and 'MISSED' not in text
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
    assert physics['grid.columns'] < 13
    assert [path.name for path in sorted(tmp_path.iterdir())] == ['mine.yaml', 'tuned.yaml']
    assert_names_its_nodes(text)


@pytest.mark.parametrize('preset', ['preview', 'accurate'])
def test_the_presets_name_their_nodes(preset):
    """As what it writes today does."""
    config = Path(__file__).resolve().parents[2] / 'config'
    assert_names_its_nodes((config / f'{preset}.yaml').read_text())


def test_a_budget_that_cannot_be_met_is_told(tmp_path):
    """The most accurate that keeps the rate is written, with what it misses."""
    assert run(tmp_path, 1e-6) == 1
    text = (tmp_path / 'tuned.yaml').read_text()
    assert 'MISSED: other shots may reach' in text
    assert 'grid.columns: 13' in text


def test_a_rate_that_cannot_be_met_is_told(tmp_path, monkeypatch):
    """The cheapest is written, with what it misses."""
    monkeypatch.setattr(search.Search, '_cost', staticmethod(lambda rows: 50.0))
    assert run(tmp_path, 20.0) == 1
    assert ': MISSED by 23 ms' in (tmp_path / 'tuned.yaml').read_text()


def test_a_rate_is_kept_with_room_for_slower_moments(tmp_path, monkeypatch):
    """30 ms of the 33.3 are too much: the cheaper settings are taken, more wrong as they are."""
    monkeypatch.setattr(search.Search, '_cost', staticmethod(
        lambda rows: 30.0 if '13 x 9' in rows[0]['setting'] else 10.0))
    assert run(tmp_path, 1e-6) == 1
    text = (tmp_path / 'tuned.yaml').read_text()
    assert 'grid.columns: 7' in text and 'MISSED: other shots' in text
    assert '30 % of the 33.3 ms at 30 Hz; 80 % are allowed' in text


def test_what_proves_dear_in_the_check_is_not_taken(tmp_path, monkeypatch):
    """A cost that holds in the shot to tune on only is none to promise."""
    whole, checked = Trials.motion, []

    def motion(self, settings, window):
        row, positions = whole(self, settings, window)
        is_check = self.reference.settings['gust.seed'] == search.OTHER_SEED
        if is_check:
            checked.append({name: settings[name] for name in (
                'grid.columns', 'solver', 'substeps', 'precision')})
        is_dear = is_check and checked[-1] == checked[0]
        return {**row, 'physics_ms': 50.0 if is_dear else 1.0}, positions

    monkeypatch.setattr(Trials, 'motion', motion)
    assert run(tmp_path, 20.0) == 0
    tuned = yaml.safe_load((tmp_path / 'tuned.yaml').read_text())
    chosen = tuned['/**/physics']['ros__parameters']
    chosen = {name: chosen[name] for name in checked[0]}
    assert chosen in checked and chosen != checked[0]


def test_a_slow_method_does_not_end_the_search(tmp_path, monkeypatch):
    """Where one is too slow on every grid, the others are tried up to the finest."""
    monkeypatch.setattr(search.Search, '_cost', staticmethod(
        lambda rows: 1e3 if 'implicit' in rows[0]['setting'] else 1.0))
    assert run(tmp_path, 1e-6) == 1
    assert 'grid.columns: 13' in (tmp_path / 'tuned.yaml').read_text()


def test_an_interrupted_run_goes_on(tmp_path, monkeypatch, capsys):
    """What was measured is not measured again, and the result is that of a whole run."""
    whole, seen = Trials.motion, []

    def counted(self, settings, window):
        seen.append((settings['grid.columns'], settings['solver'], settings['substeps'],
                     self.reference.settings['gust.seed'], window.frame))
        if len(seen) == 5 and stops:
            raise KeyboardInterrupt
        return whole(self, settings, window)

    monkeypatch.setattr(Trials, 'motion', counted)
    stops = True
    assert run(tmp_path, 3.0) == 130
    assert 'goes on from' in capsys.readouterr().err
    assert not (tmp_path / 'tuned.yaml').exists()
    stops, before = False, seen[:4]
    seen.clear()
    run(tmp_path, 3.0)
    assert seen and not set(seen) & set(before)
    assert not (tmp_path / 'tuned.yaml.unfinished').exists()


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
    away.write_text('/physics:\n  ros__parameters:\n    stiffness: 1.0e+9\n')
    assert 'at most 20000 steps a frame, and this sheet needs' in refused(
        capsys, '--error-px', 1, '--params-file', away, '--output', new)
    away.write_text('/renderer:\n  ros__parameters:\n    width: -3\n')
    assert 'width must be' in refused(
        capsys, '--error-px', 1, '--params-file', away, '--output', new)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        'away.yaml', 'mine.yaml', 'old.yaml']


def test_a_limp_sheet_is_not_taken(tmp_path, monkeypatch):
    """Softened to two steps a frame it keeps near for a window, and hangs too long in the end."""
    exact = search.methods()['symplectic']
    monkeypatch.setattr(search, 'methods', lambda: {
        'symplectic': exact, 'softened': {**exact, 'substeps_limit': 2}})
    found = search.Search(tune.defaults(), 30.0, Store(tmp_path / 'store', {}))
    limp, firm = (found._stretch_error(f'13 x 9, {name}') for name in ('softened', 'symplectic'))
    assert limp > 5.0 * firm
