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

"""A declaration: the name, type, default, unit, range, choices and effect of one parameter."""
import dataclasses
import math
import numbers

from flag_sim.parameters import checks

TYPES = {bool: 'boolean', int: 'whole number', float: 'number', str: 'text'}
"""The types of single values, in words."""
TURN = 2.0 * math.pi
"""
Directions [rad] go one turn to either side, so that a track may pass through half a turn.

What is beyond is most often meant in degrees.
"""

MAX_CHARACTERS = 4096
"""Of a text: the longest path that Linux takes."""
MAX_VALUES = 4_000_000
"""Of a list of any length."""


def as_typed(number: float) -> str:
    """Return a number rounded to six digits, as YAML 1.1 and so `ros2 param set` takes it."""
    mantissa, e, exponent = f'{number:g}'.partition('e')
    # YAML reads 1e+09 as a text, and 1.0e+09 as a number.
    return mantissa + ('.0' if e and '.' not in mantissa else '') + e + exponent


def _as_python(value):
    """Return a list or a number for one of numpy or of the module array, else the value."""
    is_array = hasattr(value, 'tolist') and not isinstance(value, type)
    return value.tolist() if is_array else value


@dataclasses.dataclass(frozen=True)
class Declaration:
    """
    One parameter.

    default: bool, int, float, str, or a list of float or str; its type is the parameter's type.
    low, high: inclusive range of a number, or of each number of a list; a limit that has more
    digits than are printed is meant by its printed form too (see checks.within).
    choices: the texts or whole numbers that are allowed; empty allows any.
    length: how many values a list must have; None allows any number.
    item: type of a list's values.
    fixed: True where the value counts only at the start of the node.
    """

    name: str
    default: object
    effect: str
    unit: str = ''
    low: float = None
    high: float = None
    choices: tuple = ()
    length: int = None
    item: type = float
    fixed: bool = False

    @property
    def is_list(self) -> bool:
        """Return whether the value is a list."""
        return isinstance(self.default, list)

    @property
    def kind(self) -> type:
        """Return the type of the value, or of each value of a list."""
        return self.item if self.is_list else type(self.default)

    @property
    def limits(self) -> str:
        """Return the range as people read it, `0.1 to 10`; empty where there is none."""
        if self.low is None:
            return ''
        low, high = (as_typed(end) if self.kind is float else f'{end}'
                     for end in (self.low, self.high))
        return f'{low} to {high}'

    @property
    def rule(self) -> str:
        """Return in words what a value must be."""
        words = TYPES[self.kind]
        if self.choices:
            words = f'one of {", ".join(map(str, self.choices))}'
        elif self.low is not None:
            words += f' from {self.limits}'
        if self.is_list:
            words = (f'a list of {self.length} values, each a {words}' if self.length else
                     words.replace(TYPES[self.item], f'a list of {TYPES[self.item]}s', 1))
        elif not self.choices:
            words = f'a {words}'
        return words + (f' [{self.unit}]' if self.unit else '')

    def accept(self, value: object, name: str = '') -> object:
        """
        Return a value, as ROS gives it, in the parameter's own type.

        name: of the parameter as its user knows it, where it is another. There is no -0: it is 0.
        Raises ValueError, with the rule and the value, for a value out of range and for one of
        another type, but that a whole number is taken for a number.
        """
        value = _as_python(value)
        if not self.is_list:
            accepted = self._accept_one(value)
        elif isinstance(value, (list, tuple)) and self.length in (None, len(value)):
            if len(value) > MAX_VALUES:
                raise ValueError(f'{name or self.name} must have at most {MAX_VALUES} values, '
                                 f'not {len(value)}')
            accepted = [self._accept_one(one) for one in value]
            accepted = None if None in accepted else accepted
        else:
            accepted = None
        if accepted is None:
            raise ValueError(f'{name or self.name} must be {self.rule}, not {value!r}')
        return accepted

    def convert(self, value: object, name: str = '') -> object:
        """
        Return a value, as Python code gives it, in the parameter's own type; a list as a tuple.

        Beside what `accept` does, 3.0 is a whole number: ROS parameters are of one type each,
        and it is of another there.
        """
        value = _as_python(value)
        if self.kind is int and isinstance(value, float) and value.is_integer():
            value = int(value)
        accepted = self.accept(value, name)
        return tuple(accepted) if self.is_list else accepted

    def _accept_one(self, one):
        """Return a single value in its type, or None where it is refused."""
        if self.kind is float:
            return self._accept_number(one)
        if type(one) is not self.kind or (self.choices and one not in self.choices):
            return None
        if self.kind is str and len(one) > MAX_CHARACTERS:
            raise ValueError(f'{self.name} must have at most {MAX_CHARACTERS} characters, '
                             f'not {len(one)}')
        return one if self.low is None or self.low <= one <= self.high else None

    def _accept_number(self, one):
        if not isinstance(one, numbers.Real) or isinstance(one, bool):
            return None
        try:
            number = float(one) + 0.0
        except OverflowError:  # a whole number of hundreds of digits
            return None
        if not math.isfinite(number):
            return None
        return number if self.low is None else checks.within(number, self.low, self.high)
