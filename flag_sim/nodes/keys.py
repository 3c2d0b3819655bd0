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
from flag_sim.animation.tracks import Track
from flag_sim.nodes.dials import NODES

PARTS = ('times', 'values', 'laws')
# What of the wind node itself can be keyed: the wind, not the clock that plays it.
WIND_KEYED = ('speed', 'azimuth', 'elevation')


def key_name(track, part):
    """Return the name of the parameter that holds one part of a track's keys."""
    return f'keys.{track}.{part}'


def accept_keys(name, value):
    """Return the value of a parameter `keys.*` in its own type, or raise ValueError."""
    if not isinstance(value, (list, tuple)) and not hasattr(value, 'tolist'):
        raise ValueError(f'{name} must be a list, not {value!r}')
    values = list(value)
    numbers = [v for v in values if isinstance(v, (int, float)) and not isinstance(v, bool)]
    if name.endswith('.times') and len(numbers) < len(values):
        raise ValueError(f'{name} must be a list of numbers [s], not {values}')
    if name.endswith('.laws') and not all(isinstance(v, str) for v in values):
        raise ValueError(f'{name} must be a list of texts, not {values}')
    return [float(v) for v in values] if values and len(numbers) == len(values) else values


def target_dial(track):
    """Return the dial that a track animates; raise ValueError if there is none or it cannot be."""
    node, _, name = track.partition('.')
    if node not in NODES:
        raise ValueError(f"track '{track}' must begin with one of {', '.join(NODES)} and a dot")
    dial = next((dial for dial in NODES[node] if dial.name == name), None)
    if dial is None:
        raise ValueError(f"track '{track}': /{node} has no parameter '{name}'")
    if dial.fixed or dial.is_list or node == 'recorder' or (
            node == 'wind' and name not in WIND_KEYED):
        raise ValueError(f"track '{track}': this parameter cannot be keyed")
    return dial


def read_tracks(values):
    """
    Return {track name: (Track, dial)} from the wind's parameters {name: value}.

    Every key's value is checked against the parameter that it animates. Raises ValueError.
    """
    tracks = {}
    for name in values['tracks']:
        dial = target_dial(name)
        times, keys, laws = (values.get(key_name(name, part)) for part in PARTS)
        if times is None or keys is None:
            raise ValueError(f"track '{name}' needs {key_name(name, 'times')} and "
                             f"{key_name(name, 'values')}")
        try:
            # A whole number goes through parameters as a number and comes back here.
            whole = isinstance(dial.default, int) and not isinstance(dial.default, bool)
            keys = [int(v) if whole and v == int(v) else v for v in keys]
            tracks[name] = Track(times, [dial.accept(v) for v in keys], laws), dial
        except (ValueError, TypeError, OverflowError) as error:
            raise ValueError(f"track '{name}': {error}") from None
    return tracks


def values_at(tracks, time):
    """Return {track name: value at `time` [s]}; a whole number's states in between are rounded."""
    return {name: type(dial.default)(round(track.at(time)) if type(dial.default) is int
                                     else track.at(time))
            for name, (track, dial) in tracks.items()}
