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
Laws by which a recipe says a value: fixed, or drawn for each clip.

    wind.speed: 6.0                                # fixed
    physics.solver: {choice: [symplectic, xpbd]}   # one of these, each entry as likely
    wind.azimuth: {uniform: [-3.14, 3.14]}         # equally likely from one end to the other
    physics.area_density: {log_uniform: [0.05, 0.5]}   # each doubling as likely as the next
    renderer.sun.elevation: {sphere: [0.2, 1.5]}   # each part of the sphere as likely

`sphere` is for the elevation of a direction whose azimuth is uniform. The ends of a vector are
vectors. Whole numbers are drawn with both ends.
"""
from collections.abc import Callable
import dataclasses
import math
from typing import NamedTuple

from flag_sim.dataset.draws import Stream
from flag_sim.dataset.marked_yaml import Marked
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import Declaration

MOST_CHOICES = 100_000


class Span(NamedTuple):
    """A law between two ends: whether they can be, in words, and a value from a unit number."""

    broken: Callable[[float, float], str]
    between: Callable[[float, float, float], float]


def _uniform(low, high, unit):
    return low + unit * (high - low)


def _log_uniform(low, high, unit):
    return math.exp(math.log(low) + unit * (math.log(high) - math.log(low)))


def _sphere(low, high, unit):
    return math.asin(_uniform(math.sin(low), math.sin(high), unit))


def _is_elevation(low, high):
    return -math.pi / 2.0 <= low and high <= math.pi / 2.0


SPANS = {
    'uniform': Span(lambda low, high: '', _uniform),
    'log_uniform': Span(
        lambda low, high: '' if low > 0.0 else
        f'its lower end must be above 0, not {checks.text(low)}',
        _log_uniform),
    'sphere': Span(
        lambda low, high: '' if _is_elevation(low, high) else
        'its ends must be elevations, from -pi/2 to pi/2', _sphere),
}
NAMES = ('choice', *SPANS)


@dataclasses.dataclass(frozen=True)
class Law:
    """
    How a value is said.

    name: fixed or one of NAMES; values: the fixed one, the choices, or the two ends; is_whole:
    whether whole numbers are drawn.
    """

    name: str
    values: tuple
    is_whole: bool = False

    def draw(self, stream: Stream) -> object:
        """Return a value of one clip; a fixed one draws nothing."""
        if self.name == 'fixed':
            return self.values[0]
        if self.name == 'choice':
            return self.values[stream.whole(len(self.values))]
        low, high = self.values
        if isinstance(low, list):
            return [self._number(*ends, stream) for ends in zip(low, high)]
        return self._number(low, high, stream)

    def _number(self, low, high, stream):
        if self.is_whole and self.name == 'uniform':
            return low + stream.whole(high - low + 1)
        value = SPANS[self.name].between(low, high, stream.unit())
        value = round(value) if self.is_whole else value
        return min(max(value, low), high)  # rounding must not lead beyond an end

    def reach(self) -> tuple[float, float]:
        """Return the least and the greatest number that may be drawn."""
        return min(self.values), max(self.values)


def read_law(marked: Marked, declaration: Declaration, name: str = '') -> Law:
    """
    Return the law of a recipe's entry for a parameter.

    name: of the parameter in messages. Raises MarkedError for what its declaration refuses, for
    another law, and for one that the parameter cannot have.
    """
    name = name or marked.where

    def accepted(one):
        try:
            return declaration.accept(one.plain(), name)
        except ValueError as error:
            raise one.refused(error) from None

    if not isinstance(marked.value, dict):
        return Law('fixed', (accepted(marked),))
    if len(marked.value) != 1 or next(iter(marked.value)) not in NAMES:
        raise marked.error(f'{name} must be a value or one of {", ".join(NAMES)}, '
                           f'as {{uniform: [0.0, 1.0]}}, not {marked.plain()!r}')
    (law, given), = marked.value.items()
    values = tuple(map(accepted, given.items()))
    if law == 'choice':
        if not 0 < len(values) <= MOST_CHOICES:
            raise given.error(f'{name}: a choice must have from 1 to {MOST_CHOICES} values, not '
                              f'{len(values)}')
        return Law(law, values)
    return Law(law, _checked_ends(law, values, given, declaration, name),
               declaration.kind is int)


def _checked_ends(law, values, given, declaration, name):
    """Return the two ends of a span; raise MarkedError for others."""
    if declaration.kind not in (int, float):
        raise given.error(f'{name}: {law} is for numbers; this is {declaration.rule}')
    if len(values) != 2:
        raise given.error(f'{name}: {law} must have two ends, not {len(values)}')
    pairs = list(zip(*values)) if isinstance(values[0], list) else [values]
    if law == 'sphere' and (declaration.is_list or not declaration.name.endswith('elevation')):
        raise given.error(f'{name}: sphere is for an elevation')
    for low, high in pairs:
        broken = ('' if low < high or (low == high and len(pairs) > 1) else
                  'its lower end must be below the upper one, not '
                  f'{checks.text(low)} and {checks.text(high)}')
        broken = broken or SPANS[law].broken(low, high)
        if broken:
            raise given.error(f'{name}: {law}: {broken}')
    return values
