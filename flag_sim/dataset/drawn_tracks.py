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
Tracks of a recipe: keys whose times and values may be drawn.

    tracks:
      wind.speed:
        times: [0.0, {uniform: [1.0, 3.0]}, 5.0]
        values: {uniform: [2.0, 14.0]}         # drawn anew for each key; or a list, one a key
        laws: cubic                            # of all segments; or a list
"""
from collections.abc import Callable
import dataclasses

from flag_sim.animation.keys import key_name
from flag_sim.animation.laws import LAWS
from flag_sim.animation.tracks import LATEST_KEY, LEAST_KEY_SPACING
from flag_sim.dataset.draws import Stream
from flag_sim.dataset.laws import Law, read_law
from flag_sim.dataset.marked_yaml import Marked
from flag_sim.dataset.targets import ONE_SIZE
from flag_sim.declarations.keyable import TARGETS
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import Declaration

PARTS = ('times', 'values', 'laws', 'turns')
MOST_KEYS = 10_000
TIME = Declaration('times', 0.0, 'of a key', 's', -LATEST_KEY, LATEST_KEY)


@dataclasses.dataclass(frozen=True)
class DrawnTrack:
    """A track: the laws of its keys' times [s] and values, and what leads on from each key."""

    name: str
    times: tuple[Law, ...]
    values: tuple[Law, ...]
    laws: tuple[str, ...]
    turns: bool

    def draw(self, stream_of: Callable[[str], Stream]) -> dict[str, object]:
        """
        Return the wind node's parameters {keys.<track>.<part>: value} of one clip.

        stream_of(name): the stream of a name.
        """
        target = TARGETS[self.name]
        drawn = {}
        for part in ('times', 'values'):
            stream = stream_of(key_name(self.name, part))
            drawn[part] = [law.draw(stream) for law in getattr(self, part)]
        parts = {'times': drawn['times'], 'values': target.flat(drawn['values']),
                 'laws': list(self.laws)}
        if self.turns:
            parts['turns'] = True
        return {key_name(self.name, part): value for part, value in parts.items() if value}


def read_track(name: str, marked: Marked) -> DrawnTrack:
    """Return a recipe's track; raise MarkedError for what it cannot be."""
    try:
        target = TARGETS[name]
    except ValueError as error:
        raise marked.error(error) from None
    if name.partition('.')[2] in ONE_SIZE:
        raise marked.error(f'track {name}: all frames of a clip are of one size')
    entries = marked.entries()
    for part, one in entries.items():
        if part not in PARTS:
            raise one.error(f'track {name} has {", ".join(PARTS)}, and no {part!r}')
    for part in ('times', 'values'):
        if part not in entries:
            raise marked.error(f'track {name} needs {part}')
    given = entries['times'].items()
    if not 0 < len(given) <= MOST_KEYS:
        raise entries['times'].error(
            f'track {name} must have from 1 to {MOST_KEYS} keys, not {len(given)}')
    times = tuple(read_law(one, TIME) for one in given)
    for one, before, after in zip(given[1:], times, times[1:]):
        if after.reach()[0] - before.reach()[1] < LEAST_KEY_SPACING:
            first, last = checks.text(after.reach()[0]), checks.text(before.reach()[1])
            raise one.error(f'track {name}: this key may be at {first} s, and must come after '
                            f'the one before, at up to {last} s')
    turns = 'turns' in entries and entries['turns'].checked(checks.boolean)
    declaration = target.declaration
    if turns:
        try:
            declaration = target.turning().declaration
        except ValueError as error:
            raise entries['turns'].error(error) from None
    return DrawnTrack(name, times, _values(name, entries['values'], len(times), declaration),
                      _laws(name, entries.get('laws'), len(times)), turns)


def _values(name, marked, count, declaration):
    """Return the law of each key's value."""
    if isinstance(marked.value, dict):
        return (read_law(marked, declaration, f'track {name}'),) * count
    given = marked.items()
    if len(given) != count:
        raise marked.error(f'track {name} must have as many values as times, {count}, '
                           f'not {len(given)}')
    return tuple(read_law(one, declaration, f'track {name}') for one in given)


def _laws(name, marked, count):
    """Return the laws of the segments; none: the usual ones."""
    if marked is None:
        return ()
    given = [marked] * count if isinstance(marked.value, str) else marked.items()
    if len(given) != count:
        raise marked.error(f'track {name} must have as many laws as times, {count}, '
                           f'not {len(given)}')
    for one in given:
        if one.value not in LAWS:
            raise one.error(f'track {name}: law {one.plain()!r} is not one of {", ".join(LAWS)}')
    return tuple(one.value for one in given)
