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
The automatic choice of how many threads share a frame, by measuring the first frames.

No number is right everywhere. Two threads move 121 x 81 nodes 1.6 to 1.9 times faster than one on
two processors that are free. Where both were busy, two took 22 % longer than one for the steps of
61 x 41 nodes (quartiles 18 and 30 %, 300 turns), and 4 % longer for a picture of them, 640x480
(median of 400 turns, quartiles -10 and 20 %).
"""
import os

FRAMES_PER_CHOICE = 6
"""
Frames that each number of threads is measured by.

The fastest of them counts: nothing else on the machine can make a frame faster than it is.
"""
LEAST_GAIN = 0.1
"""More threads are only taken if they save at least this part of the time."""


class ThreadChoice:
    """
    How many threads share a frame: a given number, or the one that was measured as the best.

    threads: the number for the present frame. most: the highest that it may become.
    With 0 given, the first frames are done by 1, 2, 4, ... threads in turn, up to the processors
    of this process, and the best number stays. It is chosen anew once FRAMES_PER_CHOICE frames in
    a row were slower than by one thread alone: then the machine is busy with something else.
    """

    def __init__(self, threads: int):
        """Take a number of threads, or 0 to measure."""
        self.threads = threads
        self._candidates = ()
        if threads == 0:
            processors = len(os.sched_getaffinity(0))
            self._candidates = sorted({min(2 ** k, processors)
                                       for k in range(processors.bit_length() + 1)})
        self.most = max(self._candidates, default=threads)
        self.restart()

    def restart(self):
        """Measure again, if the number is to be chosen: another kind of work follows."""
        self._times = {count: [] for count in self._candidates}
        self._single_time, self._slow_frames = None, 0

    def begin_frame(self):
        """While measuring, take the number of threads that was measured least often."""
        if self._times:
            self.threads = min(self._times, key=lambda count: len(self._times[count]))

    def end_frame(self, seconds: float):
        """Note how long a frame took [s], per amount of work; choose once all are measured."""
        if self._times:
            self._times[self.threads].append(seconds)
            if min(map(len, self._times.values())) == FRAMES_PER_CHOICE:
                self.threads, self._single_time = self._best(), min(self._times[1])
                self._times = {}
        elif self._single_time is not None and self.threads > 1:
            self._slow_frames = self._slow_frames + 1 if seconds > self._single_time else 0
            if self._slow_frames == FRAMES_PER_CHOICE:
                self.restart()

    def _best(self):
        best, best_time = 1, min(self._times[1])
        for count, times in self._times.items():
            if min(times) < (1.0 - LEAST_GAIN) * best_time:
                best, best_time = count, min(times)
        return best
