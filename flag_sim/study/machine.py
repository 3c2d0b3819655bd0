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

"""Which machine measured, and whether other programs kept it busy."""
import functools
import os
from pathlib import Path
import platform
import time

from flag_sim.jit.cache import fingerprint
import numba
import numpy as np

BUSY_SHARE = 0.25
"""Part of the processors' time above which others disturb times too often for a median."""


def _lines(path):
    """Return the lines of a file of the system, none where it is not there."""
    try:
        return Path(path).read_text().splitlines()
    except OSError:
        return []


@functools.lru_cache
def processor() -> str:
    """Return the processor's name."""
    names = [line.partition(':')[2].strip() for line in _lines('/proc/cpuinfo')
             if line.startswith('model name')]
    return names[0] if names else platform.processor() or platform.machine()


def cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0))


UNSPOKEN = {'code': 'it was measured by another version of flag_sim'}
"""What a difference means, in words, of what identity returns and people cannot read."""


def identity() -> dict[str, str]:
    """Return what measurements depend on beside the settings: {word: text}."""
    return {'machine': f'{processor()}, {cores()} cores', 'code': fingerprint()[:16]}


def versions() -> str:
    """Return the versions of what the numbers were made with."""
    return (f'Python {platform.python_version()}, numba {numba.__version__}, '
            f'numpy {np.__version__}, {platform.system()} {platform.release()}')


class LoadMonitor:
    """
    How busy other programs keep this process' processors while it measures.

    Not the load average, which still counts for a minute what has ended before.
    """

    def __init__(self):
        self._start, self._begin = time.monotonic(), _processor_seconds()

    def seconds(self) -> float:
        """Return the time since the start [s]."""
        return time.monotonic() - self._start

    def others(self) -> float | None:
        """Return how many processors others kept busy on average; None if it is not known."""
        now = _processor_seconds()
        if self._begin is None or now is None:
            return None
        busy, own = (end - begin for begin, end in zip(self._begin, now))
        return max(0.0, busy - own) / self.seconds()


def is_busy(others: float | None) -> bool:
    """Return whether others disturbed the times; an unknown load did not."""
    return others is not None and others > BUSY_SHARE * cores()


def _processor_seconds():
    """
    Return the seconds of all work on this process' processors so far, and of its own work.

    What a virtual machine's host took away (steal) counts as work too. None where the system does
    not tell (see proc_stat(5)).
    """
    names = {f'cpu{number}' for number in os.sched_getaffinity(0)}
    # user, nice, system, idle, iowait, irq, softirq, steal
    ticks = [[int(field) for field in line.split()[1:9]] for line in _lines('/proc/stat')
             if line.split()[0] in names]
    if not ticks:
        return None
    busy = sum(sum(fields) - fields[3] - fields[4] for fields in ticks)
    return busy / os.sysconf('SC_CLK_TCK'), sum(os.times()[:4])
