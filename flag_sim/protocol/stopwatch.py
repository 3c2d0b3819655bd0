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

"""A stopwatch of a node: how much time it waits for frames, works on them, publishes them."""
from collections.abc import Iterator
import contextlib
import time


class Stopwatch:
    """
    Adds up the seconds spent on work and on publishing between the first and the last frame.

    frames: how many were served; the caller counts them. What was before the first one was, such
    as kernels that compile, is in no figure.
    """

    def __init__(self):
        self._last = 0.0
        self._spent = {'work': 0.0, 'publish': 0.0}
        self._frames = 0
        self._begin = 0.0, {}  # _last and _spent when the first frame was served
        self._lap = 0, 0.0  # frames and seconds of work at the last lap

    @property
    def frames(self) -> int:
        """Return how many frames were served."""
        return self._frames

    @frames.setter
    def frames(self, frames: int) -> None:
        if not self._frames:
            self._begin = self._last, dict(self._spent)
        self._frames = frames

    @contextlib.contextmanager
    def measure(self, activity: str) -> Iterator[None]:
        """Add the time of the `with` block to an activity: work or publish."""
        begin = time.perf_counter()
        yield
        self._last = time.perf_counter()
        self._spent[activity] += self._last - begin

    def lap(self) -> float | None:
        """Return the mean work on a frame [s] since the last lap, or None without a frame."""
        frames, work = self.frames - self._lap[0], self._spent['work'] - self._lap[1]
        self._lap = self.frames, self._spent['work']
        return work / frames if frames else None

    def figures(self) -> dict[str, float]:
        """
        Return {name: number}: frames, seconds, and what part of these went where [%].

        The seconds are those from the first frame to the last: one time less than frames. What is
        neither work nor publishing is waiting. Of less than two frames there is only their number.
        """
        begin, spent = self._begin
        total = self._last - begin if self.frames > 1 else 0.0
        if not total:
            return {'frames': self.frames}
        work, publish = (100.0 * (self._spent[name] - spent[name]) / total
                         for name in ('work', 'publish'))
        return {'frames': self.frames, 'seconds': total, 'wait': 100.0 - work - publish,
                'work': work, 'publish': publish}

    def summary(self) -> str:
        """Return the figures in words."""
        frames, *others = self.figures().values()
        return f'served {frames} frames' + (
            ' in {:.2f} s: wait {:.1f} %, work {:.1f} %, publish {:.1f} %'.format(*others)
            if others else '')
