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

"""Threads that share the rows of a frame."""
from concurrent.futures import ThreadPoolExecutor
import os
import time

# To choose, each number of threads draws this many frames; its fastest counts, for nothing else
# on the machine can make a frame faster than it is.
ROUNDS = 6
# More threads are only taken if they save at least this share of the time.
WORTH = 0.1


class Crew:
    """
    Runs work(band, bands) for all bands at once, one thread a band.

    threads: how many; 0 chooses by a measurement: the first frames are drawn by 1, 2, 4, ...
    threads in turn, up to the processors of this process, and the best number stays.
    """

    def __init__(self, threads):
        """Start no thread yet."""
        self.threads = threads
        self._times = {}
        if threads == 0:
            processors = len(os.sched_getaffinity(0))
            counts = {min(2 ** k, processors) for k in range(processors.bit_length() + 1)}
            self._times = {count: [] for count in sorted(counts)}
        most = max(self._times, default=threads)
        self._pool = ThreadPoolExecutor(most - 1, 'drawing') if most > 1 else None

    def __enter__(self):
        """Begin a frame."""
        if self._times:
            self.threads = min(self._times, key=lambda count: len(self._times[count]))
        self._begin = time.perf_counter()
        return self

    def __exit__(self, *exception):
        """End a frame; choose when all numbers of threads have had their turns."""
        if self._times:
            self._times[self.threads].append(time.perf_counter() - self._begin)
            if min(map(len, self._times.values())) == ROUNDS:
                self.threads = self._choose()
                self._times = {}

    def share(self, work):
        """Call work(band, bands) for each band; return when all are done."""
        others = [self._pool.submit(work, band, self.threads) for band in range(1, self.threads)]
        work(0, self.threads)
        for other in others:
            other.result()

    def deal(self, work):
        """
        Call work(number) in all threads, which take pieces of work until none is left.

        Returns when all are done; a thread that has not begun by then is not waited for.
        """
        others = [self._pool.submit(work, number) for number in range(1, self.threads)]
        work(0)
        for other in others:
            if not other.cancel():
                other.result()

    def _choose(self):
        best, best_time = 1, min(self._times[1])
        for count, times in self._times.items():
            if min(times) < (1.0 - WORTH) * best_time:
                best, best_time = count, min(times)
        return best
