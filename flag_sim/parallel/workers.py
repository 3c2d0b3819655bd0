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
Worker threads that are woken once a frame, ahead of its work, and stay awake until it ends.

To wake a sleeping thread takes tens of microseconds, as long as some of a frame's kernels run. A
picture whose workers are only woken by its first shared kernel takes 8 % longer (640x480, a flag
of 61 x 41 nodes, two threads; median of 400 turns with and without, quartiles -6 and 24 %, on a
machine whose two processors were busy).
"""
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
import os
import threading

from flag_sim.parallel.placement import apart, processor
from flag_sim.parallel.spinning import spin_until_changed
import numpy as np


class Workers:
    """
    The threads of a pool beside the caller's own; each has a number from 1 on.

    Between frames all sleep: a system takes a thread that spins to be busy, and then wakes it on
    the processor of its caller, though another one is free.
    """

    def __init__(self, count: int):
        """Start the threads; raises RuntimeError if the system has none left."""
        self._count = count
        self._start()

    def submit(self, work: Callable, *arguments) -> Future:
        """Let a thread that is free call work(*arguments), on a free processor if there is one."""
        self._start_after_fork()
        return self._executor.submit(apart, work, *arguments, caller=processor())

    def wake(self, threads: int):
        """Wake the workers below number `threads`, which stay awake until sleep is called."""
        self._start_after_fork()
        with self._lock:
            self._is_frame = True
            self._wake_sleepers(threads)

    def sleep(self):
        """Let the workers sleep, for the frame is over."""
        with self._lock:
            self._is_frame = False
            self._changes[0] += 1

    def run(self, work: Callable[[int], None], threads: int):
        """
        Call work(number) here, as number 0, and in the workers below number `threads`.

        Returns when all are done that had begun by the time the caller was; raises what one of
        them raised.
        """
        self._start_after_fork()
        job = _Job(work, threads)
        with self._lock:
            self._job = job
            self._changes[0] += 1
            self._wake_sleepers(threads)
        try:
            work(0)
        finally:
            with self._lock:
                self._job = None
            while job.busy[0]:
                spin_until_changed(job.busy, job.busy[0])
        if job.error is not None:
            raise job.error

    def _wake_sleepers(self, threads):
        """Let those who sleep enter their loop; the lock is held."""
        for number in set(range(1, threads)) - self._awake:
            self._awake.add(number)
            self._executor.submit(apart, self._worker_loop, number, caller=processor())

    def _worker_loop(self, number):
        """Do one job after another, as one thread, until there is none for a while."""
        last = None
        while True:
            with self._lock:
                job, changes = self._job, self._changes[0]
                is_mine = job not in (None, last) and number < job.threads
                if is_mine:
                    job.busy[0] += 1
                elif not self._is_frame:
                    self._awake.discard(number)
                    return
            if is_mine:
                last = job
                try:
                    job.work(number)
                except BaseException as error:
                    job.error = error
                with self._lock:
                    job.busy[0] -= 1
            elif not spin_until_changed(self._changes, changes):
                with self._lock:
                    if self._changes[0] == changes:
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
        self._lock = threading.Lock()
        # All under the lock: the present job, if any; a count of changes; the numbers of those
        # awake; whether a frame is on.
        self._job, self._changes, self._awake = None, np.zeros(1, np.int64), set()
        self._is_frame = False
        if self._count > 0:
            self._executor = ThreadPoolExecutor(self._count, 'flag_sim')
            here = threading.Barrier(self._count + 1)
            try:
                for _ in range(self._count):
                    self._executor.submit(here.wait)
                here.wait()
            except RuntimeError:
                here.abort()
                raise


class _Job:
    """Work for several threads: how many workers are at it, and what went wrong there."""

    def __init__(self, work, threads):
        self.work, self.threads = work, threads
        self.busy, self.error = np.zeros(1, np.int64), None
