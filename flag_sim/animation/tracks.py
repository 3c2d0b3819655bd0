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

"""Tracks: one keyed value through time (the source text's keys and key frames, 1.5)."""
import bisect
import math

from flag_sim.animation.laws import HOLDS, LAWS


class Track:
    """
    The keys of one value.

    times: (n,) [s], finite and strictly increasing, n >= 1.
    values: (n,) numbers, booleans or strings.
    laws: (n,) names out of `laws.LAWS`, each for the segment that its key begins; the last one
    only matters to a key that is appended later. Omitted laws are `linear`, or `step` where the
    values are booleans or strings.
    Raises ValueError that names the rule and the offending value.
    """

    def __init__(self, times, values, laws=None):
        self.times = [float(time) for time in times]
        self.values = list(values)
        holds = any(isinstance(value, HOLDS) for value in self.values)
        self.laws = list(laws) if laws else ['step' if holds else 'linear'] * len(self.times)
        self._check(holds)

    def _check(self, holds):
        if not self.times:
            raise ValueError('a track needs at least one key; times is empty')
        lengths = {'times': len(self.times), 'values': len(self.values), 'laws': len(self.laws)}
        if len(set(lengths.values())) > 1:
            raise ValueError('times, values and laws must be of one length, not '
                             + ', '.join(f'{n} {name}' for name, n in lengths.items()))
        for time in self.times:
            if not math.isfinite(time):
                raise ValueError(f'times must be finite, not {time}')
        for earlier, later in zip(self.times, self.times[1:]):
            if later <= earlier:
                raise ValueError(f'times must increase strictly; {later} follows {earlier}')
        for law in self.laws:
            if law not in LAWS:
                raise ValueError(f"law '{law}' is not one of {', '.join(LAWS)}")
            if holds and law != 'step':
                raise ValueError(f"law '{law}' cannot lead between texts or booleans; use step")
        if len({isinstance(value, HOLDS) and type(value) for value in self.values}) > 1:
            raise ValueError(f'values must be of one type: {self.values}')
        for value in self.values:
            if not isinstance(value, HOLDS) and not math.isfinite(value):
                raise ValueError(f'values must be finite, not {value}')

    def at(self, time):
        """Return the value at `time` [s]; before the first and after the last key it holds."""
        k = bisect.bisect_right(self.times, time) - 1
        if k < 0:
            return self.values[0]
        if k == len(self.times) - 1:
            return self.values[k]
        fraction = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        return LAWS[self.laws[k]](fraction, self.values[k], self.values[k + 1])

    def crossed(self, after, until):
        """Return the times of the keys in the interval (after, until] [s]."""
        first = bisect.bisect_right(self.times, after)
        return self.times[first:bisect.bisect_right(self.times, until)]
