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
from flag_sim.study.measures import ranking, settings
from flag_sim.study.sections import follows, frontier, own_errors, references, sound
from flag_sim.study.sections.own_errors import HALF, QUARTER
from flag_sim.study.store import IDENTITY
import pytest
from support.study import SMALL

SECTIONS = (frontier, follows, sound, references)


def few_methods(others=False):
    """Return a method for use, one that is not, and a softened one."""
    return {follows.SOFT: None, 'seed': {'solver': 'seed'}} if others else {'symplectic': {}}


@pytest.fixture
def small(monkeypatch):
    """Make everything small: a grid of 7 x 5 beside 4 x 3 and 13 x 9, and short shots."""
    base = settings.changed(follows.BASE, {
        'grid.rows': 5, 'grid.columns': 7, 'width': 64, 'height': 48})
    for module, name, value in (
            *SMALL, (follows, 'FINEST', (17, 25)), (follows, 'BASE', base),
            (follows, 'DEFAULT', '7 symplectic'),
            (follows, 'COLUMNS', (4, 7)), (follows, 'FEWER', 7), (follows, 'TURNS', 2),
            (follows, 'REQUIRED', 2), (follows, 'methods', few_methods), (sound, 'FIRST', (7, 4)),
            (study, 'all_sections', lambda: SECTIONS)):
        monkeypatch.setattr(module, name, value)
    follows.judge.cache_clear()
    yield
    follows.judge.cache_clear()


def run(folder, seconds=1e-3):
    """Run the study, by default for so short a time that it measures only what it must."""
    return study.main(['--minutes', f'{seconds / 60.0}', '--output', str(folder)])


def test_a_study_makes_its_report_and_is_gone_on_with(small, tmp_path, capsys, monkeypatch):
    """Interrupted in the midst and run again, it measures nothing twice, and tells all."""
    whole = sound.batches

    def interrupted(store):
        raise KeyboardInterrupt

    monkeypatch.setattr(sound, 'batches', interrupted)
    folder = tmp_path / 'study'
    assert run(folder, 3.0) == 130
    assert 'the same command goes on' in capsys.readouterr().err
    before = {path: path.read_text() for path in folder.glob('*.csv')}
    assert len(before) == 2 and not (folder / 'report.md').exists()

    monkeypatch.setattr(sound, 'batches', whole)
    assert run(folder, 60.0) == 0
    assert capsys.readouterr().out.strip() == str(folder / 'report.md')
    for path, text in before.items():
        assert path.read_text().startswith(text)
    text = (folder / 'report.md').read_text()
    for words in ('# What accuracy costs', 'cores', 'numba', '## If you want', 'Kendall',
                  'the horizon', '## Behaves and rests', '## How it was measured'):
        assert words in text
    assert text.index('## If you want') < text.index('## Follows') < text.index('cores')
    assert not re.search(r'\b(nan|None)\b|{', text)
    assert '| | |' not in text and 'Not measured' not in text
    shown = re.findall(r'!\[\w+\]\((.*?)\)', text)
    assert shown == ['frontier.png']
    assert (folder / shown[0]).read_bytes().startswith(b'\x89PNG')


def test_what_there_was_no_time_for_is_said(small, tmp_path):
    """The shortest study names the sections and settings that it has not; no table is empty."""
    assert run(tmp_path) == 0
    text = (tmp_path / 'report.md').read_text()
    assert 'Not run for lack of time (method on columns): symplectic on 4' in text
    assert 'Not measured for lack of time: a finer grid, long' in text
    assert not re.search(r'(\| :?--:? )+\|\n\n', text)


def test_first_page_recommends_nothing_that_does_not_behave_or_rest(small, tmp_path, monkeypatch):
    """However near it is and cheap."""
    assert run(tmp_path, 60.0) == 0
    store = study.Store(tmp_path, {})
    cost = follows.costs(store.rows(follows.NAME))
    cheapest = min((row['setting'] for row in store.rows(sound.NAME)
                    if sound.is_sound(row) and follows.SOFT not in row['setting']), key=cost.get)
    for column in ('behaves', 'rests'):
        assert f'**{cheapest}**' in frontier.text(store)
        row = store.row(sound.NAME, cheapest)
        kept, row[column] = row[column], 1e9
        assert f'**{cheapest}**' not in frontier.text(store)
        row[column] = kept
    lines = frontier.text(store).split('| :-- |')[1].splitlines()
    assert sum(line.startswith('| ') for line in lines) <= 6


@pytest.fixture
def made_up(tmp_path):
    """Return a Store of four settings that behave and rest; own error: 0.5 and 2 px."""
    store = study.Store(tmp_path, {})
    for turn, gusts in enumerate(follows.GUSTS):
        for name, cost, error in (('13 softened', 0.5, 8.0), ('25 symplectic', 1.0, 12.0),
                                  ('49 symplectic', 2.0, 4.0), ('61 symplectic', 4.0, 3.0)):
            store.add(follows.NAME, {
                'key': f'{name}/{turn}', 'setting': name, 'turn': turn, 'gusts': gusts,
                follows.RANKED: error, follows.PROMISED: 1.5 * error,
                f'side_{follows.RANKED}': 0.5 * error, 'physics_ms': cost, 'drawing_ms': 0.0})
            if not turn:
                store.add(sound.NAME, {'key': name, 'setting': name, 'behaves': 1.0, 'rests': 0.1,
                                       'sag_mm': 0.0})
    for what, times in ((HALF, 1.0), (QUARTER, 2.0)):
        store.add(references.NAME, {'key': what, 'what': what, 'turn': 0,
                                    follows.RANKED: times * 0.5 / ranking.SAFETY,
                                    follows.PROMISED: times * 2.0 / ranking.SAFETY})
    return store


def taken(store):
    """Return {what a user may want: the columns that the first page names for it}."""
    return dict(re.findall(r'^\| ([^|]*) \| \*\*(\d+) ', frontier.text(store), re.MULTILINE))


def test_first_page_counts_the_error_of_the_reference(made_up):
    """6 px are within 10 with it, and 4.5 not within 5; a tie goes to the cheaper."""
    assert taken(made_up) == {
        'a flag that looks right, for least': '25', 'within 10 px for 0.2 s': '49',
        'the nearest by the numbers': '61'}
    assert 'within 5 px' not in frontier.text(made_up)
    assert 'differ by less than 2.5 px then are tied' in frontier.text(made_up)


def test_a_softened_sheet_is_not_recommended(made_up):
    """Although it is the cheapest and behaves: it is another sheet than was asked for."""
    assert '13' not in taken(made_up).values()


def test_settings_that_the_reference_cannot_tell_apart_are_tied(made_up):
    """On the frontier, in rank and in the order, of which it is told where it does not agree."""
    rows = made_up.rows(follows.NAME)
    assert follows.best(rows) == ['13 softened', '49 symplectic', '61 symplectic']
    assert follows.best(rows, own_errors.least_px(made_up, follows.RANKED)) == [
        '13 softened', '49 symplectic']
    assert follows.agreement(rows, 2.5).startswith('1.00 between two seeds')
    for row in rows:
        if row['gusts'] and row['setting'] in ('25 symplectic', '49 symplectic'):
            row[follows.RANKED] = 16.0 - row[follows.RANKED]
    assert '25 symplectic and 49 symplectic)' in follows.agreement(rows, 2.5)


def test_an_error_of_references_that_is_not_known_is_said(tmp_path):
    """Then nothing is tied."""
    store = study.Store(tmp_path, {})
    assert own_errors.own_px(store, follows.RANKED) is None
    assert own_errors.least_px(store, follows.RANKED) == 0.0
    assert 'was not measured' in references.in_short(store)


def test_without_matplotlib_there_are_tables(small, tmp_path, monkeypatch):
    """The report says what is missing, and how to get it."""
    monkeypatch.setattr(plots, 'can_draw', lambda: False)
    monkeypatch.setattr(study, 'all_sections', lambda: SECTIONS[:2])
    assert run(tmp_path / 'study') == 0
    text = (tmp_path / 'study' / 'report.md').read_text()
    assert plots.MISSING in text and '![' not in text and '| 7 symplectic |' in text
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
        'def text(store):\n'
        "    found = store.rows('answers')[0]['found_m']\n"
        "    return '## Answers\\n\\n' + table(['found m'], [[found]])\n")
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
