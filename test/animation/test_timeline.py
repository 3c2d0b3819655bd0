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

"""Timelines: when keys and events count, and what plays again and again."""
import itertools

from flag_sim.animation.timeline import nearest_frame, Timeline
from flag_sim.animation.tracks import Track
from flag_sim.protocol.clock import FrameClock
from hypothesis import given, strategies as st
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator


def test_a_loop_repeats_while_time_goes_on():
    """Values come again every round, and each key is crossed once a round."""
    tracks = {'a': Track([0.0, 1.0, 2.0], [0.0, 4.0, 0.0])}
    timeline = Timeline(tracks, [(0.5, 'here')], loop=True)
    assert [timeline.at(t)['a'] for t in (0.25, 2.25, 40.25)] == [1.0, 1.0, 1.0]
    edges = [-1.0, *np.arange(0.0, 6.01, 0.3), 6.0]
    found = [event for a, b in zip(edges, edges[1:]) for event in timeline.crossed(a, b)]
    assert found == [(0.0, 'a'), (0.5, 'here'), (1.0, 'a'), (2.0, 'a'), (2.5, 'here'), (3.0, 'a'),
                     (4.0, 'a'), (4.5, 'here'), (5.0, 'a'), (6.0, 'a')]


def test_the_last_key_of_a_loop_is_seen_where_the_round_ends():
    """As the first one is at the begin of the shot; an event later gives it time."""
    track = Track([0.0, 1.0, 2.0], ['a', 'b', 'c'])
    timeline = Timeline({'a': track}, loop=True)
    asked = [0.0, 1.0, 1.999, 2.0, 2.001, 3.0, 4.0, 4.001]
    assert [timeline.value('a', time) for time in asked] == list('abbcabca')
    longer = Timeline({'a': track}, [(3.0, 'end')], loop=True)
    assert [longer.value('a', time) for time in (2.0, 2.999, 3.0, 3.001, 5.5)] == list('cccac')


def test_a_loop_plays_keys_before_0():
    """A round begins with the first key; the shot begins within it, at 0."""
    timeline = Timeline({'a': Track([-1.0, 1.0, 3.0], [10.0, 0.0, 20.0])}, loop=True)
    asked = [0.0, 1.0, 3.0, 3.001, 3.5, 4.0, 5.0, 7.0, 8.0]
    assert np.allclose([timeline.value('a', time) for time in asked],
                       [5.0, 0.0, 20.0, 9.995, 7.5, 5.0, 0.0, 20.0, 5.0])
    edges = [-1e-8, *np.arange(0.0, 12.0, 0.25)]
    found = [mark for a, b in zip(edges, edges[1:]) for mark in timeline.crossed(a, b)]
    assert found == [(1.0, 'a'), (3.0, 'a'), (5.0, 'a'), (7.0, 'a'), (9.0, 'a'), (11.0, 'a')]


ROUNDS = {
    'waves': ([0.0, 1.0, 1.5, 4.0], [0.0, 1.0, 3.0, 0.0], {}),
    'flat': ([0.0, 1.0, 2.0], [1.0, 1.0, 1.0], {}),
    'rises over the seam': ([0.0, 0.5, 2.0, 3.0], [5.0, 7.0, 1.0, 5.0], {}),
    'vectors': ([0.0, 0.5, 2.0, 3.0], [[5.0, 1.0], [7.0, 0.0], [1.0, 3.0], [5.0, 1.0]], {}),
    'turntable': ([0.0, 1.0, 4.0], [0.0, 3.0, 6.28319], {'is_angle': True, 'turns': True}),
    'one turn back': ([0.0, 3.0], [1.0, 1.0 - 2.0 * np.pi], {'is_angle': True, 'turns': True}),
    'north': ([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 4.0, 6.2832], {'is_angle': True}),
    'before 0': ([-2.0, 1.0, 3.0], [1.0, 2.0, 1.0], {}),
}


def seam_speeds(timeline):
    """Return the changes per second before and after the first end of a round."""
    step = 1e-6
    before, after = (np.subtract(timeline.value('a', edge + step), timeline.value('a', edge))
                     for edge in (timeline.end - step - 1e-7, timeline.end + 1e-7))
    return before / step, after / step


@pytest.mark.parametrize('name', ROUNDS)
def test_a_cubic_is_smooth_over_the_seam_of_a_loop(name):
    """It is the middle one of three rounds of keys, as another program goes through them."""
    times, values, how = ROUNDS[name]
    track = Track(times, values, ['cubic'] * len(times), **how)
    timeline = Timeline({'a': track}, loop=True)
    before, after = seam_speeds(timeline)
    assert np.allclose(before, after, rtol=0.0, atol=1e-4)
    length = times[-1] - times[0]
    rise = np.subtract(values[-1], values[0]) * ('is_angle' in how)
    many = [(time + lap * length, np.add(value, lap * rise)) for lap in (-1, 0, 1)
            for time, value in list(zip(times, values))[:-1]]
    theirs = PchipInterpolator(*zip(*many))
    asked = np.linspace(max(times[0], 0.0), times[-1], 300)
    assert np.allclose([timeline.value('a', time) for time in asked], theirs(asked),
                       rtol=0.0, atol=1e-9)


@pytest.mark.parametrize('times', [[0.0, 1.0, 3.0], [1.0, 2.0, 5.0]])
def test_a_cubic_that_holds_on_one_side_of_the_seam_rests_there(times):
    """Nothing moves in the hold, so nothing may move where it begins or ends at the seam."""
    track = Track(times, [1.0, 4.0, 1.0], ['cubic'] * 3)
    timeline = Timeline({'a': track}, [(5.0, 'end')], loop=True)
    assert np.allclose(seam_speeds(timeline), 0.0, rtol=0.0, atol=1e-4)


@pytest.mark.parametrize('laws', [['cubic', 'linear', 'step'], ['linear', 'cubic', 'step']])
def test_only_neighbouring_cubics_are_smooth_over_the_seam(laws):
    """As everywhere: beside another law a cubic is as if it were alone."""
    track = Track([0.0, 1.0, 3.0], [1.0, 4.0, 1.0], laws)
    timeline = Timeline({'a': track}, loop=True)
    for time in np.linspace(0.01, 2.99, 50):
        assert timeline.value('a', time) == track.at(time)


def test_ends_that_do_not_meet_jump():
    """There is nothing to make smooth: each end is as in a shot that plays once."""
    track = Track([0.0, 1.0, 3.0], [1.0, 4.0, 2.0], ['cubic'] * 3)
    timeline = Timeline({'a': track}, loop=True)
    assert [timeline.value('a', time) for time in (0.3, 2.9)] == [track.at(0.3), track.at(2.9)]


@pytest.mark.parametrize('rate', [24.0, 25.0, 29.97, 30.0, 60.0])
def test_the_nearest_frame_is_the_one_whose_time_was_typed(rate):
    """With three decimals, for a thousand frames."""
    for frame in range(1000):
        assert nearest_frame(round(frame / rate, 3), rate) == frame / rate


def test_several_keys_in_one_frame_are_all_crossed_in_order():
    """A long frame finds everything within it."""
    tracks = {'b': Track([0.1, 0.2], [0, 1]), 'a': Track([0.15], [0])}
    timeline = Timeline(tracks, [(0.12, 'event')])
    assert timeline.crossed(0.0, 1.0) == [(0.1, 'b'), (0.12, 'event'), (0.15, 'a'), (0.2, 'b')]


def assert_each_mark_once(marks, stamps, loop):
    """
    Assert that frames at stamps [s] cross marks [(time [s], name)] once, in a loop once a round.

    The crossings of one name are then its time plus 0, 1, 2, ... rounds, none left out and none
    twice; one that is nearer to the last frame than rounding may be missing.
    """
    timeline = Timeline({}, marks, loop)
    found = [mark for a, b in zip(stamps, stamps[1:]) for mark in timeline.crossed(a, b)]
    rounded = 1e-12 * (1.0 + stamps[-1])  # some thousand times what float64 resolves there
    assert np.all(np.diff([time for time, _ in found]) >= -rounded)
    for time, name in marks:
        crossed = [at for at, of in found if of == name]
        rounds = np.arange(len(crossed) if loop else min(len(crossed), 1))
        assert len(crossed) == len(rounds)
        assert np.allclose(crossed, time + rounds * timeline.length, rtol=0.0, atol=rounded)
        if loop or not crossed:
            assert time + len(rounds) * timeline.length > stamps[-1] - rounded


@given(
    times=st.lists(st.floats(0.0, 9.0), max_size=7, unique=True), last=st.floats(9.5, 20.0),
    rate=st.floats(0.5, 1000.0), loop=st.booleans(),
    missed=st.lists(st.integers(1, 40), min_size=1, max_size=10))
def test_every_mark_is_crossed_once(times, last, rate, loop, missed):
    """At any rate, also where frames are missed and several marks lie within one."""
    frames = itertools.accumulate(itertools.islice(itertools.cycle(missed), 60), initial=0)
    stamps = [-1.0, *(round(frame * 1e9 / rate) / 1e9 for frame in frames)]
    marks = [(time, str(k)) for k, time in enumerate([*times, last])]
    assert_each_mark_once(marks, stamps, loop)


@pytest.mark.parametrize('rate', [7.0, 25.0, 29.97, 30.0, 60.0])
def test_no_mark_is_lost_where_a_round_ends_at_a_frame(rate):
    """There rounding decides in which frame, and it must decide once."""
    stamps = [-1.0, *(round(frame * 1e9 / rate) / 1e9 for frame in range(600))]
    for frames in range(1, 40):
        length = frames / rate
        marks = [(0.0, 'begin'), (length / 2.0, 'middle'), (length, 'end')]
        assert_each_mark_once(marks, stamps, loop=True)


MONTH = 30 * 24 * 3600  # [s]
SHOTS = [(frames, rate) for rate in (23.976, 25.0, 29.97, 30.0, 60.0)
         for frames in (1, 7, 10, 21, 33, 100, 1001)]


@pytest.mark.parametrize('frames, rate', SHOTS)
def test_a_key_at_the_time_of_a_frame_is_in_that_frame(frames, rate):
    """Whichever way its stamp was rounded: the value is the key's and the crossing is told."""
    clock = FrameClock(rate)
    timeline = Timeline({'a': Track([0.0, frames / rate], ['before', 'after'])})
    clock.index = frames - 1
    earlier = clock.stamp / 1e9
    clock.index = frames
    time = clock.stamp / 1e9
    assert (timeline.value('a', earlier), timeline.value('a', time)) == ('before', 'after')
    assert timeline.crossed(earlier, time) == [(frames / rate, 'a')]


@pytest.mark.parametrize('frames, rate', SHOTS)
@pytest.mark.parametrize('begin', [0, MONTH / 2, MONTH])
def test_a_loop_of_whole_frames_repeats_them_for_a_month(frames, rate, begin):
    """Each round is the same frames; where it ends, its last key is seen; nothing drifts."""
    clock, last = FrameClock(rate), frames / rate
    values = [float(k) for k in range(frames)]
    track = Track([*(k / rate for k in range(frames)), last], [*values, 0.5],
                  ['step'] * (frames + 1))
    timeline = Timeline({'a': track}, [(0.0, 'again')], loop=True)
    clock.index = frames * round(begin * rate / frames)
    found, stamps = [], [clock.stamp / 1e9 - 1e-4]
    for _ in range(3 * frames):
        stamps.append(clock.stamp / 1e9)
        found.append(timeline.value('a', stamps[-1]))
        clock.index += 1
    # The first round alone has nothing before its first key.
    first = values[0] if begin == 0 else 0.5
    assert found == [first, *values[1:], *2 * [0.5, *values[1:]]]
    told = [[name for _, name in timeline.crossed(*edges)] for edges in zip(stamps, stamps[1:])]
    assert [frame for frame, names in enumerate(told) if 'again' in names] == [
        0, frames, 2 * frames]


def test_a_loop_without_length_is_refused():
    """Every frame would go through it without end."""
    with pytest.raises(ValueError, match='at least 0.001 s; its last key or event is at 1e-09 s'):
        Timeline({}, [(1e-9, 'a')], loop=True)
