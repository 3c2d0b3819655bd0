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

"""Tracks as parameters of the wind node: `tracks` names them, `keys.<track>.*` hold their keys."""
import bisect
import dataclasses
import functools
import math

from flag_sim.animation.timeline import nearest_frame, Timeline
from flag_sim.animation.tracks import Track
from flag_sim.animation.wind_source import WIND_KEYED
from flag_sim.declarations.nodes import named, NODES, TURN
from flag_sim.parameters import checks

PARTS = ('times', 'values', 'laws', 'turns')
LARGEST_ANGLE = 1e6  # of a direction that turns [rad]: there float64 still tells 1e-10 apart
ROUNDING = 1e-9  # of a direction by turns that are taken off and put on again [rad]
WORDS = {float: 'numbers', str: 'texts', bool: 'booleans'}
# What of the wind node itself can be keyed: the wind, not the clock that plays it.
KEYED_NODES = ('wind', 'physics', 'renderer')


def key_name(track, part):
    """Return the name of the parameter that holds one part of a track's keys."""
    return f'keys.{track}.{part}'


def is_key_name(name):
    """Return whether a parameter holds one part of a track's keys."""
    return name.startswith('keys.') and name.endswith(tuple(f'.{part}' for part in PARTS))


def track_of(name):
    """Return the track of which parameter `name` holds one part of the keys."""
    return name.removeprefix('keys.').rpartition('.')[0]


def item_of(name):
    """Return the type of the values that a parameter `keys.*` lists: float, str or bool."""
    if name.endswith('.values'):
        declaration = target_declaration(track_of(name))
        kind = declaration.item if declaration.is_list else type(declaration.default)
        return float if kind is int else kind  # a whole number goes through lists as a number
    return str if name.endswith('.laws') else float


def accept_keys(name, value):
    """Return the value of a parameter `keys.*` in its own type, or raise ValueError."""
    declaration = target_declaration(track_of(name))
    if name.endswith('.turns'):
        if not isinstance(value, bool):
            raise ValueError(f'{name} must be true or false, not {value!r}')
        if value:
            _turning(name, declaration)
        return value
    if not isinstance(value, (list, tuple)) and not hasattr(value, 'tolist'):
        raise ValueError(f'{name} must be a list, not {value!r}')
    return [_accept_item(name, one) for one in value]


def _accept_item(name, value):
    item = item_of(name)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (is_number if item is float else isinstance(value, item)):
        raise ValueError(f'{name} must be a list of {WORDS[item]}, not {value!r} in it')
    return float(value) if is_number else value


@functools.lru_cache(maxsize=None)
def target_declaration(track):
    """Return the parameter that a track animates; raise ValueError if it cannot be keyed."""
    node, _, name = track.partition('.')
    if node not in NODES:
        raise ValueError(f"track '{track}' must begin with one of {', '.join(KEYED_NODES)} "
                         'and a dot')
    declaration = named(node).get(name)
    if declaration is None:
        raise ValueError(f"track '{track}': /{node} has no parameter '{name}'")
    if (declaration.fixed or node not in KEYED_NODES
            or (declaration.is_list and not declaration.length)
            or (node == 'wind' and name not in WIND_KEYED)):
        raise ValueError(f"track '{track}': this parameter cannot be keyed")
    return declaration


def is_angle(declaration):
    """Return whether a parameter is a direction, of which a turn more is the same."""
    return declaration.unit == 'rad' and declaration.high == TURN


def read_timeline(values):
    """
    Return the Timeline of the wind's parameters {name: value}.

    Every key's value is checked against the parameter that it animates. Raises ValueError.
    """
    names = values['tracks']
    if len(set(names)) < len(names):
        raise ValueError(f'tracks must name each track once: {names}')
    rate = values['rate'] if values['snap_keys'] else None
    tracks = {name: _read_track(name, rate, *(values.get(key_name(name, p)) for p in PARTS))
              for name in names}
    return Timeline(tracks, _read_events(values, rate), values['loop'])


def _read_track(name, rate, times, keys, laws, turns):
    """Return the Track of a name and its parameters; raise ValueError if it cannot be played."""
    target_declaration(name)
    if times is None or keys is None:
        raise ValueError(f"track '{name}' needs {key_name(name, 'times')} and "
                         f"{key_name(name, 'values')}")
    # By types too, for True and 1.0 are equal but are not both a number.
    return _make_track(name, rate, tuple(times), tuple(keys), tuple(map(type, keys)),
                       tuple(laws or ()), bool(turns))


@functools.lru_cache(maxsize=256)
def _make_track(name, rate, times, keys, types, laws, turns):
    """Return the Track; the same again while others are edited, as two hundred keys take 4 ms."""
    del types
    declaration = target_declaration(name)
    laws = laws or (_usual_law(declaration),) * len(times)
    try:
        for law in laws if declaration.choices else ():
            if law != 'step':
                raise ValueError(f"law '{law}' cannot lead between {declaration.rule}; use step")
        if turns:
            declaration = _turning(key_name(name, 'turns'), declaration)
        keys = _accepted(declaration, keys)
        track = Track(times, keys, laws, is_angle(declaration), turns)
        return _snapped(track, rate) if rate else track
    except (ValueError, TypeError) as error:
        raise ValueError(f"track '{name}': {error}") from None


def _turning(name, declaration):
    """Return the declaration of a direction with room for many turns; else raise ValueError."""
    if not is_angle(declaration):
        raise ValueError(f'{name} must be false, not true: {declaration.name} is no direction')
    return dataclasses.replace(declaration, low=-LARGEST_ANGLE, high=LARGEST_ANGLE)


def _snapped(track, rate):
    """Return a Track with its keys at frames [Hz]; raise ValueError where two come to one."""
    frames = [nearest_frame(time, rate) for time in track.times]
    for k, (frame, following) in enumerate(zip(frames, frames[1:])):
        if frame == following:
            raise ValueError(f'its keys at {track.times[k]} s and {track.times[k + 1]} s are both '
                             f'nearest to the frame at {checks.text(frame)} s, and snap_keys '
                             'allows one key a frame')
    return Track(frames, track.values, track.laws, track.is_angle, track.turns)


def warnings(timeline):
    """Return {track name: what may surprise whoever has set its keys}."""
    found = {}
    for name, track in timeline.tracks.items():
        for k in track.long_ways()[:1]:
            times, values = track.times[k:k + 2], track.values[k:k + 2]
            found[name] = (
                f"track '{name}': from its key at {times[0]} s to that at {times[1]} s it is half "
                f'a turn or more ({values[0]} to {values[1]} rad). Directions go the short way, '
                f'here by {track.step_from(k):.4g} rad. Set {key_name(name, "turns")} to true '
                'and it turns as its values say')
    return found


def _accepted(declaration, keys):
    """Return a track's values, a list of vectors where the parameter is a list."""
    if declaration.is_list:
        length = declaration.length
        if len(keys) % length:
            raise ValueError(f'values must hold {length} numbers a key, not {len(keys)}')
        return [declaration.accept(keys[i:i + length]) for i in range(0, len(keys), length)]
    return [declaration.accept(_back_to_whole(v) if _is_whole(declaration) else v) for v in keys]


def _is_whole(declaration):
    return type(declaration.default) is int


def _back_to_whole(value):
    """Return as an int what has gone through parameters as a number; all else as it is."""
    is_whole = isinstance(value, float) and value.is_integer() and abs(value) < 2.0 ** 63
    return int(value) if is_whole else value


def _read_events(values, rate):
    names, times = values['events.names'], values['events.times']
    if len(names) != len(times):
        raise ValueError('events.names and events.times must be of one length, not '
                         f'{len(names)} and {len(times)}')
    return list(zip([nearest_frame(time, rate) for time in times] if rate else times, names))


def values_at(timeline, time):
    """Return {track name: value at `time` [s]} as the parameters take them."""
    return {name: _to_parameter(name)(value) for name, value in timeline.at(time).items()}


@functools.lru_cache(maxsize=None)
def _to_parameter(track):
    """Return the function that brings a track's values into the type of what it animates."""
    declaration = target_declaration(track)
    if _is_whole(declaration):
        return round
    return _within_a_turn if is_angle(declaration) else lambda value: value


def _usual_law(declaration):
    """
    Return the law that leads on from a key of a parameter unless another is given.

    Texts and booleans have nothing between them, and counts, as the width of a picture, no glide.
    """
    return 'linear' if type(declaration.default) in (float, list) else 'step'


def _within_a_turn(angle):
    return math.remainder(angle, TURN) if abs(angle) > TURN else angle


def with_key(values, track, time, value, old, reach):
    """
    Return {parameter: value} that puts a key into a track of the wind's parameters `values`.

    A track that is not there is made, with the value `old` from 0 until the key: what was seen
    before plays again as it was seen. A key within `reach` [s] of `time` is replaced. A value that
    the parameter has at `time` already, by its track or, without one, as `old`, makes no key: then
    {} is returned.
    Raises ValueError where the parameter cannot be keyed or cannot have the value.
    """
    declaration = target_declaration(track)
    value = declaration.accept(value)
    is_first = track not in values['tracks']
    if is_first:
        old = declaration.accept(old)
        if value == old:
            return {}
        played, times, keyed, laws = [0.0], [0.0], [old], [_usual_law(declaration)]
        tracks = [*values['tracks'], track]
    else:
        present = read_timeline(values).tracks[track]
        value = _on_its_turn(present, time, value)
        if present.at(time) == value:
            return {}
        # As they were set, which is not quite when they play where keys snap to frames.
        times, played = list(values[key_name(track, 'times')]), present.times
        keyed, laws = list(present.values), list(present.laws)
        tracks = values['tracks']
    nearest = min(range(len(played)), key=lambda k: abs(played[k] - time))
    if abs(played[nearest] - time) <= reach:
        keyed[nearest] = value
    else:
        k = bisect.bisect(played, time)
        times.insert(k, time)
        keyed.insert(k, value)
        laws.insert(k, laws[max(k - 1, 0)])  # a segment that is cut keeps its law on both sides
        if is_first:
            laws[0] = 'step'
    flat = [v for key in keyed for v in key] if declaration.is_list else keyed
    flat = [float(v) for v in flat] if _is_whole(declaration) else flat
    return {'tracks': tracks, key_name(track, 'times'): times,
            key_name(track, 'values'): flat, key_name(track, 'laws'): laws}


def _on_its_turn(track, time, value):
    """Return a value, a direction that turns with as many turns as bring it near what plays."""
    if not track.turns:
        return value
    here = track.at(time)
    way = math.remainder(value - here, TURN)
    return here + way if abs(way) > ROUNDING else here
