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

"""How a pool's threads share work, and what happens when one of them cannot."""
import threading
import time

from flag_sim.jit.kernels import kernel
from flag_sim.parallel import thread_choice, thread_pool, workers
from flag_sim.parallel.atomics import fetch_add
from flag_sim.parallel.thread_choice import FRAMES_PER_CHOICE
from flag_sim.parallel.thread_pool import ThreadPool
import numpy as np
import pytest


def test_a_choice_is_made_per_amount_of_work(monkeypatch):
    """Frames of a hundred steps and of one are compared by the step."""
    now = [0.0]
    monkeypatch.setattr(thread_choice.os, 'sched_getaffinity', lambda process: range(4))
    monkeypatch.setattr(thread_pool.time, 'perf_counter', lambda: now[0])
    pool, taken = ThreadPool(0), []
    for amount in (100, 1) * (3 * FRAMES_PER_CHOICE // 2) + (1,) * 5:
        with pool.frame(amount):
            taken.append(pool.threads)
            now[0] += amount * {1: 1.0, 2: 0.6, 4: 0.8}[pool.threads]
    assert taken[-5:] == [2] * 5


def test_threads_are_awake_in_a_frame_alone():
    """They are woken once, stay for the frame's next work, and sleep when the frame is over."""
    pool, called = ThreadPool(2), []

    def work(number):
        called.append(number)
        while len(called) % 2:  # until the other one is here
            time.sleep(1e-4)

    with pool:
        pool.wake()
        for _ in range(5):
            pool.parallel_for(work)
    assert sorted(called) == [0] * 5 + [1] * 5
    pool._workers.submit(int).result(10.0)  # its only thread is free again
    assert pool._workers._awake == set()


def test_a_late_thread_is_not_waited_for():
    """One that is busy elsewhere, as where a processor has other things to do."""
    pool, called, is_over = ThreadPool(2), [], threading.Event()
    busy = pool._workers.submit(is_over.wait, 10.0)
    pool.parallel_for(called.append)
    is_over.set()
    busy.result()
    assert called == [0]


def test_each_piece_is_taken_once():
    """By whichever thread comes first."""
    @kernel(cache=False)
    def take_all(taken, times):
        while True:
            piece = fetch_add(taken, 0, 1)
            if piece >= times.size:
                break
            times[piece] += 1

    taken, times = np.zeros(1, np.int64), np.zeros(300_000, np.int64)
    take_all(taken, times[:0])
    taken[:] = 0
    # The threads' own places in `times` never overlap, if each piece is taken by one alone.
    ThreadPool(4).parallel_for(lambda number: take_all(taken, times))
    np.testing.assert_array_equal(times, 1)
    assert taken[0] > times.size


def test_an_error_in_a_thread_is_not_lost():
    """Whichever way the work is shared."""
    def work(band, bands):
        if band == 1:
            raise ValueError('of the second band')
    with pytest.raises(ValueError, match='second'):
        ThreadPool(2).run_bands(work)
    begun = threading.Event()

    def share(number):  # one that is late would not be waited for
        begun.set() if number else begun.wait(60.0)
        work(number, 2)
    with pytest.raises(ValueError, match='second'):
        ThreadPool(2).parallel_for(share)


def test_threads_that_wait_are_released_when_one_cannot_come():
    """An error in the first band must not leave the others waiting for it."""
    released = threading.Event()

    def wait(band, bands):
        if band == 0:
            raise ValueError('cannot come')
        assert released.wait(60.0)

    with pytest.raises(ValueError, match='cannot come'):
        ThreadPool(3).run_bands(wait, released.set)
    assert released.is_set()


def test_a_system_without_threads_left_is_an_error_at_the_start(monkeypatch):
    """Not a wait without end at the first frame."""
    class NoThreads(workers.ThreadPoolExecutor):

        def submit(self, *arguments):
            if self._threads:
                raise RuntimeError("can't start new thread")
            return super().submit(*arguments)

    monkeypatch.setattr(workers, 'ThreadPoolExecutor', NoThreads)
    with pytest.raises(RuntimeError, match='new thread'):
        ThreadPool(4)
