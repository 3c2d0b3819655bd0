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
Tracks: one keyed value through time (the source text's keys and key frames, 1.5).

What Blender calls an F-curve and glTF an animation sampler: keys, a law of interpolation for each
segment between two of them, and constant extrapolation outside.
"""
import bisect
import itertools
import math

from flag_sim.animation.laws import HOLDS, LAWS, monotone_slopes
from flag_sim.attributes import constant
import numpy as np

SAME = 2e-9
"""
A key that is no more than this [s] after a moment is at that moment.

Stamps are whole nanoseconds: a frame at n / 30 s may be stamped half a nanosecond before a key
that is at n / 30 s. After a month, float64 adds as much to times and to the rounds of a loop.
"""


@constant
class Track:
    """
    The keys of one value.

    times: (n,) [s], finite and strictly increasing, n >= 1.
    values: (n,) numbers, booleans or strings, or (n, k) numbers: a vector a key.
    laws: (n,) names out of `laws.LAWS`, each for the segment that its key begins; the last one
    only matters to a key that is appended later. Omitted laws are `linear`, or `step` where the
    values are booleans or strings. Neighbouring cubic segments share one smooth curve.
    is_angle: values are directions [rad]; from key to key they take the short way round.
    Raises ValueError that names the rule and the offending value.
    """

    def __init__(self, times, values, laws=None, is_angle=False):
        self.times = [float(time) for time in times]
        self.values = list(values)
        holds = any(isinstance(value, HOLDS) for value in self.values)
        self.laws = list(laws) if laws else ['step' if holds else 'linear'] * len(self.times)
        self._check(holds)
        self._path = self.values
        if not holds:
            self._path = np.asarray(self.values, float)
            if is_angle:
                self._path = np.unwrap(self._path, axis=0)
            self._path = self._path.tolist()  # plain numbers are faster one by one
        self._slopes = {} if holds else self._cubic_slopes()

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
            if not isinstance(value, HOLDS) and not np.all(np.isfinite(value)):
                raise ValueError(f'values must be finite, not {value}')

    def _cubic_slopes(self):
        """
        Return {key: (slope there, slope at the next)}, in values per segment, where cubic.

        Of vectors there is such a pair for each of their numbers.
        """
        slopes = {}
        begin = 0
        while begin < len(self.times) - 1:
            end = begin
            while end < len(self.times) - 1 and self.laws[end] == 'cubic':
                end += 1
            if end > begin:
                run = monotone_slopes(self.times[begin:end + 1], self._path[begin:end + 1])
                for k in range(begin, end):
                    width = self.times[k + 1] - self.times[k]
                    slopes[k] = (width * run[k - begin:k - begin + 2]).T.tolist()
            begin = max(end, begin + 1)
        return slopes

    def at(self, time):
        """
        Return the value at `time` [s]; before the first and after the last key theirs.

        At a key it is exactly the key's value; a vector comes as a list (k,).
        """
        if not math.isfinite(time):
            raise ValueError(f'time must be finite, not {time}')
        k = bisect.bisect_right(self.times, time + SAME) - 1
        if k < 0 or k == len(self.times) - 1 or time <= self.times[k]:
            return self.values[max(k, 0)]
        if self.laws[k] == 'step':
            return self.values[k]
        fraction = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        law = LAWS[self.laws[k]]
        before, after = self._path[k], self._path[k + 1]
        if isinstance(before, float):
            return _between(law, fraction, before, after, self._slopes.get(k, ()))
        slopes = self._slopes.get(k) or itertools.repeat(())
        return [_between(law, fraction, *ends) for ends in zip(before, after, slopes)]


def _between(law, fraction, before, after, slopes):
    """Return a law's number, kept between its keys lest rounding takes it out of its range."""
    value = law(fraction, before, after, *slopes)
    low, high = (before, after) if before <= after else (after, before)
    return low if value < low else high if value > high else value
