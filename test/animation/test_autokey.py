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

"""Autokey: how a key is put among others."""
from flag_sim.animation.autokey import with_key
from flag_sim.animation.keys import read_timeline
from flag_sim.declarations.keyable import TARGETS
import numpy as np
import pytest
from support.tracks import wind_values


def key(values, track, time, value, old):
    """Return the parameters that change with a key within 0.01 s of a time [s]."""
    return with_key(values, track, time, value, old, reach=0.01, targets=TARGETS)


def put(values, *arguments):
    """Put a key into values; return the track."""
    values.update(key(values, *arguments))
    return read_timeline(values, TARGETS).tracks[arguments[0]]


def test_a_first_key_leaves_what_was_before_it_as_it_was():
    """The old value holds until the key; from there on the track leads to the next key."""
    values = wind_values()
    track = put(values, 'physics.stiffness', 2.0, 500.0, 1000.0)
    assert (track.times, track.values, track.laws) == (
        [0.0, 2.0], [1000.0, 500.0], ['step', 'linear'])
    assert [track.at(time) for time in (0.0, 1.0, 1.999, 2.0, 9.0)] == [1000.0] * 3 + [500.0] * 2
    track = put(values, 'physics.stiffness', 4.0, 700.0, 1000.0)
    assert [track.at(time) for time in (1.999, 2.0, 3.0, 4.0)] == [1000.0, 500.0, 600.0, 700.0]


def test_a_first_key_at_the_beginning_is_the_only_one():
    """There is nothing before it that could hold."""
    track = put(wind_values(), 'physics.stiffness', 0.0, 500.0, 1000.0)
    assert (track.times, track.values, track.laws) == ([0.0], [500.0], ['linear'])


def test_a_key_within_reach_replaces_and_an_equal_one_does_nothing():
    """Half a frame is the same moment."""
    values = wind_values(wind__speed=([0.0, 1.0], [0.0, 10.0], ['ease', 'step']))
    assert key(values, 'wind.speed', 1.0, 10.0, 0.0) == {}
    assert key(values, 'wind.speed', 0.5, 5.0, 0.0) == {}
    assert put(values, 'wind.speed', 0.992, 7.0, 0.0).values == [0.0, 7.0]
    track = put(values, 'wind.speed', 0.5, 1.0, 0.0)
    assert (track.times, track.values) == ([0.0, 0.5, 1.0], [0.0, 1.0, 7.0])
    assert track.laws == ['ease', 'ease', 'step']


def test_a_direction_that_turns_is_keyed_on_the_turn_that_plays():
    """What is set is a direction: it does not wind the turns back that were made."""
    values = wind_values(wind__azimuth=([0.0, 10.0], [0.0, 20.0], None, True))
    assert key(values, 'wind.azimuth', 5.0, 10.0 - 4.0 * np.pi, 0.0) == {}
    track = put(values, 'wind.azimuth', 5.0, 10.5 - 4.0 * np.pi, 0.0)
    assert track.values == [0.0, pytest.approx(10.5), 20.0] and track.turns


def test_a_key_is_put_among_others_that_snap():
    """These keep the times that they were given."""
    values = {**wind_values(wind__speed=([0.0, 0.067], [1.0, 2.0], None)), 'snap_keys': True}
    assert put(values, 'wind.speed', 2 / 30, 3.0, 0.0).values == [1.0, 3.0]
    put(values, 'wind.speed', 3 / 30, 4.0, 0.0)
    assert values['keys.wind.speed.times'] == [0.0, 0.067, 3 / 30]


@pytest.mark.parametrize('track, value', [
    ('physics.stiffness', 1000.0), ('renderer.background', [1.0, 2.0, 3.0]),
    ('renderer.shading', 'flat')])
def test_what_changes_nothing_makes_no_track(track, value):
    """Setting a parameter to what it is, as a params file does with most, is no change."""
    assert key(wind_values(), track, 2.0, value, value) == {}


def test_vectors_whole_numbers_and_texts_can_be_put():
    """Each kind comes back as it was put."""
    values = wind_values()
    assert put(values, 'renderer.background', 1.0, [1, 2, 3], [4, 5, 6]).values == [
        [4.0, 5.0, 6.0], [1.0, 2.0, 3.0]]
    track = put(values, 'physics.grid.rows', 1.0, 11, 21)
    assert (track.values, track.laws) == ([21, 11], ['step', 'step'])
    assert put(values, 'renderer.shading', 1.0, 'flat', 'gouraud').laws == ['step', 'step']
