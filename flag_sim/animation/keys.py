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

"""
Keys as parameters: `tracks` names the tracks, `keys.<track>.*` hold the keys of each.

The parameters are those of the wind node, {name: value} as in a params file; what a track may
animate is in the `targets` that every function here is given.
"""
from collections.abc import Mapping
import functools

from flag_sim.animation.targets import Targets
from flag_sim.animation.timeline import nearest_frame, Timeline
from flag_sim.animation.tracks import Track
from flag_sim.parameters import checks

PARTS = ('times', 'values', 'laws', 'turns')
"""The parts of a track's keys, each a parameter of its own."""

WORDS = {float: 'numbers', str: 'texts', bool: 'booleans'}


def key_name(track: str, part: str) -> str:
    """Return the name of the parameter that holds one part of a track's keys."""
    return f'keys.{track}.{part}'


def is_key_name(name: str) -> bool:
    """Return whether a parameter holds one part of a track's keys."""
    return name.startswith('keys.') and name.endswith(tuple(f'.{part}' for part in PARTS))


def track_of(name: str) -> str:
    """Return the track of which the parameter `name` holds one part of the keys."""
    return name.removeprefix('keys.').rpartition('.')[0]


def item_of(name: str, targets: Targets) -> type:
    """Return the type of the values that a parameter `keys.*` lists: float, str or bool."""
    if name.endswith('.values'):
        return targets[track_of(name)].item
    return str if name.endswith('.laws') else float


def accept_keys(name: str, value: object, targets: Targets) -> list | bool:
    """Return the value of a parameter `keys.*` in its own type; raise ValueError for others."""
    target = targets[track_of(name)]
    if name.endswith('.turns'):
        if not isinstance(value, bool):
            raise ValueError(f'{name} must be true or false, not {checks.shown(value)}')
        if value:
            _turning(name, target)
        return value
    if not isinstance(value, (list, tuple)) and not hasattr(value, 'tolist'):
        raise ValueError(f'{name} must be a list, not {checks.shown(value)}')
    item = item_of(name, targets)
    return [_accept_item(name, one, item) for one in value]


def _accept_item(name, value, item):
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (is_number if item is float else isinstance(value, item)):
        raise ValueError(f'{name} must be a list of {WORDS[item]}, not {checks.shown(value)} '
                         'in it')
    return float(value) if is_number else value


def _turning(name, target):
    try:
        return target.turning()
    except ValueError as error:
        raise ValueError(f'{name} must be false, not true: {error}') from None


def read_timeline(values: Mapping, targets: Targets) -> Timeline:
    """
    Return the Timeline of the wind's parameters {name: value}.

    Every key's value is checked against the parameter that it animates. Raises ValueError.
    """
    names = values['tracks']
    if len(set(names)) < len(names):
        raise ValueError(f'tracks must name each track once: {names}')
    rate = values['rate'] if values['snap_keys'] else None
    tracks = {name: _read_track(name, rate, values, targets) for name in names}
    return Timeline(tracks, _read_events(values, rate), values['loop'])


def _read_track(name, rate, values, targets):
    """Return the Track of a name; raise ValueError if it cannot be played."""
    target = targets[name]
    times, keys, laws, turns = (values.get(key_name(name, part)) for part in PARTS)
    if times is None or keys is None:
        raise ValueError(f"track '{name}' needs {key_name(name, 'times')} and "
                         f"{key_name(name, 'values')}")
    # By types too, for True and 1.0 are equal but are not both a number.
    return _make_track(name, target, rate, tuple(times), tuple(keys), tuple(map(type, keys)),
                       tuple(laws or ()), bool(turns))


@functools.lru_cache(maxsize=256)
def _make_track(name, target, rate, times, keys, types, laws, turns):
    """Return the Track; the same again while others are edited, as two hundred keys take 4 ms."""
    del types
    laws = laws or (target.usual_law,) * len(times)
    try:
        for law in laws if target.declaration.choices else ():
            if law != 'step':
                raise ValueError(f"law '{law}' cannot lead between {target.declaration.rule}; "
                                 'use step')
        accepting = _turning(key_name(name, 'turns'), target) if turns else target
        track = Track(times, accepting.accept(keys), laws, target.is_angle, turns)
        return _snapped(track, rate) if rate else track
    except (ValueError, TypeError) as error:
        raise ValueError(f"track '{name}': {error}") from None


def _snapped(track, rate):
    """Return a Track with its keys at frames [Hz]; raise ValueError where two come to one."""
    frames = [nearest_frame(time, rate) for time in track.times]
    for k, (frame, following) in enumerate(zip(frames, frames[1:])):
        if frame == following:
            raise ValueError(f'its keys at {track.times[k]} s and {track.times[k + 1]} s are both '
                             f'nearest to the frame at {checks.text(frame)} s, and snap_keys '
                             'allows one key a frame')
    return Track(frames, track.values, track.laws, track.is_angle, track.turns)


def _read_events(values, rate):
    names, times = values['events.names'], values['events.times']
    if len(names) != len(times):
        raise ValueError('events.names and events.times must be of one length, not '
                         f'{len(names)} and {len(times)}')
    return list(zip([nearest_frame(time, rate) for time in times] if rate else times, names))


def values_at(timeline: Timeline, time: float, targets: Targets) -> dict[str, object]:
    """Return {track name: value at `time` [s]}, each in the type of what it animates."""
    return {name: targets[name].played(value) for name, value in timeline.at(time).items()}


def warnings(timeline: Timeline) -> dict[str, str]:
    """Return {track name: a warning of keys that may not do what their user expects}."""
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
