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

"""What a soak reads of processes and of the machine, and how it judges a growth."""
import contextlib
import math
import os
from pathlib import Path
import re
from typing import NamedTuple

from flag_sim.ros.dds_profile import SHM

MEGABYTE = 1e6
TICK = os.sysconf('SC_CLK_TCK')
BUSY = 0.1
"""Share of the machine that is not this soak's from which real time is not judged."""


class Growth(NamedTuple):
    """A slope by least squares, and its standard error, in what was measured an hour."""

    an_hour: float
    error: float

    def judged(self, bound: float) -> str:
        """Return whether the growth is 'under' a bound, 'over' it, or 'undecided' (95 %)."""
        if self.an_hour + 2.0 * self.error < bound:
            return 'under'
        return 'over' if self.an_hour - 2.0 * self.error > bound else 'undecided'


def growth(times: list[float], values: list[float], block: float = 10.0) -> Growth:
    """
    Return how values grow with times [s].

    Samples of one block of time [s] are averaged first: neighbours are alike, and a standard
    error of all of them would promise too much.
    """
    blocks = {}
    for time, value in zip(times, values, strict=True):
        blocks.setdefault(int((time - times[0]) // block), []).append((time, value))
    points = [tuple(map(_mean, zip(*samples, strict=True))) for samples in blocks.values()]
    if len(points) < 3:
        return Growth(math.nan, math.nan)
    middle, level = (_mean(column) for column in zip(*points, strict=True))
    spread = sum((time - middle)**2 for time, _ in points)
    slope = sum((time - middle) * (value - level) for time, value in points) / spread
    rest = sum((value - level - slope * (time - middle))**2 for time, value in points)
    return Growth(3600.0 * slope, 3600.0 * math.sqrt(rest / (len(points) - 2) / spread))


def _mean(numbers):
    return sum(numbers) / len(numbers)


def memory(pid: int) -> dict[str, float]:
    """
    Return the resident memory of a process [MB]: its own, and that of shared segments.

    A segment of Fast DDS counts for every process as far as it has touched it, up to its size.
    """
    status = Path(f'/proc/{pid}/status').read_text()
    return {name: 1024.0 * int(re.search(rf'Rss{field}:\s+(\d+)', status)[1]) / MEGABYTE
            for name, field in (('own', 'Anon'), ('shared', 'Shmem'))}


def processor_time(pid: int) -> float:
    """Return the processor time that a process has used [s]."""
    fields = Path(f'/proc/{pid}/stat').read_text().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICK


class Machine:
    """The processors since this object was made, as shares of all of them: see `shares`."""

    def __init__(self):
        self._before = self._read()

    @staticmethod
    def _read():
        return [int(ticks) / TICK for ticks in Path('/proc/stat').read_text().split()[1:9]]

    def shares(self, ours: float) -> dict[str, float]:
        """
        Return {'idle', 'stolen', 'others'}: of which a virtual machine was deprived, and others'.

        ours: the processor time that the caller's processes have used meanwhile [s].
        """
        spent = [now - before for now, before in zip(self._read(), self._before, strict=True)]
        total = sum(spent)
        idle, stolen = (spent[3] + spent[4]) / total, spent[7] / total
        return {'idle': idle, 'stolen': stolen,
                'others': max(1.0 - idle - stolen - ours / total, 0.0)}


def segments(pids: list[int]) -> set[str]:
    """Return the names in /dev/shm of the segments and ports of Fast DDS that processes map."""
    found = set()
    for pid in pids:
        with contextlib.suppress(OSError):
            maps = Path(f'/proc/{pid}/maps').read_text()
            found |= set(re.findall(rf'{SHM}/(fastdds_\w+)$', maps, re.MULTILINE))
    return found


def left_behind(names: set[str]) -> set[str]:
    """Return which of these names are still in /dev/shm though no process maps them."""
    pids = [int(path.name) for path in Path('/proc').iterdir() if path.name.isdecimal()]
    return {name for name in names if (SHM / name).exists()} - segments(pids)
