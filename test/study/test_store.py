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

"""Rows survive interruption, and folders of others are left alone."""
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

from flag_sim.study import runner
from flag_sim.study.store import Store
import pytest

SAME = {'version': 1, 'machine': 'this'}


def test_rows_come_back_as_they_were(tmp_path):
    """Numbers, whole numbers, truth, text and nothing keep their type."""
    row = {'key': '7', 'a': 1.5e-9, 'b': 3, 'c': None, 'd': 'x, "y"', 'e': float('inf'),
           'f': True}
    Store(tmp_path / 'new', SAME).add('part', row)
    again = Store(tmp_path / 'new', SAME)
    assert again.rows('part') == [row]
    assert again.row('part', '7') == row and again.row('part', '8') is None


def test_half_a_row_is_cut_off(tmp_path):
    """What an interruption left of a row goes; the next row is whole."""
    store = Store(tmp_path, SAME)
    store.add('part', {'key': 'a', 'x': 1.25})
    with open(store.path('part'), 'a') as file:
        file.write('b,2.')
    again = Store(tmp_path, SAME)
    assert [row['key'] for row in again.rows('part')] == ['a']
    again.add('part', {'key': 'b', 'x': 3.5})
    assert Store(tmp_path, SAME).rows('part')[1] == {'key': 'b', 'x': 3.5}


def test_a_killed_process_loses_at_most_its_present_row(tmp_path):
    """SIGKILL while rows are written as fast as they can be."""
    code = ('from flag_sim.study.store import Store; import itertools; '
            f'store = Store({str(tmp_path / "s")!r}, {SAME!r})\n'
            'for n in itertools.count(): store.add("part", {"key": str(n), "x": n / 7}); '
            'print(n, flush=True)')
    process = subprocess.Popen([sys.executable, '-c', code], stdout=subprocess.PIPE, text=True,
                               cwd=Path(__file__).parents[2])
    for line in process.stdout:
        if int(line) >= 20:
            os.kill(process.pid, signal.SIGKILL)
            break
    told = [int(line), *map(int, process.stdout.read().split())]
    process.wait()
    rows = Store(tmp_path / 's', SAME).rows('part')
    assert len(rows) - 1 >= told[-1]  # every row that was reported is there
    assert rows == [{'key': str(n), 'x': n / 7 if n % 7 else pytest.approx(n / 7)}
                    for n in range(len(rows))]


def test_other_folders_are_refused(tmp_path):
    """A folder of something else, of another study, and one that cannot be made."""
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'letter.txt').write_text('dear')
    with pytest.raises(ValueError, match='holds something else'):
        Store(tmp_path / 'mine', SAME)
    assert os.listdir(tmp_path / 'mine') == ['letter.txt']
    Store(tmp_path / 'study', SAME)
    with pytest.raises(ValueError, match='its machine is this, not that. Name another --output'):
        Store(tmp_path / 'study', {**SAME, 'machine': 'that'})
    with pytest.raises(ValueError, match='another study: another one measured. Name another'):
        Store(tmp_path / 'study', {**SAME, 'version': 2}, {'version': 'another one measured'})
    with pytest.raises(ValueError, match='cannot be written: Not a directory'):
        Store(tmp_path / 'mine' / 'letter.txt' / 'below', SAME)


def test_rows_of_a_section_are_alike(tmp_path):
    """Other columns and keys that are there already are mistakes."""
    store = Store(tmp_path, SAME)
    store.add('part', {'key': 'a', 'x': 1})
    for wrong in ({'key': 'b'}, {'x': 1}, {'key': 'a', 'x': 2}):
        with pytest.raises(ValueError):
            store.add('part', wrong)


def test_time_is_shared(monkeypatch):
    """What one section does not use the next may have."""
    now = [0.0]
    monkeypatch.setattr(time, 'monotonic', lambda: now[0])
    found = []
    for _, own in runner.share(100.0, [SimpleNamespace(NAME='a', SHARE=1.0),
                                       SimpleNamespace(NAME='b', SHARE=3.0)]):
        found.append(own.left())
        assert own.allows(own.left() - 1.0) and not own.allows(own.left())
        now[0] += 5.0
    assert found == [25.0, 95.0]


@pytest.mark.parametrize('mark', [b'{', b'[]', b'\xff'])
def test_a_mark_that_is_broken_is_told(tmp_path, mark):
    (tmp_path / 'study.json').write_bytes(mark)
    with pytest.raises(ValueError, match='study.json is broken: name another --output'):
        Store(tmp_path, SAME)
