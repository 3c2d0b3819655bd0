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

"""Autokey: a value that a user sets while a shot plays becomes a key (the source's sec. 1.5)."""
import bisect
from collections.abc import Mapping
import math

from flag_sim.animation.keys import key_name, read_timeline
from flag_sim.animation.targets import Targets
from flag_sim.animation.tracks import Track, TURN

ROUNDING = 1e-9
"""Rounding error of a direction after whole turns are subtracted and added again [rad]."""


def with_key(values: Mapping, track: str, time: float, value: object, old: object, *,
             reach: float, targets: Targets, present: Track | None = None) -> dict[str, list]:
    """
    Return {parameter: value} that puts a key into a track of the wind's parameters `values`.

    present: the track as it is played, which is else read from the values.
    value: of the key at `time` [s]; old: what the parameter was before. A track that is not there
    is made, with `old` from 0 until the key: what was seen before plays again as it was seen. A
    key within `reach` [s] of `time` is replaced. A value that the parameter has at `time` already,
    by its track or, without one, as `old`, makes no key: then {} is returned.
    Raises ValueError where the parameter cannot be keyed or cannot have the value.
    """
    target = targets[track]
    value = target.declaration.accept(value)
    is_first = track not in values['tracks']
    if is_first:
        old = target.declaration.accept(old)
        if value == old:
            return {}
        played, times, keyed, laws = [0.0], [0.0], [old], [target.usual_law]
        tracks = [*values['tracks'], track]
    else:
        present = present or read_timeline(values, targets).tracks[track]
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
    return {'tracks': tracks, key_name(track, 'times'): times,
            key_name(track, 'values'): target.flat(keyed), key_name(track, 'laws'): laws}


def _on_its_turn(track, time, value):
    """Return a value, a direction that turns with as many turns as bring it near what plays."""
    if not track.turns:
        return value
    here = track.at(time)
    way = math.remainder(value - here, TURN)
    return here + way if abs(way) > ROUNDING else here
