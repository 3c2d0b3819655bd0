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

"""The pool's choice among numbers of threads, and what happens when one cannot work."""
from flag_sim.parallel import thread_pool
import pytest

ROUNDS = thread_pool.ROUNDS


@pytest.fixture
def clock(monkeypatch):
    """Return a clock, as a list of one time, that is moved by hand, and four processors."""
    now = [0.0]
    monkeypatch.setattr(thread_pool.os, 'sched_getaffinity', lambda process: range(4))
    monkeypatch.setattr(thread_pool.time, 'perf_counter', lambda: now[0])
    return now


def work(pool, now, seconds, frames, amount=1):
    """Do frames that last seconds {threads: s} for each amount; return the numbers taken."""
    taken = []
    for _ in range(frames):
        with pool.frame(amount):
            taken.append(pool.threads)
            now[0] += amount * seconds[pool.threads]
    return taken


def test_a_choice_is_made_per_amount_of_work(clock):
    """Frames of a hundred steps and of one are compared by the step."""
    pool = thread_pool.ThreadPool(0)
    seconds = {1: 1.0, 2: 0.6, 4: 0.8}
    for amount in (100, 1) * (3 * ROUNDS // 2):
        work(pool, clock, seconds, 1, amount)
    assert work(pool, clock, seconds, 5) == [2] * 5


def test_threads_that_are_in_one_anothers_way_are_given_up(clock):
    """When the machine is busy, a frame by two is slower than by one; then one does it."""
    pool = thread_pool.ThreadPool(0)
    idle, busy = {1: 1.0, 2: 0.6, 4: 0.8}, {1: 1.1, 2: 9.0, 4: 30.0}
    work(pool, clock, idle, 3 * ROUNDS)
    # Single slow frames are nothing.
    assert work(pool, clock, busy, ROUNDS - 1) == [2] * (ROUNDS - 1)
    assert work(pool, clock, idle, 2) == [2] * 2
    assert work(pool, clock, busy, ROUNDS) == [2] * ROUNDS
    assert set(work(pool, clock, busy, 3 * ROUNDS)) == {1, 2, 4}
    assert work(pool, clock, busy, 20) == [1] * 20


def test_another_work_is_another_choice(clock):
    """Measure again on demand; a given number of threads is never changed."""
    pool, given = thread_pool.ThreadPool(0), thread_pool.ThreadPool(3)
    work(pool, clock, {1: 1.0, 2: 0.6, 4: 0.8}, 3 * ROUNDS)
    pool.measure(), given.measure()
    work(pool, clock, {1: 1.0, 2: 1.6, 4: 0.5}, 3 * ROUNDS)
    assert (pool.threads, given.threads) == (4, 3)
    assert work(given, clock, {3: 1.0}, 20) == [3] * 20


def test_those_who_wait_are_released_when_one_cannot_come():
    """An error in the first band must not leave the others waiting for it."""
    told = thread_pool.threading.Event()

    def wait(band, bands):
        if band == 0:
            raise ValueError('cannot come')
        assert told.wait(60.0)

    with pytest.raises(ValueError, match='cannot come'):
        thread_pool.ThreadPool(3).run_bands(wait, told.set)
    assert told.is_set()


def test_a_system_without_threads_left_is_an_error_at_the_start(monkeypatch):
    """Not a wait without end at the first frame."""
    class NoThreads(thread_pool.ThreadPoolExecutor):

        def submit(self, *arguments):
            if self._threads:
                raise RuntimeError("can't start new thread")
            return super().submit(*arguments)

    monkeypatch.setattr(thread_pool, 'ThreadPoolExecutor', NoThreads)
    with pytest.raises(RuntimeError, match='new thread'):
        thread_pool.ThreadPool(4)
