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

"""Parameters: the name, type, unit, range and effect of every parameter that a node has."""
import dataclasses
import math

from flag_sim.parameters import checks

KINDS = {bool: 'boolean', int: 'whole number', float: 'number', str: 'text'}


@dataclasses.dataclass(frozen=True)
class Declaration:
    """
    One parameter of a node.

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
    def is_list(self):
        """Return whether the value is a list."""
        return isinstance(self.default, list)

    @property
    def rule(self):
        """Return in words what a value must be."""
        kind = self.item if self.is_list else type(self.default)
        words = KINDS[kind]
        if self.choices:
            words = f'one of {", ".join(map(str, self.choices))}'
        elif self.low is not None:
            low, high = (f'{end:g}' if kind is float else f'{end}'
                         for end in (self.low, self.high))
            words += f' from {low} to {high}'
        if self.is_list:
            words = (f'a list of {self.length} values, each a {words}' if self.length else
                     words.replace(KINDS[kind], f'a list of {KINDS[kind]}s', 1))
        else:
            words = words if self.choices else f'a {words}'
        return words + (f' [{self.unit}]' if self.unit else '')

    def accept(self, value):
        """
        Return `value` in the parameter's own type; raise ValueError with the rule and the value.

        There is no -0: it is 0.
        """
        if not self.is_list:
            return self._accept_one(value, type(self.default))
        try:
            values = [] if isinstance(value, str) else list(value)
        except TypeError:
            raise self._refusal(value) from None
        if isinstance(value, str) or self.length not in (None, len(values)):
            raise self._refusal(value)
        return [self._accept_one(one, self.item, value) for one in values]

    def _accept_one(self, one, kind, whole=None):
        whole = one if whole is None else whole
        is_number = isinstance(one, (int, float)) and not isinstance(one, bool)
        if kind is float and is_number:
            try:
                one = float(one) + 0.0
            except OverflowError:  # a whole number of hundreds of digits
                raise self._refusal(whole) from None
        elif type(one) is not kind:
            raise self._refusal(whole)
        if kind is float and not math.isfinite(one):
            raise self._refusal(whole)
        if self.low is not None:
            if kind is float:
                one = checks.within(one, self.low, self.high)
            if one is None or not self.low <= one <= self.high:
                raise self._refusal(whole)
        if self.choices and one not in self.choices:
            raise self._refusal(whole)
        return one

    def _refusal(self, value):
        value = value.tolist() if hasattr(value, 'tolist') else value
        return ValueError(f'{self.name} must be {self.rule}, not {value!r}')
