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
"""The comparison with real flags: its figures on known motions, its verdicts, its command."""
import functools
import math
import re

from flag_sim.cloth import Cloth, Diverged
from flag_sim.declarations.factories import cloth_of
from flag_sim.study import __main__ as study
from flag_sim.study import plots
from flag_sim.study.measures import flapping, published, realism
from flag_sim.study.measures.flapping import Trial
from flag_sim.study.measures.published import Band, Flag
from flag_sim.study.measures.settings import defaults
from flag_sim.study.sections.real import Real
import numpy as np
import pytest

DEFAULT = Flag.of(cloth_of(defaults()))
QUICK = Trial(settle=2.0, seconds=4.0)
SMALL = defaults(grid__columns=10, grid__rows=7)


def test_figures_of_a_wave_that_travels():
    """A sine of 1.7 Hz with noise, which comes 0.21 s later."""
    dt, rng = 1.0 / 120.0, np.random.default_rng(1)
    time = np.arange(3000) * dt

    def wave(at):
        return np.sin(2.0 * math.pi * 1.7 * at) + 0.01 * rng.normal(size=at.size)

    assert flapping.peak(wave(time), dt) == pytest.approx(1.7, abs=0.02)
    assert flapping.crossings(np.sin(2.0 * math.pi * 1.7 * time + 0.1), dt) == pytest.approx(
        1.7, abs=0.05)
    assert flapping.lag(wave(time), wave(time - 0.21), dt, 0.3) == pytest.approx(0.21, abs=3e-3)
    assert flapping.lag(wave(time), wave(time), dt, 0.3) in (None, pytest.approx(0.0, abs=1e-3))
    assert flapping.peak(np.zeros(100), dt) is None


def test_bands_are_those_of_the_codes():
    """The default flag by hand: AS 1170.2 0.097, Eurocode 0.067, Fairthorne 0.09 +- 30 %."""
    low, high = published.drag(DEFAULT)
    term = 0.7 * 0.2 / (1.2 * 1.5) * (2.25 * 1.5 / 1.5**2)**-1.25
    assert low == pytest.approx(0.02 + term) and 0.05 + term < high == pytest.approx(0.117)
    assert published.level_wind(DEFAULT) == pytest.approx((0.65 * 7.38, 1.2 * 7.38), rel=1e-3)
    assert published.swing(DEFAULT) == pytest.approx((0.12, 0.28), rel=0.01)
    assert published.level_wind(DEFAULT._replace(gravity=0.0)) is None
    assert [Band(1.0, 2.0).side(value) for value in (0.5, 1.5, 3.0)] == [-1, 0, 1]


def rows(**changes):
    """Return rows of a flag that agrees in all eight tests, but for changes {column: function}."""
    found = []
    for speed in (4.0, 6.0, 10.0, 15.0):
        row = {'speed': speed, 'frequency_hz': 0.4 * speed / 2.25, 'crossings_hz': 1.0,
               'swing': 0.2, 'wave_speed': 0.8, 'sag_deg': 70.0 / speed**1.2, 'drag': 0.09,
               'lift': 0.3}
        found.append({**row, **{name: of(row) for name, of in changes.items()}})
    return found


def verdicts(own, lighter):
    """Return the eight verdicts."""
    return [one.verdict for one in realism.compare(DEFAULT, own, lighter)]


LIGHTER = rows(frequency_hz=lambda row: 0.9 * row['frequency_hz'])


def test_a_flag_like_a_real_one_passes():
    assert verdicts(rows(), LIGHTER) == ['right'] * 8


@pytest.mark.parametrize('number, changes', [
    (1, {'swing': lambda row: 1e-4}), (2, {'frequency_hz': lambda row: row['frequency_hz'] / 2.0}),
    (3, {'wave_speed': lambda row: 0.3}), (5, {'swing': lambda row: 0.6}),
    (6, {'drag': lambda row: 0.2}), (7, {'drag': lambda row: 0.35 / row['speed']}),
    (8, {'sag_deg': lambda row: 14.0 if row['speed'] < 12.0 else 5.0})])
def test_each_fault_is_told_by_its_test(number, changes):
    found = verdicts(rows(**changes), LIGHTER)
    assert found[number - 1] == 'wrong'
    also = {1: {5}, 2: {4}, 7: {6}}.get(number, set())  # what depends on the same column
    assert all(verdict == 'right' for place, verdict in enumerate(found, 1)
               if place not in {number, *also})


def test_a_lighter_flag_that_flaps_faster_is_wrong():
    assert verdicts(rows(), rows(frequency_hz=lambda row: 1.2 * row['frequency_hz']))[3] == 'wrong'


def test_some_winds_right_is_partly_right():
    one = realism.compare(DEFAULT, rows(drag=lambda row: 0.09 if row['speed'] < 5.0 else 0.03),
                          LIGHTER)[5]
    assert one.verdict == 'partly right' and one.says == 'too low at 6, 10, 15 m/s.'


def test_what_was_not_measured_is_not_judged():
    """No rows, rows that diverged, and a flag that hangs in all winds."""
    diverged = [{'speed': 6.0, **dict.fromkeys(flapping.COLUMNS)}]
    for none in ([], diverged):
        assert verdicts(none, none) == ['not tested'] * 8
    hangs = rows(sag_deg=lambda row: 40.0)
    assert verdicts(hangs, hangs) == ['not tested'] * 8


def test_a_flag_flaps_in_wind_along_it_if_it_starts_with_noise():
    """Exactly flat it stays so: the force of a wind along it is exactly zero."""
    for noise, verdict in ((1e-4, 'right'), (0.0, 'wrong')):
        row = flapping.flapping({**SMALL, 'start_noise': noise}, 10.0, QUICK)
        assert verdicts([{'speed': 10.0, **row}], [{'speed': 10.0, **row}])[0] == verdict


def test_frames_are_short_and_steps_as_long():
    """At 30 Hz four frames become of one, each with a quarter of its steps."""
    found = flapping.sampled({**SMALL, 'substeps': 10, 'substeps_limit': 100})
    assert (found['rate'], found['substeps'], found['substeps_limit']) == (120.0, 3, 25)
    assert flapping.sampled({**SMALL, 'rate': 150.0})['rate'] == 150.0


@pytest.fixture
def quick(monkeypatch):
    """Let the command watch two winds for a short time."""
    monkeypatch.setattr(study, 'Real', functools.partial(Real, trial=QUICK, winds=(10.0, 6.0)))


@pytest.fixture
def params(tmp_path):
    """Return a params file of a small flag."""
    path = tmp_path / 'mine.yaml'
    path.write_text('/physics:\n  ros__parameters:\n    grid.columns: 10\n    grid.rows: 7\n')
    return path


def test_the_command_writes_a_report(quick, params, tmp_path, capsys):
    folder = tmp_path / 'real'
    arguments = ['--real', str(params), '--output', str(folder)]
    assert study.main(arguments) == 0
    printed = capsys.readouterr().out
    assert printed.rstrip().endswith(str(folder / 'report.md'))
    text = (folder / 'report.md').read_text()
    for words in ('How near this flag is to real ones', '8. wind from which', 'Fairthorne',
                  '- wrong:', 'half as heavy'):
        assert words in text
    assert printed.partition('\n\n')[0] in text
    for picture in ('real.png', 'flag.png'):
        assert (folder / picture).exists() == (picture in text) == plots.can_draw()
    # Again: nothing is measured anew. Another flag has a folder of its own.
    rows = (folder / 'real.csv').read_text()
    assert study.main(arguments) == 0 and (folder / 'real.csv').read_text() == rows
    with pytest.raises(SystemExit):
        study.main(['--real', '--output', str(folder)])
    said = capsys.readouterr().err
    assert (f'output {folder} holds another study: it is of another flag. Name another --output, '
            f'or remove {folder}') in said.replace('\n', ' ')
    assert not re.search('[0-9a-f]{16}', said.replace(str(tmp_path), ''))


def test_pictures_are_of_a_flag_that_moves():
    """At the shape of the camera's picture; of the flag that is measured."""
    one, two = flapping.pictures({**SMALL, 'height': 240}, 10.0, 1.0, 0.1, 2)
    assert one.shape == two.shape == (82, flapping.PICTURE, 3) and (one != two).any()


def test_a_flag_that_diverges_has_no_pictures(monkeypatch):
    def fling(cloth, dt, wind):
        raise Diverged('flung away')
    monkeypatch.setattr(Cloth, 'advance', fling)
    assert flapping.pictures(SMALL, 10.0, 1.0, 0.1, 2) == []


def test_a_short_time_measures_one_wind_and_says_so(quick, params, tmp_path):
    folder = tmp_path / 'real'
    assert study.main(['--real', str(params), '--minutes', '1e-6', '--output', str(folder)]) == 0
    text = (folder / 'report.md').read_text()
    assert 'Not measured for lack of time: this flag in 6 m/s; half as heavy in 10 m/s' in text


@pytest.mark.parametrize('text, words', [
    (None, 'cannot be read'), ('a: b: c', 'is not YAML'),
    ('/physics:\n  ros__parameters:\n    air.density: 0.0\n', 'must be above zero'),
    ('/physics:\n  ros__parameters:\n    grid.rows: 1\n', 'rows must be'),
    ('/physics:\n  ros__parameters:\n    air.added_mass: 0.5\n    solver: verlet\n',
     'added_mass above 0 needs solver symplectic'),
    ('/physics:\n  ros__parameters: {gravity: down}\n', 'gravity must be a number from'),
    ('/wind:\n  ros__parameters: {rate: fast}\n', 'rate must be a number from'),
    ('/**:\n  ros__parameters: {pole.height: 0.3, pole.diameter: 1.0}\n',
     'pole.diameter 1 m must be less than'),
    ('/renderer:\n  ros__parameters: {flag.image: none.png}\n', 'flag.image: none.png'),
    ('/physics:\n  ros__parameters: {area_density: 1.0e-6}\n', 'half as heavy: area_density')])
def test_flags_that_cannot_be_compared_are_refused(text, words, tmp_path, capsys):
    path = tmp_path / 'mine.yaml'
    if text is not None:
        path.write_text(text)
    with pytest.raises(SystemExit) as refusal:
        study.main(['--real', str(path), '--output', str(tmp_path / 'real')])
    assert refusal.value.code == 2 and words in capsys.readouterr().err
    assert not (tmp_path / 'real').exists()


@pytest.mark.parametrize('path, words', [
    ('.', 'Is a directory'), ('/dev/null', 'is not a file'), ('', 'a path must be named')])
def test_what_is_no_file_is_no_flag(path, words, quick, tmp_path, capsys, monkeypatch):
    """Nor is it taken for the default one."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        study.main(['--real', path, '--output', 'real'])
    assert words in capsys.readouterr().err
    assert not (tmp_path / 'real').exists()
