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
from flag_sim.animation.tracks import Track
from flag_sim.animation.wind import wind_vector
import numpy as np
import pytest


def test_linear_goes_at_constant_speed():
    """The value is linear between keys and hits them."""
    track = Track([0.0, 2.0, 3.0], [1.0, 5.0, -1.0])
    times = np.linspace(0.0, 3.0, 61)
    expected = np.interp(times, [0.0, 2.0, 3.0], [1.0, 5.0, -1.0])
    assert np.allclose([track.at(t) for t in times], expected, rtol=0.0, atol=1e-14)


def test_step_holds_until_the_next_key():
    """A stepped value changes at its key, not before."""
    track = Track([0.0, 1.0], ['zbuffer', 'painter'], ['step', 'step'])
    assert [track.at(t) for t in (0.0, np.nextafter(1.0, 0.0), 1.0)] == [
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
def test_every_law_begins_at_its_key(law):
    """At the earlier key every law gives that key's value, exactly."""
    assert LAWS[law](0.0, 0.1, 0.7) == 0.1


def test_keys_are_crossed_once():
    """Intervals that follow one another find every key exactly once."""
    track = Track([0.0, 0.5, 0.50001, 3.0], [0, 1, 2, 3])
    edges = [-1e-9, *np.arange(0.0, 4.0, 0.25)]
    found = [key for a, b in zip(edges, edges[1:]) for key in track.crossed(a, b)]
    assert found == track.times


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
