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
from flag_sim.animation.laws import LAWS
from flag_sim.animation.tracks import short_way, Track
from flag_sim.animation.wind_vector import wind_vector
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


@pytest.mark.parametrize('times, values, laws, rule', [
    ([], [], None, 'at least one key'),
    ([0.0, 0.0], [1.0, 2.0], None, '0.0 follows 0.0'),
    ([1.0, 0.5], [1.0, 2.0], None, '0.5 follows 1.0'),
    ([0.0, float('nan')], [1.0, 2.0], None, 'nan'),
    ([0.0, 1.0], [1.0, float('inf')], None, 'inf'),
    ([0.0, 1.0], [1.0], None, 'one length, not times of 2, values of 1$'),
    ([0.0, 1.0], [1.0, 2.0], ['step'], 'times of 2, values of 2, laws of 1$'),
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
    ([0.0, 1.0], [1.0, None], None, 'values must be numbers, or vectors'),
    ([0.0, 1.0], [[[1.0, 2.0]], [[3.0, 4.0]]], None, 'values must be numbers, or vectors'),
    ([0.0, 1.0], [[], []], None, 'values must be numbers, or vectors'),
    ([0.0, 1.0], [['1', '2'], ['3', '4']], None, 'values must be numbers, or vectors'),
    ([0.0, 1.0], [b'1', b'2'], None, 'values must be numbers, or vectors'),
    ([0.0, 1.0], [1.0, 2.0], [['step'], 'step'], "law .'step'. is not one of"),
])
def test_bad_keys_are_refused(times, values, laws, rule):
    """The message names the rule and the value."""
    with pytest.raises(ValueError, match=rule):
        Track(times, values, laws)


@pytest.mark.parametrize('values', [['a', 'b'], [True, False], [[1.0, 2.0], [3.0, 4.0]]])
def test_only_single_numbers_are_angles(values):
    """Of others there is no short way round."""
    with pytest.raises(ValueError, match='values must be .*numbers where is_angle, not '):
        Track([0.0, 1.0], values, is_angle=True)


def test_vectors_come_as_lists_at_keys_and_between():
    """Also those of an array."""
    track = Track(np.array([0, 1]), np.array([[0, 1], [2, 3]]))
    assert [track.at(time) for time in (0, 0.5, 1)] == [[0, 1], [1.0, 2.0], [2, 3]]


def test_wind_blows_to_its_azimuth_and_elevation():
    """The vector has the speed for length and points where the angles say."""
    assert np.allclose(wind_vector(3.0, 0.0, 0.0), [3.0, 0.0, 0.0])
    assert np.allclose(wind_vector(3.0, np.pi / 2, 0.0), [0.0, 3.0, 0.0])
    assert np.allclose(wind_vector(3.0, 1.0, np.pi / 2), [0.0, 0.0, 3.0])
    assert np.isclose(np.linalg.norm(wind_vector(7.0, 2.0, -0.4)), 7.0)
