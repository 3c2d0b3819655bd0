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
from concurrent.futures import ThreadPoolExecutor
import os
import threading
import time

from flag_sim.parallel.spinning import wait_while
import numpy as np

# To choose, each number of threads does this many frames; its fastest counts, for nothing else
# on the machine can make a frame faster than it is.
ROUNDS = 6
# More threads are only taken if they save at least this share of the time.
WORTH = 0.1


class ThreadPool:
    """
    A thread pool that runs work(band, bands) for all bands at once, one thread a band.

    threads: how many; 0 chooses by a measurement: the first frames are done by 1, 2, 4, ...
    threads in turn, up to the processors of this process, and the best number stays. It is chosen
    anew once ROUNDS frames running were slower than by one thread alone: the machine is busy.
    """

    def __init__(self, threads):
        """Start the threads; raises RuntimeError if the system has none left."""
        self.threads = threads
        self._counts = ()
        if threads == 0:
            processors = len(os.sched_getaffinity(0))
            self._counts = sorted({min(2 ** k, processors)
                                   for k in range(processors.bit_length() + 1)})
        self._most = max(self._counts, default=threads)
        self._amount = 1
        self.measure()
        self._start()

    def measure(self):
        """Begin to choose, if the number is to be chosen: another kind of work follows."""
        self._times = {count: [] for count in self._counts}
        self._alone, self._slow = None, 0

    def frame(self, amount):
        """Return the pool, for a frame of so much work: times are compared per amount."""
        self._amount = amount
        return self

    def __enter__(self):
        """Begin a frame."""
        if self._times:
            self.threads = min(self._times, key=lambda count: len(self._times[count]))
        self._begin = time.perf_counter()
        return self

    def __exit__(self, *exception):
        """End a frame; choose when all numbers of threads have had their turns."""
        spent = (time.perf_counter() - self._begin) / self._amount
        with self._lock:
            self._is_called = False
            self._dealt[0] += 1
        if self._times:
            self._times[self.threads].append(spent)
            if min(map(len, self._times.values())) == ROUNDS:
                self.threads, self._alone = self._choose(), min(self._times[1])
                self._times = {}
        elif self._alone is not None and self.threads > 1:
            self._slow = self._slow + 1 if spent > self._alone else 0
            if self._slow == ROUNDS:
                self.measure()

    def run_bands(self, work, release=lambda: None):
        """
        Call work(band, bands) for each band; return when all are done.

        release: called if not all bands can be done, as after an interrupt, so that those which
        wait for one another end too.
        """
        if self.threads == 1:
            return work(0, 1)
        self._start_after_fork()
        others = []
        try:
            for band in range(1, self.threads):
                others.append(self._executor.submit(work, band, self.threads))
            work(0, self.threads)
        except BaseException:
            release()
            raise
        finally:
            for other in others:
                other.result()

    def wake(self):
        """
        Wake the threads ahead of the frame's deals: nobody has to wait for them then.

        They stay awake between deals, for a millisecond each time, until the frame ends.
        """
        if self.threads == 1:
            return
        self._start_after_fork()
        with self._lock:
            self._is_called = True
            self._wake_sleepers()

    def parallel_for(self, work):
        """
        Call work(number) in all threads, which take pieces of work until none is left.

        Returns when all are done; a thread that has not begun by then is not waited for.
        """
        if self.threads == 1:
            return work(0)
        self._start_after_fork()
        deal = _Deal(work)
        with self._lock:
            self._deal = deal
            self._dealt[0] += 1
            self._wake_sleepers()
        try:
            work(0)
        finally:
            with self._lock:
                self._deal = None
            while deal.busy[0]:
                wait_while(deal.busy, deal.busy[0])
        if deal.error is not None:
            raise deal.error

    def _wake_sleepers(self):
        """Let those who sleep attend; the lock is held."""
        for number in set(range(1, self.threads)) - self._awake:
            self._awake.add(number)
            self._executor.submit(self._worker_loop, number)

    def _worker_loop(self, number):
        """Work at what is dealt, as one thread, until nothing is for a while."""
        last = None
        while True:
            with self._lock:
                deal, dealt = self._deal, self._dealt[0]
                is_mine = deal not in (None, last) and number < self.threads
                if is_mine:
                    deal.busy[0] += 1
                elif not self._is_called:
                    self._awake.discard(number)
                    return
            if is_mine:
                last = deal
                try:
                    deal.work(number)
                except BaseException as error:
                    deal.error = error
                with self._lock:
                    deal.busy[0] -= 1
            elif not wait_while(self._dealt, dealt):
                with self._lock:
                    if self._dealt[0] == dealt:
                        self._awake.discard(number)
                        return

    def _start_after_fork(self):
        """Start threads anew in the child of a fork, which has this object but none of them."""
        if self._process != os.getpid():
            self._start()

    def _start(self):
        """Start all threads now, so that none can be missing when others wait for it."""
        self._process = os.getpid()
        self._executor = None
        # Under the lock: the deal that is on, if any; a count of changes; who is awake, and if
        # to stay so. Outside of frames all sleep: a system takes one who spins to be busy, and
        # then wakes it on the processor of who calls it, though another one is free.
        self._lock = threading.Lock()
        self._deal, self._dealt, self._awake = None, np.zeros(1, np.int64), set()
        self._is_called = False
        if self._most > 1:
            self._executor = ThreadPoolExecutor(self._most - 1, 'flag_sim')
            here = threading.Barrier(self._most)
            try:
                for _ in range(self._most - 1):
                    self._executor.submit(here.wait)
                here.wait()
            except RuntimeError:
                here.abort()
                raise

    def _choose(self):
        best, best_time = 1, min(self._times[1])
        for count, times in self._times.items():
            if min(times) < (1.0 - WORTH) * best_time:
                best, best_time = count, min(times)
        return best


class _Deal:
    """Work that is dealt: how many other threads are at it, and what went wrong there."""

    def __init__(self, work):
        self.work = work
        self.busy, self.error = np.zeros(1, np.int64), None
