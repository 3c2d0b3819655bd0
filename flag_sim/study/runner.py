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

"""How a study runs: the user's minutes shared among sections, and batches of rows measured."""
from collections.abc import Callable, Iterator
import contextlib
import sys
import time
from typing import NamedTuple

from flag_sim.study.machine import LoadMonitor
from flag_sim.study.store import Store

SESSIONS = 'sessions'  # name of the rows on the times in which a study was measured


class Batch(NamedTuple):
    """Rows of a section that are measured one after the other, once they have begun."""

    progress: str                  # what is printed
    cases: list[dict]              # the first columns of each row, which no other row has
    measured: Callable[..., dict]  # called with a case's columns as arguments; returns the others
    is_required: bool = False      # whether even the shortest study has it
    seconds: float = 0.0           # that must be left for it to begin


class Budget:
    """The time that one section of a study has: seconds of it, from now."""

    def __init__(self, name: str, seconds: float):
        self.name = name
        self._end = time.monotonic() + seconds
        self._reported = None

    def left(self) -> float:
        """Return the seconds that are left, negative when overdrawn."""
        return self._end - time.monotonic()

    def allows(self, seconds: float = 0.0) -> bool:
        """Return whether something that takes some seconds may still begin."""
        return self.left() > seconds

    def report(self, progress: str) -> None:
        """Print how far the section has come, each text once."""
        if progress != self._reported:
            print_progress(f'{self.name} ({max(self.left(), 0.0):.0f} s left): {progress}')
        self._reported = progress


def print_progress(text: str) -> None:
    """Print to stderr, so that stdout has nothing but the result."""
    print(text, file=sys.stderr, flush=True)


def share(seconds: float, sections: list) -> Iterator[tuple]:
    """
    Yield (section, its Budget) for sections that run one after the other.

    Each gets its SHARE of what is then left, so that unused time goes to the next sections.
    """
    end = time.monotonic() + seconds
    shares = [section.SHARE for section in sections]
    for number, section in enumerate(sections):
        yield section, Budget(section.NAME, (
            (end - time.monotonic()) * section.SHARE / sum(shares[number:])))


def key_of(case: dict) -> str:
    """Return the key of the row that begins with the columns of a case."""
    return '/'.join(map(str, case.values()))


def measure_missing(store: Store, section: str, cases: list[dict], measured: Callable) -> None:
    """Add to a section the rows of cases that it does not have: see Batch."""
    for case in cases:
        if not store.row(section, key_of(case)):
            store.add(section, {'key': key_of(case), **case, **measured(**case)})


def measure(section, store: Store, budget: Budget) -> None:
    """Add to a section's rows those that are missing, batch after batch, as the budget allows."""
    for batch in section.batches(store):
        if all(store.row(section.NAME, key_of(case)) for case in batch.cases):
            continue
        if not (batch.is_required or budget.allows(batch.seconds)):
            return
        budget.report(batch.progress)
        measure_missing(store, section.NAME, batch.cases, batch.measured)


@contextlib.contextmanager
def session(store: Store):
    """Add a row on the time in which the block runs to a Store, also where it is interrupted."""
    monitor = LoadMonitor()
    try:
        yield
    finally:
        others, seconds = monitor.others(), monitor.seconds()
        store.add(SESSIONS, {'key': str(len(store.rows(SESSIONS))), 'seconds': seconds,
                             'others': others})


def load_of_others(store: Store) -> float | None:
    """Return how many processors others kept busy, on average over all sessions; or None."""
    rows = [row for row in store.rows(SESSIONS) if row['others'] is not None]
    total = sum(row['seconds'] for row in rows)
    return sum(row['seconds'] * row['others'] for row in rows) / total if total else None
