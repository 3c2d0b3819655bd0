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

"""A barrier: nobody leaves it before all are there, unless it is released."""
import threading

from flag_sim.parallel.barrier import new_barrier, release, wait
import numpy as np


def test_nobody_leaves_a_barrier_before_all_are_there():
    """Many waits of three threads, one of which is always late."""
    barrier, turns, seen = new_barrier(3), 200, []
    at = np.zeros(3, int)

    def visit(who):
        for turn in range(1, turns + 1):
            if who == turn % 3:
                threading.Event().wait(1e-4)
            at[who] = turn
            wait(barrier)
            seen.append(at.min() >= turn)

    threads = [threading.Thread(target=visit, args=(who,)) for who in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert len(seen) == 3 * turns and all(seen)


def test_a_released_barrier_holds_nobody():
    """Neither those who wait there already nor those who come."""
    barrier = new_barrier(2)
    waiting = threading.Thread(target=wait, args=(barrier,))
    waiting.start()
    waiting.join(0.05)
    assert waiting.is_alive()
    release(barrier)
    waiting.join(10.0)
    assert not waiting.is_alive()
    wait(barrier)
