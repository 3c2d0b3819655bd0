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

"""Which frames were shown: how many a second, and how many were left out."""
import collections

from flag_sim.viewer.exchange import FramePlace

WINDOW = 2.0
"""Over which time frames are counted [s]."""


class FrameCounter:
    """Counts the pictures that are shown; times are of a steady clock [s]."""

    def __init__(self):
        self._times = collections.deque()
        self.shown = 0
        self.skipped = 0   # frames of this take, since it is watched, that had no picture here
        self.stamp = None  # of the last picture [ns]
        self.place = None  # of the last picture, where the wind has announced its frame
        self.last = None   # when the last picture was shown

    def show(self, stamp: int, place: FramePlace | None, now: float) -> None:
        """Note a picture with a stamp [ns], and its frame's place if it is known."""
        self.shown += 1
        if place is not None and place.index is not None:
            if self.place is None or self.place.take != place.take:
                self.skipped = 0
            else:
                self.skipped += max(place.index - self.place.index - 1, 0)
            self.place = place
        self.stamp, self.last = stamp, now
        self._times.append(now)

    def rate(self, now: float) -> float:
        """Return how many pictures a second were shown lately."""
        while self._times and self._times[0] < now - WINDOW:
            self._times.popleft()
        if len(self._times) < 2:
            return 0.0
        # Those of a slow shot are as far apart as they are, and not in a whole window.
        return (len(self._times) - 1) / max(now - self._times[0], 1e-3)

    def still(self, now: float) -> float:
        """Return how long no picture has come [s]; 0 before the first."""
        return 0.0 if self.last is None else now - self.last
