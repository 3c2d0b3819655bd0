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

"""A whole study of a few seconds, from the command to the report, and what can go wrong."""
import os
import re

from flag_sim.study import __main__ as study
from flag_sim.study import machine, plots, runner, sections
from flag_sim.study.measures import reference, settings, trials
from flag_sim.study.sections import (
    convergence, frontier, horizon, longrun, methods, one_at_a_time)
from flag_sim.study.store import IDENTITY
import numpy as np
import pytest

SECTIONS = (convergence, methods, horizon, longrun, one_at_a_time, frontier)


@pytest.fixture
def small(monkeypatch):
    """Make everything small: a grid of 7 x 5 beside 4 x 3 and 13 x 9, and short shots."""
    base = settings.changed(trials.BASE, {
        'grid.rows': 5, 'grid.columns': 7, 'width': 64, 'height': 48})
    for module, name, value in (
            (trials, 'BASE', base), (trials, 'FINEST', (17, 25)),
            (reference, 'SPIN_UP', 0.2), (reference, 'SPACING', 0.1),
            (reference, 'LEAD', 1.0 / 30.0),
            (convergence, 'COLUMNS', (4, 7, 13)), (convergence, 'WINDOWS', 2),
            (methods, 'STEPS', (4, 16, 64)), (horizon, 'FRAMES', 5),
            (longrun, 'SETTLE', 0.1), (longrun, 'LENGTH', 4.0),
            (one_at_a_time, 'COLUMNS', (4, 13)), (frontier, 'COLUMNS', (4, 7, 13)),
            (frontier, 'TURNS', 1), (study, 'all_sections', lambda: SECTIONS)):
        monkeypatch.setattr(module, name, value)
    trials.base_trials.cache_clear()
    yield
    trials.base_trials.cache_clear()


def run(folder, seconds=1e-3):
    """Run the study, by default for so short a time that it measures only what it must."""
    return study.main(['--minutes', f'{seconds / 60.0}', '--output', str(folder)])


def test_a_study_makes_its_report_and_is_gone_on_with(small, tmp_path, capsys, monkeypatch):
    """Interrupted in the midst and run again, it measures nothing twice, and tells all."""
    whole = frontier.batches

    def interrupted(store):
        raise KeyboardInterrupt

    monkeypatch.setattr(frontier, 'batches', interrupted)
    folder = tmp_path / 'study'
    assert run(folder, 3.0) == 130
    assert 'the same command goes on' in capsys.readouterr().err
    before = {path: path.read_text() for path in folder.glob('*.csv')}
    assert len(before) == 6 and not (folder / 'report.md').exists()

    monkeypatch.setattr(frontier, 'batches', whole)
    assert run(folder, 3.0) == 0
    assert capsys.readouterr().out.strip() == str(folder / 'report.md')
    for path, text in before.items():
        assert path.read_text().startswith(text)
    text = (folder / 'report.md').read_text()
    for words in ('# What accuracy costs', 'cores', 'numba', 'horizon', 'metres **per step**',
                  "The reference's own error", 'On the frontier'):
        assert words in text
    assert not re.search(r'\b(nan|None)\b|{', text)
    shown = re.findall(r'!\[\w+\]\((.*?)\)', text)
    assert len(shown) == 6
    for name in shown:
        assert (folder / name).read_bytes().startswith(b'\x89PNG')
    # Every setting stands in the table of parameters; the source's scheme in all of methods.
    assert text.count('| solver | seed |') == 1 and '| seed |' in text


def test_results_are_the_same_in_every_run(small, tmp_path, monkeypatch):
    """Every number but times, to the last digit."""
    some, tables = (convergence, horizon, one_at_a_time), []
    monkeypatch.setattr(study, 'all_sections', lambda: some)
    for name in 'ab':
        trials.base_trials.cache_clear()
        assert run(tmp_path / name) == 0
        tables.append({section.NAME: study.Store(tmp_path / name, {}).rows(section.NAME)
                       for section in some})
    for name, rows in tables[0].items():
        both = {row['key']: row for row in tables[1][name]}
        shared = [row for row in rows if row['key'] in both]
        assert len(shared) >= min(len(rows), len(both)) > 0
        for row in shared:
            for column, value in row.items():
                if not column.endswith('_ms'):
                    assert both[row['key']][column] == value, (name, row['key'], column)


def test_without_matplotlib_there_are_tables(small, tmp_path, monkeypatch):
    """The report says what is missing, and how to get it."""
    monkeypatch.setattr(plots, 'can_draw', lambda: False)
    monkeypatch.setattr(study, 'all_sections', lambda: SECTIONS[:2])
    assert run(tmp_path / 'study') == 0
    text = (tmp_path / 'study' / 'report.md').read_text()
    assert plots.MISSING in text and '![' not in text and '| seed |' in text
    assert not list((tmp_path / 'study').glob('*.png'))


def test_a_section_of_the_report_is_one_file(tmp_path, monkeypatch):
    """A module put beside the others is measured, resumed, and has its place in the report."""
    (tmp_path / 'room').mkdir()
    (tmp_path / 'room' / 'answers.py').write_text(
        'from flag_sim.study.report import table\n'
        'from flag_sim.study.runner import Batch\n'
        "PLACE, NAME, SHARE = 0.5, 'answers', 1.0\n"
        'def batches(store):\n'
        "    yield Batch('all', [{'why': 'so'}], lambda why: {'found_m': 42.0}, True)\n"
        'def text(rows):\n'
        "    return '## Answers\\n\\n' + table(['found m'], [[rows[0]['found_m']]])\n")
    own = [section.NAME for section in sections.all_sections()]
    monkeypatch.setattr(sections, '__path__', [*sections.__path__, str(tmp_path / 'room')])
    found = sections.all_sections()
    assert [section.NAME for section in found] == ['answers', *own]
    monkeypatch.setattr(study, 'all_sections', lambda: found[:1])
    for _ in range(2):
        assert run(tmp_path / 'study') == 0
        assert (tmp_path / 'study' / 'answers.csv').read_text() == 'key,why,found_m\nso,so,42.0\n'
    text = (tmp_path / 'study' / 'report.md').read_text()
    assert '## Answers\n\n| found m |\n| :-- |\n| 42 |\n\nAll numbers: [answers.csv]' in text


def test_a_busy_machine_is_reported(small, tmp_path, monkeypatch):
    """With how much it was; a machine that does not tell is not called busy."""
    monkeypatch.setattr(study, 'all_sections', tuple)
    monkeypatch.setattr(machine, 'cores', lambda: 4)  # a quarter of them is 1
    for others, words in ((1.25, 'busy with something else (it took 1.25 processors'),
                          (0.1, 'processors kept busy by others | 0.10'),
                          (None, 'processors kept busy by others | –')):
        monkeypatch.setattr(machine.LoadMonitor, 'others', lambda self, others=others: others)
        folder = tmp_path / str(others)
        assert run(folder) == 0
        text = (folder / 'report.md').read_text()
        assert words in text and ('busy with' in text) == (others == 1.25)


def test_all_sessions_of_a_study_count(tmp_path, monkeypatch):
    """Three busy seconds before an interruption, one idle second after it."""
    store = study.Store(tmp_path, {})
    assert runner.load_of_others(store) is None
    for taken, busy in ((3.0, 1.6), (1.0, 0.0), (9.0, None)):
        monkeypatch.setattr(machine.LoadMonitor, 'seconds', lambda self, taken=taken: taken)
        monkeypatch.setattr(machine.LoadMonitor, 'others', lambda self, busy=busy: busy)
        with pytest.raises(KeyboardInterrupt):
            with runner.session(store):
                raise KeyboardInterrupt
    assert runner.load_of_others(study.Store(tmp_path, {})) == pytest.approx(1.2)


def test_work_of_others_is_told_from_ones_own(monkeypatch):
    """Two of three processors, each four parts of ten at work, and half of one by this process."""
    ticks = os.sysconf('SC_CLK_TCK')
    monkeypatch.setattr(machine.os, 'sched_getaffinity', lambda pid: {0, 3})
    monkeypatch.setattr(machine.os, 'times', lambda: (seconds * 0.4, seconds * 0.1, 0.0, 0.0, 0.0))
    monkeypatch.setattr(machine.time, 'monotonic', lambda: seconds)
    # user, nice, system, idle, iowait, irq, softirq, steal; a guest's time is user's already.
    monkeypatch.setattr(machine.Path, 'read_text', lambda path: '\n'.join(
        ['cpu ' + '999999 ' * 10, 'intr 1 2 3'] + [
            f'cpu{number} ' + ' '.join(f'{round(part * seconds * ticks)}' for part in (
                0.1, 0.1, 0.1, 0.5, 0.1, 0.0, 0.0, 0.1, 0.1, 0.0)) for number in (0, 1, 3)]))
    seconds = 10.0
    watch = machine.LoadMonitor()
    seconds = 20.0
    assert watch.others() == pytest.approx(2 * 0.4 - 0.5)


def test_a_system_that_does_not_tell_of_others(monkeypatch):
    """Not even that nobody was there is known then."""
    def refuse(path):
        raise FileNotFoundError(path)

    monkeypatch.setattr(machine.Path, 'read_text', refuse)
    assert machine.LoadMonitor().others() is None


@pytest.mark.parametrize('minutes', ['0', '-1', 'nan', 'inf', 'two'])
def test_bad_minutes_are_refused(minutes, tmp_path, capsys):
    """The message names the rule and the value."""
    with pytest.raises(SystemExit) as refusal:
        study.main(['--minutes', minutes, '--output', str(tmp_path / 'x')])
    assert refusal.value.code == 2
    assert f'must be a number above 0, not {minutes}' in capsys.readouterr().err
    assert not (tmp_path / 'x').exists()


def test_a_folder_of_something_else_is_refused(tmp_path, capsys):
    """Nothing in it is touched."""
    (tmp_path / 'letter.txt').write_text('dear')
    with pytest.raises(SystemExit):
        study.main(['--output', str(tmp_path)])
    assert 'holds something else' in capsys.readouterr().err
    assert not (tmp_path / IDENTITY).exists()


def test_the_peak_of_a_known_motion():
    """A wave of 1.7 Hz under a slower, stronger one below what counts."""
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    motion = np.sin(2.0 * np.pi * 1.7 * times) + 3.0 * np.sin(2.0 * np.pi * 0.1 * times)
    assert longrun.peak(motion, 1.0 / 30.0) == pytest.approx(1.7, abs=0.05)  # 1 / 20 s


def test_the_growth_of_a_known_curve():
    """An exponential that levels off."""
    times = np.arange(1, 40) / 30.0
    values = np.minimum(1e-6 * np.exp(25.0 * times), 50.0)
    assert horizon.growth(times, values, 1.0) == pytest.approx(25.0)
