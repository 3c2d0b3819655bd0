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
Tracks: one keyed value through time (the source text's key frames, sec. 1.5).

What Blender calls an F-curve and glTF an animation sampler: keys, a law of interpolation for each
segment between two of them, and constant extrapolation outside.
"""
import bisect
from collections.abc import Iterable, Sequence
import copy
import itertools
import math
import numbers

from flag_sim.animation.laws import LAWS, monotone_slopes, STEPPED
from flag_sim.parameters import checks
from flag_sim.parameters.closed import constant
import numpy as np

TURN = 2.0 * math.pi
TYPING_TOLERANCE = 1e-3  # by how much an angle that is typed with three decimals may miss [rad]
HALF_TURN = 0.5 * TURN + TYPING_TOLERANCE
LATEST_KEY = 1e9  # greatest distance of a key from time 0 [s]: thirty years

TIME_TOLERANCE = 2e-9
"""
A key that is no more than this [s] after a moment is at that moment.

Stamps are whole nanoseconds: a frame at n / 30 s may be stamped half a nanosecond before a key
that is at n / 30 s. After a month, float64 adds as much to times and to the rounds of a loop.
"""

LEAST_KEY_SPACING = 1e-9  # between two keys [s]: the resolution of stamps


@constant
class Track:
    """
    The keys of one value.

    times: (n,) [s], strictly increasing by a nanosecond at least, of at most LATEST_KEY; n >= 1.
    values: (n,) numbers, booleans or strings, or (n, k) numbers: a vector a key.
    laws: (n,) names out of `laws.LAWS`, each for the segment that its key begins; the last one
    only matters to a key that is appended later. Omitted laws are `linear`, or `step` where the
    values are booleans or strings. Neighbouring cubic segments share one smooth curve.
    is_angle: values are directions [rad], of which a turn more is the same; from key to key they
    take the short way round unless `turns`: then they are taken as they are.
    Raises ValueError that names the rule and the offending value.
    """

    def __init__(self, times: Iterable[float], values: Iterable,
                 laws: Iterable[str] | None = None, is_angle: bool = False,
                 turns: bool = False):
        self.times = _times(checks.listed('times', times))
        self.values = [_plain(value) for value in checks.listed('values', values)]
        self.is_angle = checks.boolean('is_angle', is_angle)
        self.turns = checks.boolean('turns', turns)
        is_stepped = any(issubclass(kind, STEPPED) for kind in set(map(type, self.values)))
        laws = [] if laws is None else checks.listed('laws', laws)
        self._check_lengths(times=self.times, values=self.values,
                            **({'laws': laws} if laws else {}))
        self.laws = laws or ['step' if is_stepped else 'linear'] * len(self.times)
        self._check(is_stepped)
        self._path = self.values
        if not is_stepped:
            self._path = _numbers(self.values)
            checks.require(self._path.ndim == 1 or not is_angle, 'values',
                           'single numbers where is_angle', self.values)
            if is_angle and not turns:
                self._path = short_way(self._path)
            self._path = self._path.tolist()  # plain numbers are faster one by one
        self._slopes = {} if is_stepped else self._cubic_slopes()

    @staticmethod
    def _check_lengths(**given):
        if not given['times']:
            raise ValueError('a track needs at least one key; times is empty')
        if len({*map(len, given.values())}) > 1:
            raise ValueError('times, values and laws, if given, must be of one length, not '
                             + ', '.join(f'{name} of {len(one)}' for name, one in given.items()))

    def _check(self, is_stepped):
        widths = np.diff(self.times)
        for k in np.flatnonzero(~(widths >= LEAST_KEY_SPACING))[:1]:
            earlier, later = self.times[k:k + 2]
            if later <= earlier:
                raise ValueError(f'times must increase strictly; {later} follows {earlier}')
            raise ValueError(f'times must be at least {LEAST_KEY_SPACING:g} s apart; {later} '
                             f'follows {earlier}')
        for law in self.laws:
            if not isinstance(law, str) or law not in LAWS:
                raise ValueError(f"law {checks.shown(law)} is not one of {', '.join(LAWS)}")
            if is_stepped and law != 'step':
                raise ValueError(f"law '{law}' cannot lead between texts or booleans; use step")
        if len({issubclass(kind, STEPPED) and kind for kind in set(map(type, self.values))}) > 1:
            raise ValueError(f'values must be of one type: {checks.shown(self.values)}')
        checks.require(not (is_stepped and self.is_angle), 'values', 'numbers where is_angle',
                       self.values)

    def _cubic_slopes(self):
        """
        Return {key: (slope there, slope at the next)}, in values per segment, where cubic.

        Of vectors there is such a pair for each of their numbers.
        """
        slopes = {}
        if 'cubic' not in self.laws:
            return slopes
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

    def repeated(self, begin: float, end: float) -> 'Track':
        """
        Return the track as it plays in a loop from `begin` to `end` [s], which are one moment.

        Where the value at the end is that at the begin, cubic segments are smooth over the seam.
        """
        at_begin = self.times[0] - begin <= TIME_TOLERANCE
        at_end = end - self.times[-1] <= TIME_TOLERANCE
        into, out = self.laws[-2:-1] == ['cubic'], self.laws[0] == 'cubic'
        is_seam = (at_begin or at_end) and (out or not at_begin) and (into or not at_end)
        if not (is_seam and self._slopes and self._ends_meet()):
            return self
        slope = np.zeros_like(self._path[0])  # as beside a value that does not change
        if at_begin and at_end:
            jump = np.subtract(self._path[-1], self._path[0])  # whole turns of an angle, or 0
            slope = monotone_slopes(
                [self.times[-2] - (end - begin), *self.times[:2]],
                [np.subtract(self._path[-2], jump), *self._path[:2]])[1]
        track = copy.copy(self)
        track._slopes = dict(self._slopes)
        if at_begin:
            track._set_slope(0, 0, slope)
        if at_end:
            track._set_slope(len(self.times) - 2, 1, slope)
        return track

    def _ends_meet(self):
        apart = np.subtract(self._path[-1], self._path[0])
        if self.is_angle:
            return np.all(np.abs(apart - TURN * np.round(apart / TURN)) <= TYPING_TOLERANCE)
        return not np.any(apart)

    def _set_slope(self, k, end, slope):
        """Set the slope [value/s] at the begin (end 0) or the end (1) of a cubic segment k."""
        pairs = np.array(self._slopes[k])
        pairs[..., end] = (self.times[k + 1] - self.times[k]) * slope
        self._slopes[k] = pairs.tolist()

    def long_ways(self) -> list[int]:
        """
        Return the keys k from which an angle goes half a turn or more to the next, as it is typed.

        The short way round is then the other one, or as long.
        """
        if not self.is_angle or self.turns:
            return []
        far = np.abs(np.diff(self.values)) >= HALF_TURN - 2.0 * TYPING_TOLERANCE
        return [int(k) for k in np.flatnonzero(far) if self.laws[k] != 'step']

    def step_from(self, k: int) -> float:
        """Return by how much a number changes from key k to the next, along the way it takes."""
        return self._path[k + 1] - self._path[k]

    def at(self, time: float) -> object:
        """
        Return the value at `time` [s]; before the first and after the last key theirs.

        At a key it is exactly the key's value; a vector comes as a list (k,).
        """
        time = checks.moment('time', time)
        k = bisect.bisect_right(self.times, time + TIME_TOLERANCE) - 1
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


def short_way(angles: Sequence[float]) -> np.ndarray:
    """
    Return angles (n,) [rad] with whole turns added, so that each is the nearest to the one before.

    Half a turn goes the way that it is typed, also with three decimals.
    """
    steps = np.diff(angles, axis=0)
    turns = np.maximum(np.ceil((np.abs(steps) - HALF_TURN) / TURN), 0.0)
    return angles - TURN * np.concatenate([[0.0], np.cumsum(np.sign(steps) * turns)])


def _times(times):
    """Return times as floats; raise ValueError where one is none or beyond LATEST_KEY."""
    if set(map(type, times)) == {float}:  # a million are checked at once
        numbers = np.array(times) + 0.0
        if (np.abs(numbers) <= LATEST_KEY).all():
            return numbers.tolist()
    return [_time(time) for time in times]


def _time(time):
    if isinstance(time, (bool, str, bytes, complex, np.complexfloating)):
        raise ValueError(f'times must be numbers, not {checks.shown(time)}')
    try:
        number = float(time) + 0.0  # which makes 0 of -0
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f'times must be numbers, not {checks.shown(time)}') from None
    if not math.isfinite(number):
        raise ValueError(f'times must be finite, not {number}')
    if abs(number) > LATEST_KEY:
        raise ValueError(f'times must be from {-LATEST_KEY:g} to {LATEST_KEY:g} s, not {number}')
    return number


def _plain(value):
    """Return a value, or an array, of numpy as Python's own; any other as it is."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value


def _numbers(values):
    """Return values as an array (n,) or (n, k); raise ValueError where they are no numbers."""
    try:
        for value in values:
            for one in value if isinstance(value, (list, tuple)) else [value]:
                if not isinstance(one, numbers.Real) or isinstance(one, bool):
                    raise TypeError
        array = np.array(values, float)
        if not array.size:
            raise ValueError
    except (TypeError, ValueError, OverflowError):
        raise ValueError('values must be numbers, or vectors of one length, not '
                         f'{checks.shown(values)}') from None
    bad = array[~(np.abs(array) <= checks.LARGEST)]
    if bad.size and np.isfinite(bad[0]):
        raise ValueError(f'values must be at most {checks.LARGEST:g} in size, not {bad[0]}')
    if bad.size:
        raise ValueError(f'values must be finite, not {bad[0]}')
    return array


def _between(law, fraction, before, after, slopes):
    """Return a law's number, kept between its keys lest rounding takes it out of its range."""
    value = law(fraction, before, after, *slopes)
    low, high = (before, after) if before <= after else (after, before)
    return low if value < low else high if value > high else value
