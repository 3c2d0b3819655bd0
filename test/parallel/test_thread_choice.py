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

"""The choice among numbers of threads: the fastest, measured again when the machine is busy."""
from flag_sim.parallel import thread_choice
from flag_sim.parallel.thread_choice import FRAMES_PER_CHOICE, ThreadChoice
import pytest


@pytest.fixture(autouse=True)
def four_processors(monkeypatch):
    """Let this process have four processors."""
    monkeypatch.setattr(thread_choice.os, 'sched_getaffinity', lambda process: range(4))


def work(choice, seconds, frames):
    """Do frames that last seconds {threads: s}; return the numbers of threads taken."""
    taken = []
    for _ in range(frames):
        choice.begin_frame()
        taken.append(choice.threads)
        choice.end_frame(seconds[choice.threads])
    return taken


@pytest.mark.parametrize('seconds, chosen', [
    ({1: 1.0, 2: 0.6, 4: 0.4}, 4), ({1: 1.0, 2: 0.6, 4: 0.58}, 2), ({1: 1.0, 2: 0.95, 4: 1.5}, 1)])
def test_the_choice(seconds, chosen):
    """More threads only where they are worth it, whatever holds a frame up now and then."""
    choice = ThreadChoice(0)
    taken = []
    for number in range(30):
        slower = 3.0 if number % 4 == 0 else 1.0
        taken += work(choice, {count: slower * time for count, time in seconds.items()}, 1)
    assert set(taken[:-3]) == {1, 2, 4}
    assert choice.threads == chosen


def test_threads_that_are_in_one_anothers_way_are_given_up():
    """When the machine is busy, a frame by two is slower than by one; then one does it."""
    choice = ThreadChoice(0)
    idle, busy = {1: 1.0, 2: 0.6, 4: 0.8}, {1: 1.1, 2: 9.0, 4: 30.0}
    work(choice, idle, 3 * FRAMES_PER_CHOICE)
    # Single slow frames are nothing.
    assert work(choice, busy, FRAMES_PER_CHOICE - 1) == [2] * (FRAMES_PER_CHOICE - 1)
    assert work(choice, idle, 2) == [2] * 2
    assert work(choice, busy, FRAMES_PER_CHOICE) == [2] * FRAMES_PER_CHOICE
    assert set(work(choice, busy, 3 * FRAMES_PER_CHOICE)) == {1, 2, 4}
    assert work(choice, busy, 20) == [1] * 20


def test_another_work_is_another_choice():
    """Measure again on demand; a given number of threads is never changed."""
    choice, given = ThreadChoice(0), ThreadChoice(3)
    work(choice, {1: 1.0, 2: 0.6, 4: 0.8}, 3 * FRAMES_PER_CHOICE)
    choice.restart(), given.restart()
    work(choice, {1: 1.0, 2: 1.6, 4: 0.5}, 3 * FRAMES_PER_CHOICE)
    assert (choice.threads, given.threads) == (4, 3)
    assert work(given, {3: 1.0}, 20) == [3] * 20
