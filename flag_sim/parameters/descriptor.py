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

"""What a node tells of one of its parameters, as a client of any node can know it."""
import dataclasses
import re

from flag_sim.parameters.declaration import TURN

UNIT = re.compile(r' \[([^\]]+)\]$')
CHOICES = re.compile(r'one of ([^\[\]]+)')
RANGE = re.compile(r'from (\S+) to (\S+)')
LENGTH = re.compile(r'a list of (\d+) values')
TURN_TOLERANCE = 1e-3
"""By how much a printed limit of a turn may miss it [rad]."""


@dataclasses.dataclass(frozen=True)
class Descriptor:
    """
    One parameter of a running node.

    kind: bool, int, float or str, or a list of one of them: bools, ints, floats, strs; other for
    what is none of these. unit: [as its description ends with it] or ''. rule: in words what a
    value must be, or ''. low, high: inclusive range, of each number where it is a list; None where
    it has none. choices: the values that are allowed; empty allows any. length: how many values a
    list must have; None allows any number. is_fixed: whether it counts only at the node's start.
    """

    name: str
    kind: str = 'other'
    effect: str = ''
    unit: str = ''
    rule: str = ''
    low: float | None = None
    high: float | None = None
    choices: tuple = ()
    length: int | None = None
    is_fixed: bool = False

    @property
    def is_list(self) -> bool:
        """Return whether the value is a list."""
        return self.kind.endswith('s')

    @property
    def is_colour(self) -> bool:
        """Return whether the value is red, green and blue from 0 to 255."""
        return self.kind == 'floats' and (self.length, self.low, self.high) == (3, 0.0, 255.0)

    @property
    def is_direction(self) -> bool:
        """Return whether a whole turn more is the same direction [rad]."""
        return (self.unit == 'rad' and self.high is not None
                and abs(self.high - TURN) < TURN_TOLERANCE)

    @property
    def group(self) -> str:
        """Return the part of the name before its first dot, or '' where there is none."""
        return self.name.partition('.')[0] if '.' in self.name else ''

    @property
    def tooltip(self) -> str:
        """Return what is known of the parameter, for a tooltip."""
        unit = f' [{self.unit}]' if self.unit else ''
        fixed = 'read once, at the start of the node' if self.is_fixed else ''
        return '\n'.join(line for line in (
            self.name, self.effect + unit, self.rule, fixed) if line)


def described(name: str, kind: str, description: str, constraints: str,
              limits: tuple[float | None, float | None] = (None, None),
              is_fixed: bool = False) -> Descriptor:
    """
    Return the Descriptor of what a node's rcl_interfaces/ParameterDescriptor says.

    A description may end with its unit, `[m/s]`. Choices, a list's length and the range of its
    numbers, for which ROS has no fields, are read from the constraints' words where they stand
    there: `one of a, b`, `a list of 3 values`, `from 0 to 255`.
    """
    unit = UNIT.search(description)
    words = UNIT.sub('', constraints)
    low, high = limits
    within = RANGE.search(words)
    if low is None and within and kind in ('ints', 'floats'):
        low, high = (_number(end) for end in within.groups())
    length = LENGTH.search(words)
    return Descriptor(
        name, kind, UNIT.sub('', description), unit[1] if unit else '', constraints, low, high,
        _choices(words, kind), int(length[1]) if length else None, is_fixed)


def _choices(words, kind):
    found = CHOICES.search(words)
    if not found or kind not in ('int', 'str'):
        return ()
    texts = found[1].split(', ')
    if kind == 'str':
        return tuple(texts)
    return tuple(map(int, texts)) if all(text.lstrip('-').isdigit() for text in texts) else ()


def _number(text):
    try:
        return float(text)
    except ValueError:
        return None
