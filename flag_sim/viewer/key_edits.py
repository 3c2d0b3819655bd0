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

"""Edits of one track's keys, as the wind's parameters that say so. No Qt."""
import bisect
from collections.abc import Mapping
from typing import NamedTuple

from flag_sim.parameters.descriptor import Descriptor

PARTS = ('times', 'values', 'laws', 'turns')
"""The parts of a track's keys, each a parameter of the wind of its own."""


def name_of(track: str, part: str) -> str:
    """Return the parameter of the wind that holds a part of a track's keys."""
    return f'keys.{track}.{part}'


class Keys(NamedTuple):
    """
    The keys of a track in the order of time.

    times [s]; values: one a key, a list where the track is one of vectors; laws: each for the
    segment that its key begins; turns: whether directions are taken as they are.
    """

    times: list[float]
    values: list
    laws: list[str]
    turns: bool = False

    def moved(self, k: int, time: float, value: object) -> tuple['Keys', int]:
        """Return the keys with one at another time and value, and its new place among them."""
        rest = self.without(k)
        place = bisect.bisect_right(rest.times, time)
        return rest.having(time, value, self.laws[k]), place

    def having(self, time: float, value: object, law: str) -> 'Keys':
        """Return the keys with one more; one at the same time it replaces."""
        if time in self.times:
            return self.without(self.times.index(time)).having(time, value, law)
        place = bisect.bisect(self.times, time)
        return Keys(*([*old[:place], new, *old[place:]] for old, new in (
            (self.times, time), (self.values, value), (self.laws, law))), self.turns)

    def without(self, k: int) -> 'Keys':
        """Return the keys but one."""
        return Keys(*([*old[:k], *old[k + 1:]] for old in self[:3]), self.turns)

    def with_law(self, k: int, law: str) -> 'Keys':
        """Return the keys with another law for the segment that one begins."""
        return self._replace(laws=[*self.laws[:k], law, *self.laws[k + 1:]])

    def law_at(self, time: float) -> str:
        """Return the law of the segment that a time is in, or of the nearest."""
        return self.laws[min(max(bisect.bisect(self.times, time) - 1, 0), len(self.laws) - 1)]


def usual_law(descriptor: Descriptor, flat: list | None) -> str:
    """Return the law that leads on from a key unless another is given."""
    kind = descriptor.kind
    if kind == 'other' and flat:
        kind = type(flat[0]).__name__
    return 'linear' if kind in ('float', 'floats') else 'step'


def read_keys(values: Mapping, track: str, usual_law: str, length: int | None) -> Keys | None:
    """
    Return the keys that the wind's parameters {name: value} hold for a track, or None.

    length: how many numbers a key has where the track is one of vectors, else None.
    """
    times, flat, laws, turns = (values.get(name_of(track, part)) for part in PARTS)
    if not times or not flat:
        return None
    if length:
        if len(flat) != length * len(times):
            return None
        flat = [[*flat[k:k + length]] for k in range(0, len(flat), length)]
    if len(flat) != len(times) or (laws and len(laws) != len(times)):
        return None
    return Keys([*times], [*flat], [*laws] if laws else [usual_law] * len(times), bool(turns))


def changes_of(values: Mapping, track: str, keys: Keys | None) -> dict[str, object]:
    """
    Return the wind's parameters that are to be set so that a track has these keys.

    None or no keys: there is no such track any more. values: what the wind has now.
    """
    tracks = values.get('tracks') or []
    if keys is None or not keys.times:
        there = [name_of(track, part) for part in PARTS if name_of(track, part) in values]
        return {'tracks': [name for name in tracks if name != track],
                **dict.fromkeys(there)}
    flat = keys.values
    if isinstance(flat[0], list):
        flat = [number for vector in flat for number in vector]
    changes = {name_of(track, 'times'): keys.times, name_of(track, 'values'): flat,
               name_of(track, 'laws'): keys.laws}
    return changes if track in tracks else {'tracks': [*tracks, track], **changes}
