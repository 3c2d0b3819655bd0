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

"""Where times and values stand on the timeline. No Qt."""
from collections.abc import Iterable
import dataclasses
import math

from flag_sim.animation.tracks import Track

SAMPLES = 24
"""Points of the curve of a segment that is not straight."""
LEAST_SPAN = 1e-3
"""The shortest time that the timeline shows [s]."""


@dataclasses.dataclass(frozen=True)
class TimeScale:
    """Times from begin to end [s] at places from left to right."""

    begin: float
    end: float
    left: float
    right: float

    def x(self, time: float) -> float:
        """Return the place of a time."""
        return self.left + (time - self.begin) / (self.end - self.begin) * (
            self.right - self.left)

    def time(self, x: float) -> float:
        """Return the time [s] at a place."""
        return self.begin + (x - self.left) / max(self.right - self.left, 1.0) * (
            self.end - self.begin)

    def zoomed(self, x: float, factor: float) -> 'TimeScale':
        """Return a scale that shows a part of the time, with the same time at place x."""
        at = self.time(x)
        span = min(max((self.end - self.begin) * factor, LEAST_SPAN), 1e9)
        begin = at - (at - self.begin) * span / (self.end - self.begin)
        return dataclasses.replace(self, begin=begin, end=begin + span)

    def shifted(self, part: float) -> 'TimeScale':
        """Return a scale that shows times that are later by a part of what is shown."""
        by = part * (self.end - self.begin)
        return dataclasses.replace(self, begin=self.begin + by, end=self.end + by)

    def ticks(self, apart: float) -> list[float]:
        """Return round times [s] that stand at least so far apart."""
        least = (self.end - self.begin) * apart / max(self.right - self.left, 1.0)
        power = 10.0 ** math.floor(math.log10(least))
        step = next(power * n for n in (1, 2, 5, 10) if power * n >= least * (1.0 - 1e-9))
        first, last = math.ceil(self.begin / step), math.floor(self.end / step)
        return [float(f'{n * step:.9g}') for n in range(first, last + 1)]


@dataclasses.dataclass(frozen=True)
class ValueScale:
    """Values from low to high at places from bottom up to top."""

    low: float
    high: float
    bottom: float
    top: float

    def y(self, value: float) -> float:
        """Return the place of a value."""
        return self.bottom + (value - self.low) / (self.high - self.low) * (
            self.top - self.bottom)

    def value(self, y: float) -> float:
        """Return the value at a place, of as few digits as tell it from those beside."""
        value = self.low + (y - self.bottom) / (self.top - self.bottom) * (self.high - self.low)
        digits = 2 - math.floor(math.log10(self.high - self.low))
        return round(value, max(digits, 0))


def span_of(values: Iterable[float]) -> tuple[float, float]:
    """Return a range (low, high) in which all values stand, with some room beside them."""
    values = [*values]
    low, high = min(values), max(values)
    room = 0.15 * (high - low) or max(0.5 * abs(high), 0.5)
    return low - room, high + room


def curve(track: Track, component: int | None, begin: float, end: float) -> list[tuple]:
    """
    Return points (time [s], value) of a track's curve from begin to end, by its segments' laws.

    component: which of the numbers of a vector, or None.
    """
    def at(time):
        value = track.at(time)
        return float(value if component is None else value[component])
    times = track.times
    points = [(min(begin, times[0]), at(times[0])), (times[0], at(times[0]))]
    for k, (first, last) in enumerate(zip(times, times[1:])):
        if track.laws[k] == 'step':
            points.append((last, at(first)))
        elif track.laws[k] != 'linear':
            points += [(time, at(time)) for time in (
                first + (last - first) * n / SAMPLES for n in range(1, SAMPLES))]
        points.append((last, at(last)))
    return [*points, (max(end, times[-1]), at(times[-1]))]
