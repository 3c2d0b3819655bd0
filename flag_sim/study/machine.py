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

"""Which machine measured, and whether it had something else to do."""
import functools
import os
from pathlib import Path
import platform
import time

from flag_sim.jit.cache import fingerprint
import numba
import numpy as np


@functools.lru_cache
def processor() -> str:
    """Return the processor's name."""
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(':')[2].strip() for line in lines if line.startswith('model name')]
    return names[0] if names else platform.processor() or platform.machine()


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0))


def identity() -> dict[str, str]:
    """Return what measurements depend on beside the settings: {word: text}."""
    return {'machine': f'{processor()}, {cores()} cores', 'code': fingerprint()[:16]}


def versions() -> str:
    """Return the versions of what the numbers were made with, in words."""
    return (f'Python {platform.python_version()}, numba {numba.__version__}, '
            f'numpy {np.__version__}, {platform.system()} {platform.release()}')


BUSY = 0.25  # part of the processors' time above which others disturb times too often for a median


class Watch:
    """
    What others do on this process' processors while it measures.

    Not the load average, which a minute later still tells of what has ended before.
    """

    def __init__(self):
        self._start, self._begin = time.monotonic(), _used()

    def seconds(self) -> float:
        """Return how long it has watched [s]."""
        return time.monotonic() - self._start

    def others(self) -> float | None:
        """Return how many processors others kept busy on average; None where Linux is not."""
        now = _used()
        if self._begin is None or now is None:
            return None
        busy, own = (end - begin for begin, end in zip(self._begin, now))
        return max(0.0, busy - own) / self.seconds()


def is_busy(others: float | None) -> bool:
    """Return whether others disturbed the times; what is not known did not."""
    return others is not None and others > BUSY * cores()


def _used():
    """
    Return the seconds of all work on this process' processors so far, and of its own work.

    What a virtual machine's host took away (steal) counts as work too. None where the system does
    not tell (see proc_stat(5)).
    """
    try:
        lines = Path('/proc/stat').read_text().splitlines()
    except OSError:
        return None
    names = {f'cpu{number}' for number in os.sched_getaffinity(0)}
    # user, nice, system, idle, iowait, irq, softirq, steal
    ticks = [[int(field) for field in line.split()[1:9]] for line in lines
             if line.split()[0] in names]
    busy = sum(sum(fields) - fields[3] - fields[4] for fields in ticks)
    return busy / os.sysconf('SC_CLK_TCK'), sum(os.times()[:4])
