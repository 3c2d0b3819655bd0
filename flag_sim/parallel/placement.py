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
On which processor a thread runs: two that wait for one another must not share one.

A system wakes a thread where it finds it best at that moment, which may be the processor of the
one who woke it. Threads that share a step then take turns on it: both are always busy, so the
system sees no reason to part them, though another processor is free. Of frames of 62 ms some were
so from their first step to their last, and took as long as with one thread (121 x 81 nodes).
"""
from collections.abc import Callable
import contextlib
import ctypes
import os
from pathlib import Path

_LOAD = Path('/proc/loadavg')
_c = ctypes.PyDLL(None)  # keeps Python's lock: to give it away takes longer than the call


def processor() -> int:
    """Return the number of the processor that the calling thread runs on."""
    return _c.sched_getcpu()


def is_one_free() -> bool:
    """Return whether no more threads run, or are ready to run, than there are processors."""
    try:
        running = _LOAD.read_text().split()[3].split('/')[0]
    except (OSError, IndexError):  # a system without /proc tells nothing
        return False
    return int(running) <= (os.cpu_count() or 1)


def part_from(other: int) -> None:
    """
    Move the calling thread to another processor if it runs on processor `other` and one is free.

    Where all are busy it stays: threads that wait for one another on two processors, each shared
    with others' work, took 1.3 to 1.5 times as long as on one of them. Where it may run does not
    change.
    """
    if processor() != other:
        return
    allowed = os.sched_getaffinity(0)
    elsewhere = allowed - {other}
    if elsewhere and is_one_free():
        # An allowance that changes meanwhile, as a container's, refuses what is no longer in it.
        with contextlib.suppress(OSError):
            try:
                os.sched_setaffinity(0, elsewhere)
            finally:
                os.sched_setaffinity(0, allowed)


def apart(work: Callable, *arguments, caller: int):
    """Return work(*arguments), done on another processor than `caller` if one is free."""
    part_from(caller)
    return work(*arguments)
