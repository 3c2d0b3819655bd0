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
A barrier: where the threads that share a step wait for one another.

A step takes some microseconds, too few for Python to be asked between two: so each thread runs
many steps of its band in one compiled call, and waits for the others in here. Steps that are
handed out one by one, by ThreadPool.run_bands, take 3.8 times as long (219 us and 58 us, 61 x 41
nodes, symplectic, two threads; median of 300 turns with and without, quartiles 3.6 and 3.9, on a
machine whose two processors were busy).
"""
from flag_sim.jit.kernels import shared_kernel
from flag_sim.parallel.atomics import fetch_add, load
from flag_sim.parallel.spinning import LOADS_BEFORE_YIELD, yield_processor
import numpy as np

# Where the cells of a barrier lie: each in a cache line of its own.
BANDS, ARRIVALS, IS_RELEASED = 0, 8, 16
CELLS = 24


def new_barrier(bands: int) -> np.ndarray:
    """Return a barrier, an array of int64, for so many threads; for one it is always open."""
    barrier = np.zeros(CELLS, np.int64)
    barrier[BANDS] = bands
    return barrier


def release(barrier: np.ndarray):
    """Let all threads through from now on, as one will not come; their results are void."""
    barrier[IS_RELEASED] = 1


@shared_kernel
def wait(barrier: np.ndarray):
    """Return once all threads are at the barrier: what they wrote before can then be read."""
    bands = barrier[BANDS]
    if bands == 1:
        return
    # The counter only grows: all have arrived for this time when it is at the next multiple.
    goal = (fetch_add(barrier, ARRIVALS, 1) // bands + 1) * bands
    loads = 0
    while load(barrier, ARRIVALS) < goal and load(barrier, IS_RELEASED) == 0:
        loads += 1
        if loads > LOADS_BEFORE_YIELD:
            yield_processor()
