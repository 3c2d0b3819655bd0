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

"""Targets: the parameters that tracks may animate, by the declarations that are handed in."""
from collections.abc import Collection, Iterable, Mapping
import dataclasses
import math

from flag_sim.animation.tracks import TURN
from flag_sim.parameters.declaration import Declaration
import numpy as np

LARGEST_ANGLE = 1e6
"""Greatest angle of a track with `turns` [rad]: float64 still resolves 1e-10 there."""


@dataclasses.dataclass(frozen=True, eq=False)  # by identity: lists of defaults have no hash
class Target:
    """One parameter as what a track animates."""

    declaration: Declaration

    @property
    def is_angle(self) -> bool:
        """Return whether it is a direction [rad], of which a whole turn more is the same."""
        return self.declaration.unit == 'rad' and self.declaration.high == TURN

    @property
    def is_whole(self) -> bool:
        """Return whether it is a whole number."""
        return type(self.declaration.default) is int

    @property
    def item(self) -> type:
        """Return the type of what a list of keys holds: float, str or bool."""
        declaration = self.declaration
        kind = declaration.item if declaration.is_list else type(declaration.default)
        return float if kind is int else kind  # lists hold a whole number as a float

    @property
    def usual_law(self) -> str:
        """
        Return the law that leads on from a key unless another is given.

        Texts and booleans have nothing between them; counts, as the width of a picture, step too.
        """
        return 'linear' if type(self.declaration.default) in (float, list) else 'step'

    def turning(self) -> 'Target':
        """Return the same direction with room for many turns; raise ValueError for others."""
        if not self.is_angle:
            raise ValueError(f'{self.declaration.name} is no direction')
        return Target(dataclasses.replace(
            self.declaration, low=-LARGEST_ANGLE, high=LARGEST_ANGLE))

    def accept(self, values: Iterable) -> list:
        """
        Return the values of the keys, one a key, from the flat list of a parameter.

        A target that is a list takes as many numbers a key as it has. Raises ValueError for a
        value that the parameter cannot have.
        """
        accept, values = self.declaration.accept, list(values)
        numbers = self._all_in_range(values)
        if numbers is not None:
            return numbers
        if self.declaration.is_list:
            length = self.declaration.length
            if len(values) % length:
                raise ValueError(f'values must hold {length} numbers a key, not {len(values)}')
            return [accept(values[i:i + length]) for i in range(0, len(values), length)]
        return [accept(_as_int(value) if self.is_whole else value) for value in values]

    def _all_in_range(self, values):
        """Return numbers that need no further look, or None: a million are checked at once."""
        declaration = self.declaration
        if declaration.kind is not float or set(map(type, values)) != {float}:
            return None
        numbers = np.array(values) + 0.0
        low = -np.inf if declaration.low is None else declaration.low
        high = np.inf if declaration.low is None else declaration.high
        if not (np.isfinite(numbers) & (low <= numbers) & (numbers <= high)).all():
            return None
        if not declaration.is_list:
            return numbers.tolist()
        if not declaration.length or len(values) % declaration.length:
            return None
        return numbers.reshape(-1, declaration.length).tolist()

    def flat(self, values: Iterable) -> list:
        """Return the values of keys, one a key, as the flat list that a parameter holds."""
        if self.declaration.is_list:
            return [number for vector in values for number in vector]
        return [float(value) if self.is_whole else value for value in values]

    def played(self, value: object) -> object:
        """Return what a track plays in the parameter's own type and range."""
        if self.is_whole:
            return round(value)
        if self.is_angle and abs(value) > TURN:
            return math.remainder(value, TURN)
        return value


class Targets:
    """
    Every parameter that can be keyed, by the name of its track, node.parameter.

    declarations: {node: its declarations}; keyed: {node: the names that may be keyed, or None for
    all}; instead: {track: the one that animates it}. Fixed parameters and lists of any length are
    never keyed.
    """

    def __init__(self, declarations: Mapping[str, Iterable[Declaration]],
                 keyed: Mapping[str, Collection[str] | None],
                 instead: Mapping[str, str] | None = None):
        self._declared = {node: {declaration.name: declaration for declaration in own}
                          for node, own in declarations.items()}
        self._keyed = dict(keyed)
        self._instead = dict(instead or {})
        self._found: dict[str, Target] = {}

    def __getitem__(self, track: str) -> Target:
        """Return the target of a track; raise ValueError if it cannot be keyed."""
        if track not in self._found:  # asked for with every frame
            self._found[track] = self._find(track)
        return self._found[track]

    def __contains__(self, track: str) -> bool:
        """Return whether a track of that name could be keyed."""
        try:
            self[track]
        except ValueError:
            return False
        return True

    def track_of(self, node: str, name: str) -> str:
        """Return the track that animates a node's parameter, whether or not it can be keyed."""
        track = f'{node}.{name}'
        return self._instead.get(track, track)

    def _find(self, track):
        if track in self._instead:
            raise ValueError(f"track '{track}' is keyed as '{self._instead[track]}', for all "
                             'nodes that have it')
        node, _, name = track.partition('.')
        if node not in self._declared:
            raise ValueError(f"track '{track}' must begin with one of {', '.join(self._keyed)} "
                             'and a dot')
        declaration = self._declared[node].get(name)
        if declaration is None:
            raise ValueError(f"track '{track}': /{node} has no parameter '{name}'")
        names = self._keyed.get(node, ())
        is_open_list = declaration.is_list and not declaration.length
        if declaration.fixed or is_open_list or (names is not None and name not in names):
            raise ValueError(f"track '{track}': this parameter cannot be keyed")
        return Target(declaration)


def _as_int(value):
    """Return a whole number that was held as a float as an int; all else as it is."""
    is_whole = isinstance(value, float) and value.is_integer() and abs(value) < 2.0 ** 63
    return int(value) if is_whole else value
