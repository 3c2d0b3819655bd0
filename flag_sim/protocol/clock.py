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

"""The clock of a take: which frame is next, its stamp, and when it is due."""
from collections.abc import Callable
from fractions import Fraction
import math

LATEST = 0.75
"""
Parts of a period that a frame may leave late in real time.

One that would leave later still is left out: it would meet the next one, which is on time again.
"""


class FrameClock:
    """
    Counts the frames of a take.

    rate: frames per second [Hz]. index: of the frame that is sent next. Times follow from the
    count of frames in exact arithmetic, so they gather no error however long a take is.
    start: the stamp of the first frame [ns]. wall(): the time of the wall clock [ns], which stamps
    follow instead from where the take begins to keep to real time: from its first frame, and
    after a pause.
    """

    def __init__(self, rate: float, start: int = 0, wall: Callable[[], int] | None = None):
        self.index = 0
        self.offset = start  # of stamps before the take's time [ns]
        self._wall = wall
        self._origin = 0, 0  # a frame and its time [ns], from which the rate counts
        self._set_rate(rate)

    def _set_rate(self, rate):
        self._rate = rate
        self._period = Fraction(10**9) / Fraction(rate)  # [ns]
        self.wait()

    @property
    def rate(self) -> float:
        """Return the present rate [Hz]."""
        return self._rate

    def change_rate(self, rate: float) -> None:
        """Change the rate from the next frame on, which keeps its time."""
        self._origin = self.index, self.time
        self._set_rate(rate)

    @property
    def time(self) -> int:
        """Return when in the take the next frame is: to the nearest whole nanosecond [ns]."""
        first, time = self._origin
        # As round() of a Fraction, which takes three times as long, and this is asked for often.
        whole, rest = divmod((self.index - first) * self._period.numerator,
                             self._period.denominator)
        beyond = 2 * rest - self._period.denominator
        return time + whole + (beyond > 0 or (beyond == 0 and whole % 2 == 1))

    @property
    def stamp(self) -> int:
        """Return the stamp of the next frame [ns]."""
        return self.offset + self.time

    def meet_wall(self) -> None:
        """Give the next frame the wall clock's time, if stamps are by it; they never go back."""
        if self._wall is not None:
            self.offset = max(self.offset, self._wall() - self.time)

    def wait(self) -> None:
        """Stop the clock until `due` is called again."""
        self._due_origin = None  # (steady time [s], frame that was due at it)

    def due(self, now: float) -> int:
        """
        Return the index of the frame that is sent at steady time `now` [s].

        That is the next one; those that are more than LATEST of a period late are passed over.
        """
        if self._due_origin is None:
            self._due_origin = now, self.index
            self.meet_wall()
        begin, first = self._due_origin
        return max(first + math.ceil((now - begin) * self._rate - LATEST), self.index)
