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

"""Tracks as parameters: what is read and what is refused."""
from flag_sim.animation import keys
from flag_sim.declarations.keyable import TARGETS
import numpy as np
import pytest
from support.tracks import wind_values


def read(values):
    """Return the Timeline of the wind's parameters."""
    return keys.read_timeline(values, TARGETS)


def values_at(timeline, time):
    """Return {track: value} at a time [s]."""
    return keys.values_at(timeline, time, TARGETS)


def test_values_come_in_the_types_of_their_parameters():
    """Vectors are whole; texts, booleans and whole numbers step, or are rounded where told to."""
    timeline = read(wind_values(
        physics__grid__rows=([0.0, 1.0], [10.0, 20.0], ['linear'] * 2),
        renderer__width=([0.0, 1.0], [640.0, 320.0], None),
        renderer__flag__color=([0.0, 1.0], [0.0, 0.0, 0.0, 100.0, 200.0, 50.0], None),
        renderer__shading=([0.0, 1.0], ['flat', 'gouraud'], None),
        renderer__pole__visible=([0.0, 1.0], [True, False], None)))
    assert values_at(timeline, 0.46) == {
        'physics.grid.rows': 15, 'renderer.width': 640, 'renderer.flag.color': [46.0, 92.0, 23.0],
        'renderer.shading': 'flat', 'renderer.pole.visible': True}
    assert type(values_at(timeline, 0.46)['physics.grid.rows']) is int


def test_angles_take_the_short_way_and_stay_in_range():
    """Turning on and on through the short way never leaves the parameter's range."""
    turns = list(np.arange(40) * 2.0 % (2 * np.pi))
    timeline = read(wind_values(
        wind__azimuth=([float(i) for i in range(40)], turns, None)))
    asked = np.linspace(0.0, 39.0, 500)
    values = np.array([values_at(timeline, t)['wind.azimuth'] for t in asked])
    assert np.abs(values).max() <= 2 * np.pi
    assert np.allclose(np.exp(1j * values), np.exp(2j * asked))


@pytest.mark.parametrize('track, parts, rule', [
    ('sun__speed', ([0.0], [1.0], None), 'one of wind, physics, renderer, scene and a dot'),
    ('physics__colour', ([0.0], [1.0], None), "/physics has no parameter 'colour'"),
    ('wind__rate', ([0.0], [30.0], None), 'cannot be keyed'),
    ('recorder__path', ([0.0], ['x'], None), 'cannot be keyed'),
    ('wind__tracks', ([0.0], ['x'], None), 'cannot be keyed'),
    ('wind__speed', ([0.0], [201.0], None), 'speed must be a number from 0 to 200'),
    ('wind__speed', ([0.0, 1.0], [1.0], None), 'of one length'),
    ('wind__speed', ([0.0], [float('nan')], None), 'not nan'),
    ('wind__speed', ([0.0], [1.0], ['bezier']), "'bezier' is not one of step, linear"),
    ('wind__speed', ([], [], None), 'at least one key'),
    ('wind__speed', ([0.0], ['fast'], None), "not 'fast'"),
    ('physics__grid__rows', ([0.0], [2.5], None), 'not 2.5'),
    ('renderer__samples', ([0.0, 1.0], [1.0, 5.0], None), 'one of 1, 4, 8, 16, not 5'),
    ('renderer__samples', ([0.0, 1.0], [1.0, 4.0], ['linear', 'step']),
     "'linear' cannot lead between one of 1, 4, 8, 16; use step"),
    ('renderer__shading', ([0.0, 1.0], ['flat', 'gouraud'], ['linear', 'step']), 'use step'),
    ('renderer__flag__color', ([0.0], [1.0, 2.0], None), '3 numbers a key, not 2'),
    ('wind__speed', ([0.0], None, None), 'needs keys.wind.speed.times'),
    ('wind__speed', ([0.0], [1.0], None, True), 'speed.turns must be false, not true: speed is'),
    ('renderer__camera__elevation', ([0.0], [0.1], None, True), 'elevation is no direction'),
    ('wind__azimuth', ([0.0, 1.0], [0.0, 7.0], None), 'from -6.28319 to 6.28319 .rad., not 7.0'),
    ('wind__azimuth', ([0.0, 1.0], [0.0, 2e6], None, True),
     'from -1.0e[+]06 to 1.0e[+]06 .rad., not'),
    ('wind__speed', ([0.0, 1e308], [1.0, 2.0], None), '1e[+]09 s, not 1e[+]308'),
    ('wind__speed', ([0.0, 1.0], [1.0, 1e308], None), 'from 0 to 200 .m/s., not 1e[+]308'),
    ('physics__grid__rows', ([0.0, 1.0], [11.0, 1e308], None), 'not 1e[+]308'),
    ('physics__grid__rows', ([0.0], [float('nan')], None), 'from 2 to 1001 .nodes., not nan'),
    ('physics__grid__rows', ([0.0], [True], None), 'not True'),
    ('physics__grid__rows', ([0.0], ['many'], None), "from 2 to 1001 .nodes., not 'many'"),
])
def test_an_animation_that_cannot_play_is_refused(track, parts, rule):
    """The message names the track, the rule and the value."""
    with pytest.raises(ValueError, match=rule):
        read(wind_values(**{track: parts}))


def test_a_limit_that_is_printed_can_be_keyed():
    """A whole turn, as the rule of an azimuth prints it, and straight up."""
    timeline = read(wind_values(
        wind__azimuth=([0.0, 1.0], [0.0, 6.28319], ['step'] * 2),
        renderer__camera__elevation=([0.0, 1.0], [0.0, 1.5708], None)))
    assert values_at(timeline, 1.0) == {
        'wind.azimuth': 2.0 * np.pi, 'renderer.camera.elevation': np.pi / 2.0}


def test_whole_numbers_and_minus_zero_are_numbers():
    """As YAML and people write them."""
    track = read(wind_values(wind__speed=([-0.0, 1], [-0.0, 8], None))).tracks[
        'wind.speed']
    assert [str(number) for number in (*track.times, *track.values)] == ['0.0', '1.0', '0.0',
                                                                         '8.0']


@pytest.mark.parametrize('values', [[0.0, 3.142, 6.283], [0.0, 9.0, 18.85], [6.28, 0.0, -12.0]])
def test_a_track_that_turns_plays_every_angle_within_the_parameters_range(values):
    """However many turns it makes; and its keys surprise nobody."""
    timeline = read(wind_values(
        renderer__camera__azimuth=([0.0, 1.0, 2.0], values, None, True)))
    asked = np.linspace(0.0, 2.0, 300)
    played = [values_at(timeline, time)['renderer.camera.azimuth'] for time in asked]
    assert np.abs(played).max() <= 2.0 * np.pi
    assert np.allclose(np.exp(1j * np.array(played)),
                       np.exp(1j * np.interp(asked, [0.0, 1.0, 2.0], values)))
    assert not keys.warnings(timeline)


def test_keys_half_a_turn_apart_are_warned_of():
    """With the way that they take, and how to turn as typed."""
    timeline = read(wind_values(
        wind__azimuth=([0.0, 4.0], [0.0, 6.283], None),
        renderer__sun__azimuth=([0.0, 4.0], [0.0, 3.0], None)))
    assert list(keys.warnings(timeline).items()) == [(
        'wind.azimuth', "track 'wind.azimuth': from its key at 0.0 s to that at 4.0 s it is half "
        'a turn or more (0.0 to 6.283 rad). Directions go the short way, here by -0.0001853 rad. '
        'Set keys.wind.azimuth.turns to true and it turns as its values say')]


@pytest.mark.parametrize('name, value, said', [
    ('keys.wind.speed.turns', True, 'speed is no direction'),
    ('keys.wind.azimuth.turns', 1.0, 'must be true or false, not 1.0'),
    ('keys.wind.azimuth.turns', [True], 'must be true or false'),
    ('keys.wind.speed.values', ['fast'], "a list of numbers, not 'fast' in it"),
    ('keys.wind.speed.values', [1.0, True], 'a list of numbers, not True in it'),
    ('keys.renderer.shading.values', [1.0], 'a list of texts, not 1.0 in it'),
    ('keys.renderer.outline.values', [1.0], 'a list of booleans, not 1.0 in it'),
    ('keys.wind.speed.laws', [1.0], 'a list of texts, not 1.0 in it'),
    ('keys.wind.speed.times', [False], 'a list of numbers, not False in it'),
])
def test_keys_of_another_type_are_refused_before_a_track_plays_them(name, value, said):
    """Else the parameter would keep that type, and the right values would be refused."""
    with pytest.raises(ValueError, match=said):
        keys.accept_keys(name, value, TARGETS)


def test_keys_snap_to_the_nearest_frame():
    """A step key typed with three decimals is seen in the frame that was meant, not the next."""
    typed = [round(frame / 30.0, 3) for frame in range(90)]
    values = wind_values(wind__speed=(typed, [float(n) for n in range(90)], ['step'] * 90))
    values.update({'events.names': ['gust'], 'events.times': [0.067]})
    late, snapped = (read({**values, 'snap_keys': snap}) for snap in (False, True))
    stamps = [round(frame * 1e9 / 30.0) / 1e9 for frame in range(90)]
    assert [snapped.value('wind.speed', stamp) for stamp in stamps] == list(range(90))
    assert sum(late.value('wind.speed', stamp) < n for n, stamp in enumerate(stamps)) == 30
    assert snapped.crossed(stamps[1], stamps[2]) == [(2 / 30, 'gust'), (2 / 30, 'wind.speed')]


def test_two_keys_of_a_track_that_snap_to_one_frame_are_refused():
    """One of them would never be seen."""
    values = wind_values(wind__speed=([0.5, 0.51], [1.0, 2.0], None))
    with pytest.raises(ValueError, match='at 0.5 s and 0.51 s are both nearest to the frame at '
                                         '0.5 s, and snap_keys allows one key a frame'):
        read({**values, 'snap_keys': True})


def test_keys_that_are_equal_but_of_another_type_are_looked_at():
    """True is no number, though it is equal to one that was read before."""
    assert read(wind_values(wind__speed=([0.0], [1.0], None))).tracks
    with pytest.raises(ValueError, match='not True'):
        read(wind_values(wind__speed=([0.0], [True], None)))


def test_events_and_tracks_must_be_consistent():
    """Two arrays that belong together have one length; a track is named once."""
    with pytest.raises(ValueError, match='not 1 and 0'):
        read({**wind_values(), 'events.names': ['a']})
    values = wind_values(wind__speed=([0.0], [1.0], None))
    with pytest.raises(ValueError, match='each track once'):
        read({**values, 'tracks': ['wind.speed', 'wind.speed']})
