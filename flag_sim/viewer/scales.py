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

"""Where a value stands on a slider: linear, or logarithmic where its range spans decades."""
import math

STEPS = 1000
"""Places of a slider."""
DECADES = 3.0
"""A range of at least so many powers of ten is shown as logarithms."""
DECADES_FROM_ZERO = 9.0
"""How many powers of ten below its upper end a range shows that begins with 0."""


class Scale:
    """
    The places 0 to STEPS of a slider for values from low to high.

    Logarithmic where the range is positive and spans DECADES; a range from 0 to a thousand or more
    shows 0 at its first place, and powers of ten from there on.
    """

    def __init__(self, low: float, high: float, is_whole: bool = False):
        self.low, self.high, self.is_whole = low, high, is_whole
        self._from = low
        if low == 0 and high >= 10.0 ** DECADES:
            self._from = 1.0 if is_whole else high * 10.0 ** -DECADES_FROM_ZERO
        self.is_logarithmic = self._from > 0 and high / self._from >= 10.0 ** DECADES

    def place(self, value: float) -> int:
        """Return the place of a value, of one out of range the nearest."""
        value = min(max(value, self.low), self.high)
        if not self.is_logarithmic:
            return round(STEPS * (value - self.low) / (self.high - self.low or 1.0))
        if value < self._from:
            return 0
        return max(round(STEPS * math.log(value / self._from)
                         / math.log(self.high / self._from)), 1 if self.low == 0 else 0)

    def value(self, place: int) -> float | int:
        """Return the value at a place, of as few digits as tell it from those beside."""
        if place <= 0:
            value = self.low
        elif place >= STEPS:
            value = self.high
        elif self.is_logarithmic:
            value = float(f'{self._from * (self.high / self._from) ** (place / STEPS):.3g}')
        else:
            value = self.low + (self.high - self.low) * place / STEPS
            value = round(value, max(0, 3 - math.floor(math.log10(self.high - self.low or 1.0))))
        return round(value) if self.is_whole else min(max(float(value), self.low), self.high)
