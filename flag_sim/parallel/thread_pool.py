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

"""A thread pool that shares the work of a frame."""
from collections.abc import Callable
import time

from flag_sim.parallel.thread_choice import ThreadChoice
from flag_sim.parallel.workers import Workers


class ThreadPool:
    """
    Threads that share the work of a frame; the caller is one of them.

    threads: how many; 0 chooses by measuring the first frames (see ThreadChoice).

    >>> with pool:                       # a frame
    ...     pool.wake()
    ...     pool.parallel_for(work)
    """

    def __init__(self, threads: int):
        """Start the threads; raises RuntimeError if the system has none left."""
        self._threads = threads
        self._choice = ThreadChoice(threads)
        self._workers = Workers(max(self._choice.most - 1, 0))
        self._amount = 1

    def __reduce__(self):
        """Let a copy, also one of a file, be a pool with threads of its own."""
        return type(self), (self._threads,)

    @property
    def threads(self) -> int:
        """Return how many threads share the present frame."""
        return self._choice.threads

    def measure(self):
        """Choose again, if the number is to be chosen: another kind of work follows."""
        self._choice.restart()

    def frame(self, amount: int) -> 'ThreadPool':
        """Return the pool, for a frame of so much work: times are compared per amount."""
        self._amount = amount
        return self

    def __enter__(self) -> 'ThreadPool':
        """Begin a frame."""
        self._choice.begin_frame()
        self._begin = time.perf_counter()
        return self

    def __exit__(self, *exception):
        """End a frame."""
        seconds = (time.perf_counter() - self._begin) / self._amount
        self._workers.sleep()
        self._choice.end_frame(seconds)

    def run_bands(self, work: Callable[[int, int], None],
                  release: Callable[[], None] = lambda: None):
        """
        Call work(band, bands) for each band, one thread a band; return when all are done.

        All bands run at the same time, so they may wait for one another at a barrier. release: is
        called if not all bands can be done, as after an interrupt, so that those which wait end
        too. Raises what one of them raised.
        """
        if self.threads == 1:
            return work(0, 1)
        others = []
        try:
            for band in range(1, self.threads):
                others.append(self._workers.submit(work, band, self.threads))
            work(0, self.threads)
        except BaseException:
            release()
            raise
        finally:
            for other in others:
                other.result()

    def wake(self):
        """Wake the threads ahead of a frame's work: none has to be waited for then."""
        if self.threads > 1:
            self._workers.wake(self.threads)

    def parallel_for(self, work: Callable[[int], None]):
        """
        Call work(thread) in all threads, each of which takes pieces of work until none is left.

        Returns when all are done; a thread that has not begun by then is not waited for, so work
        must not wait for other threads. Raises what one of them raised.
        """
        if self.threads == 1:
            return work(0)
        self._workers.run(work, self.threads)
