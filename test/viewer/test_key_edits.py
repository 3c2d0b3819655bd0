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

"""Edits of keys, undo, and where keys stand; without a window."""
from flag_sim.animation.tracks import Track
from flag_sim.viewer.key_edits import changes_of, Keys, read_keys
from flag_sim.viewer.timeline_geometry import curve, span_of, TimeScale, ValueScale
from flag_sim.viewer.undo import AUTOKEY, Edit, History
import pytest

KEYS = Keys([0.0, 1.0, 2.0], [5.0, 6.0, 7.0], ['linear', 'ease', 'step'])


def test_a_key_keeps_its_law_wherever_it_goes():
    moved, place = KEYS.moved(0, 1.5, 9.0)
    assert moved == Keys([1.0, 1.5, 2.0], [6.0, 9.0, 7.0], ['ease', 'linear', 'step'])
    assert place == 1
    assert KEYS.with_law(1, 'cubic').laws == ['linear', 'cubic', 'step']
    assert KEYS.without(2).times == [0.0, 1.0]
    assert KEYS.having(1.0, 0.0, 'cubic') == Keys(
        [0.0, 1.0, 2.0], [5.0, 0.0, 7.0], ['linear', 'cubic', 'step'])
    assert [KEYS.law_at(time) for time in (-1.0, 0.5, 1.0, 9.0)] == [
        'linear', 'linear', 'ease', 'step']


def test_keys_are_read_as_they_are_written():
    """Of numbers and of vectors; with the last key the track is gone."""
    for keys, length in ((KEYS, None), (Keys([0.0, 1.0], [[1.0, 2.0], [3.0, 4.0]],
                                             ['step', 'step'], True), 2)):
        values = {'tracks': ['a.b'], 'keys.c.d.times': [0.0], 'keys.a.b.turns': keys.turns}
        changes = changes_of(values, 'a.b', keys)
        assert read_keys({**values, **changes}, 'a.b', 'linear', length) == keys
        assert 'tracks' not in changes
    gone = changes_of({**values, **changes}, 'a.b', None)
    assert gone == {'tracks': [], 'keys.a.b.times': None, 'keys.a.b.values': None,
                    'keys.a.b.laws': None, 'keys.a.b.turns': None}
    assert changes_of({'tracks': ['x.y']}, 'a.b', KEYS)['tracks'] == ['x.y', 'a.b']


def test_keys_that_do_not_fit_are_not_read():
    """As between two sets of `ros2 param set`; without laws it is the usual one."""
    values = {'keys.a.times': [0.0, 1.0], 'keys.a.values': [1.0, 2.0]}
    assert read_keys(values, 'a', 'ease', None).laws == ['ease', 'ease']
    for name, bad in (('keys.a.values', [1.0]), ('keys.a.laws', ['step']),
                      ('keys.a.times', [])):
        assert read_keys({**values, name: bad}, 'a', 'ease', None) is None
    assert read_keys(values, 'a', 'ease', 3) is None


def edit(n, *names):
    """Return the n-th edit of some parameters."""
    return Edit(f'edit {n}', dict.fromkeys(names, n - 1), dict.fromkeys(names, n))


def test_undo_and_redo():
    history = History()
    for n in (1, 2, 3):
        history.add(edit(n, 'a'))
    history.undone()
    history.undone()
    assert (history.next_undo.words, history.next_redo.words) == ('edit 1', 'edit 2')
    history.redone()
    history.add(edit(4, 'a'))
    assert history.next_redo is None and history.next_undo.words == 'edit 4'


def test_what_others_change_is_not_undone():
    """Nor what was done before: it would be put back into what they have made."""
    history = History()
    for n, name in enumerate('abcad', 1):
        history.add(edit(n, name))
    history.undone()
    history.forget({'a'})
    assert history.next_redo.words == 'edit 5'
    assert history.next_undo is None
    history.redone()
    history.add(edit(6, 'b'))
    history.forget({'d'})
    assert history.next_undo.words == 'edit 6'


def test_the_keys_of_one_slider_are_one_edit():
    history = History()
    for n in range(5):
        history.add(Edit(AUTOKEY, {'a': n}, {'a': n + 1}))
    assert history.next_undo == Edit(AUTOKEY, {'a': 0}, {'a': 5})
    history.add(Edit(AUTOKEY, {'b': 0}, {'b': 1}))
    history.undone()
    assert history.next_undo.after == {'a': 5}


@pytest.mark.parametrize('law', ['step', 'linear', 'ease', 'cubic'])
def test_a_curve_goes_by_the_law(law):
    """Every point of it is one of the track's own, and at keys it is theirs."""
    track = Track([0.0, 1.0, 3.0], [1.0, 4.0, 2.0], [law] * 3)
    points = curve(track, None, -1.0, 5.0)
    assert (points[0], points[-1]) == ((-1.0, 1.0), (5.0, 2.0))
    assert [time for time, _ in points] == sorted(time for time, _ in points)
    jumps = {(1.0, 1.0), (3.0, 4.0)} if law == 'step' else set()
    assert all(value == pytest.approx(track.at(time))
               for time, value in points if (time, value) not in jumps)
    assert {(0.0, 1.0), (1.0, 4.0), (3.0, 2.0)} <= set(points)


def test_places_and_times_agree():
    scale = TimeScale(-1.0, 3.0, 100.0, 500.0)
    assert scale.x(0.0) == 200.0 and scale.time(200.0) == 0.0
    near = scale.zoomed(200.0, 0.5)
    assert near.time(200.0) == pytest.approx(0.0) and near.end - near.begin == 2.0
    assert scale.shifted(0.25).begin == 0.0
    for span in (1e-3, 0.3, 7.0, 1e5):
        ticks = TimeScale(0.0, span, 0.0, 800.0).ticks(80.0)
        assert 4 <= len(ticks) <= 11 and ticks[0] == 0.0
    low, high = span_of([2.0, 2.0])
    heights = ValueScale(low, high, 50.0, 0.0)
    assert low < 2.0 < high and heights.value(heights.y(2.0)) == pytest.approx(2.0, abs=0.01)
