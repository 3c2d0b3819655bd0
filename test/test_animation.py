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

"""Tracks and their laws."""
import itertools

from flag_sim.animation.laws import LAWS
from flag_sim.animation.timeline import nearest_frame, Timeline
from flag_sim.animation.tracks import short_way, Track
from flag_sim.animation.wind import wind_vector
from flag_sim.nodes.clock import FrameClock
from hypothesis import given, strategies as st
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator


def test_linear_goes_at_constant_speed():
    """The value is linear between keys and hits them."""
    track = Track([0.0, 2.0, 3.0], [1.0, 5.0, -1.0])
    times = np.linspace(0.0, 3.0, 61)
    expected = np.interp(times, [0.0, 2.0, 3.0], [1.0, 5.0, -1.0])
    assert np.allclose([track.at(t) for t in times], expected, rtol=0.0, atol=1e-14)


def test_step_holds_until_the_next_key():
    """A stepped value changes at its key, not before."""
    track = Track([0.0, 1.0], ['zbuffer', 'painter'], ['step', 'step'])
    assert [track.at(t) for t in (0.0, 1.0 - 1e-8, 1.0)] == [
        'zbuffer', 'zbuffer', 'painter']


def test_values_hold_before_and_after():
    """Outside its keys a track holds."""
    track = Track([1.0, 2.0], [3.0, 4.0])
    assert (track.at(-5.0), track.at(0.9), track.at(7.0)) == (3.0, 3.0, 4.0)


def test_each_segment_has_the_law_of_its_first_key():
    """Laws can differ from segment to segment."""
    track = Track([0.0, 1.0, 2.0], [0.0, 1.0, 3.0], ['step', 'linear', 'step'])
    assert (track.at(0.75), track.at(1.5)) == (0.0, 2.0)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('values', [[0.1, 0.7, -0.3], [[1.0, 0.0], [0.2, 3.0], [0.5, 0.5]]])
def test_every_law_hits_its_keys(law, values):
    """At its keys a track has exactly their values, numbers and vectors alike."""
    track = Track([0.0, 1.0, 3.0], values, [law] * 3)
    for time, value in zip(track.times, values):
        assert np.array_equal(track.at(time), value)


def test_ease_starts_and_arrives_at_rest():
    """The smoothstep by its formula."""
    track = Track([1.0, 3.0], [2.0, 6.0], ['ease', 'step'])
    for time in np.linspace(1.0, 3.0, 41):
        f = (time - 1.0) / 2.0
        assert track.at(time) == pytest.approx(2.0 + 4.0 * (3 * f**2 - 2 * f**3), abs=1e-12)


@pytest.mark.parametrize('seed', range(20))
def test_cubic_is_scipys_monotone_interpolator(seed):
    """Against an independent implementation, on steep, flat and uneven keys."""
    source = np.random.default_rng(seed)
    count = source.integers(2, 12)
    times = np.cumsum(source.uniform(0.01, 3.0, count))
    values = source.normal(size=count) * source.choice([0.0, 1.0, 1000.0], count)
    track = Track(times, values, ['cubic'] * count)
    asked = np.linspace(times[0], times[-1], 300)
    expected = PchipInterpolator(times, values)(asked)
    found = [track.at(time) for time in asked]
    assert np.allclose(found, expected, rtol=0.0, atol=1e-12 * max(1.0, np.abs(values).max()))


def test_cubic_never_overshoots():
    """Between two keys the value stays between theirs."""
    track = Track([0.0, 1.0, 1.1, 4.0], [0.0, 0.0, 10.0, 10.0], ['cubic'] * 4)
    values = [track.at(time) for time in np.linspace(0.0, 4.0, 1000)]
    assert min(values) >= 0.0 and max(values) <= 10.0


@pytest.mark.parametrize('law', ['linear', 'ease', 'cubic'])
def test_angles_take_the_short_way(law):
    """From 3 rad to -3 rad it is a small step across half a turn."""
    track = Track([0.0, 1.0], [3.0, -3.0], [law] * 2, is_angle=True)
    assert track.at(0.5) == pytest.approx(np.pi)
    assert all(3.0 <= track.at(t) <= 2 * np.pi - 3.0 for t in np.linspace(0.0, 0.999, 50))
    assert track.at(1.0) == -3.0


@given(st.lists(st.floats(-50.0, 50.0), min_size=2, max_size=8))
def test_the_short_way_is_half_a_turn_at_most(angles):
    """The same directions, each as near to the one before as three decimals tell."""
    path = short_way(np.array(angles))
    assert np.abs(np.diff(path)).max() <= np.pi + 1.001e-3
    assert np.allclose(np.exp(1j * path), np.exp(1j * np.array(angles)))


@pytest.mark.parametrize('half', [np.pi, 3.142, 3.1416, 3.14159, -np.pi, -3.142])
def test_half_a_turn_goes_the_way_that_it_is_typed(half):
    """However it is rounded: 0, 3.142, 6.283 does not swing to and fro."""
    track = Track([0.0, 1.0, 2.0], [0.0, half, round(2.0 * half, 3)], is_angle=True)
    steps = np.diff([track.at(0.5), track.at(0.999), track.at(1.5)])
    assert np.all(np.sign(steps) == np.sign(half))


@pytest.mark.parametrize('law', ['linear', 'ease', 'cubic'])
@pytest.mark.parametrize('values', [[0.0, 6.283], [0.0, 3.142, 6.283], [0.0, 5.0, 18.85],
                                    [1.0, -30.0, -31.0]])
def test_a_track_that_turns_takes_its_values_as_they_are(law, values):
    """As many turns as they say, the way that they say."""
    times = np.arange(len(values), dtype=float)
    track = Track(times, values, [law] * len(values), is_angle=True, turns=True)
    found = [track.at(time) for time in np.linspace(0.0, times[-1], 200)]
    assert found[0] == values[0] and found[-1] == values[-1]
    assert np.all(np.sign(np.diff(found)) == np.sign(values[-1] - values[0]))
    assert track.long_ways() == []


@pytest.mark.parametrize('values, law, far', [
    ([0.0, 6.283], 'linear', [0]), ([0.0, 3.142, 6.283], 'cubic', [0, 1]),
    ([0.0, np.pi], 'ease', [0]), ([0.0, -np.pi], 'linear', [0]),
    ([0.3, 0.3 + np.pi, 3.0], 'linear', [0]),
    ([3.0, -3.0, -2.9], 'linear', [0]), ([0.0, 3.0, 6.0], 'linear', []),
    ([0.0, 6.0], 'step', [])])
def test_angles_half_a_turn_apart_are_found(values, law, far):
    """There the short way is not the one that is typed, or is no shorter."""
    track = Track(np.arange(len(values)), values, [law] * len(values), is_angle=True)
    assert track.long_ways() == far


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


@pytest.mark.parametrize('times, values, laws, rule', [
    ([], [], None, 'at least one key'),
    ([0.0, 0.0], [1.0, 2.0], None, '0.0 follows 0.0'),
    ([1.0, 0.5], [1.0, 2.0], None, '0.5 follows 1.0'),
    ([0.0, float('nan')], [1.0, 2.0], None, 'nan'),
    ([0.0, 1.0], [1.0, float('inf')], None, 'inf'),
    ([0.0, 1.0], [1.0], None, '2 times, 1 values'),
    ([0.0], [1.0], ['bezier'], "'bezier' is not one of"),
    ([0.0, 1.0], ['a', 'b'], ['linear', 'step'], 'use step'),
    ([0.0, 1.0], [True, 1.0], ['step', 'step'], 'of one type'),
    ([0.0, 1e308], [1.0, 2.0], None, 'from -1e[+]09 to 1e[+]09 s, not 1e[+]308'),
    ([0.0, 10 ** 400], [1.0, 2.0], None, 'times must be numbers, not 1000'),
    ([0.0, 'late'], [1.0, 2.0], None, "times must be numbers, not 'late'"),
    ([-0.0, 0.0], [1.0, 2.0], None, '0.0 follows 0.0'),
    ([0.0, 5e-324], [1.0, 2.0], None, 'at least 1e-09 s apart; 5e-324 follows 0.0'),
    ([0.0, 1.0], [-1e308, 1e308], None, 'at most 1e[+]12 in size, not -1e[+]308'),
    ([0.0, 1.0], [1.0, 10 ** 400], None, 'values must be numbers'),
    ([0.0, 1.0], [1.0, [1.0, 2.0]], None, 'values must be numbers, or vectors of one length'),
    ([0.0, 1.0], [1.0, None], None, 'finite, not nan'),
])
def test_bad_keys_are_refused(times, values, laws, rule):
    """The message names the rule and the value."""
    with pytest.raises(ValueError, match=rule):
        Track(times, values, laws)


def test_wind_blows_to_its_azimuth_and_elevation():
    """The vector has the speed for length and points where the angles say."""
    assert np.allclose(wind_vector(3.0, 0.0, 0.0), [3.0, 0.0, 0.0])
    assert np.allclose(wind_vector(3.0, np.pi / 2, 0.0), [0.0, 3.0, 0.0])
    assert np.allclose(wind_vector(3.0, 1.0, np.pi / 2), [0.0, 0.0, 3.0])
    assert np.isclose(np.linalg.norm(wind_vector(7.0, 2.0, -0.4)), 7.0)
