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
from fractions import Fraction


class FrameClock:
    """
    Counts the frames of a take.

    rate: frames per second [Hz]. index: of the frame that is sent next. Stamps follow from the
    count of frames in exact arithmetic, so they gather no error however long a take is.
    """

    def __init__(self, rate):
        self.index = 0
        self._origin = 0, 0  # a frame and its stamp [ns], from which the rate counts
        self._set_rate(rate)

    def _set_rate(self, rate):
        self._rate = rate
        self._period = Fraction(10**9) / Fraction(rate)  # [ns]
        self.wait()

    @property
    def rate(self):
        """Return the present rate [Hz]."""
        return self._rate

    def change_rate(self, rate):
        """Change the rate from the next frame on, which keeps its stamp."""
        self._origin = self.index, self.stamp
        self._set_rate(rate)

    @property
    def stamp(self):
        """Return the stamp of the next frame [ns]: the whole nanosecond nearest to its time."""
        first, stamp = self._origin
        return stamp + round((self.index - first) * self._period)

    def wait(self):
        """Let time stand still until `due` is asked for again."""
        self._due_origin = None  # (steady time [s], frame that was due at it)

    def due(self, now):
        """Return the index of the frame that is due at steady time `now` [s], or the next one."""
        if self._due_origin is None:
            self._due_origin = now, self.index
        begin, first = self._due_origin
        return max(first + round((now - begin) * self._rate), self.index)
