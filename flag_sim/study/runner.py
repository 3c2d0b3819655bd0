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

"""How a study runs: rows that survive an interruption, and the user's minutes shared out."""
from collections.abc import Callable, Iterator
import contextlib
import csv
import io
import json
import os
from pathlib import Path
import sys
import time
from typing import NamedTuple

from flag_sim.parameters import checks
from flag_sim.study.machine import Watch

MARK = 'study.json'  # the file that makes a folder the folder of a study, and says of which


class Store:
    """
    Rows of measurements in a folder, which a later run goes on with.

    identity: {word: text} of what the rows depend on (version, machine, settings). Raises
    ValueError where the folder holds something else, rows of another identity, or cannot be
    written. A row is a dict with a `key` that no other row of its section has, and is on the disk
    before add returns: an interruption loses at most the row that is being measured.
    """

    def __init__(self, folder: Path, identity: dict[str, str]):
        self.folder = checks.path('folder', folder)
        self._rows = {}
        mark = self.folder / MARK
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if not mark.exists():
                if any(self.folder.iterdir()):
                    raise ValueError(f'output must be a new folder or one of a study; '
                                     f'{self.folder} holds something else')
                mark.write_text(json.dumps(identity, indent=2) + '\n')
            known = json.loads(mark.read_text())
            # Also a folder of a finished study must take plots and a report.
            if not os.access(self.folder, os.W_OK):
                raise PermissionError('no permission to write there')
        except OSError as error:
            raise ValueError(f'output {self.folder} cannot be written: {error}') from error
        except json.JSONDecodeError:
            raise ValueError(f'output {self.folder} holds a broken {MARK}') from None
        other = [f'{word} is {known.get(word)!r}, not {text!r}'
                 for word, text in identity.items() if known.get(word) != text]
        if other:
            raise ValueError(f'output {self.folder} holds another study: {"; ".join(other)}')

    def path(self, section: str) -> Path:
        """Return the path of a section's file."""
        return self.folder / f'{section}.csv'

    def rows(self, section: str) -> list[dict]:
        """Return the rows of a section in the order in which they were added: a list of dicts."""
        return list(self._by_key(section).values())

    def row(self, section: str, key: str) -> dict:
        """Return the row of a key."""
        return self._by_key(section)[key]

    def has(self, section: str, key: str) -> bool:
        """Return whether a section has the row of a key."""
        return key in self._by_key(section)

    def _by_key(self, section):
        if section not in self._rows:
            self._rows[section] = {row['key']: row for row in read_csv(self.path(section))}
        return self._rows[section]

    def add(self, section: str, row: dict) -> None:
        """
        Write a row {column: number or text}; None is an empty field.

        All rows of a section have the same columns, `key` among them; raises ValueError otherwise.
        """
        rows = self.rows(section)
        if 'key' not in row or (rows and list(rows[0]) != list(row)):
            raise ValueError(f'a row of {section} must have the columns '
                             f'{list(rows[0]) if rows else ["key", "..."]}, not {list(row)}')
        if self.has(section, row['key']):
            raise ValueError(f'{section} already has a row {row["key"]!r}')
        with open(self.path(section), 'a', newline='') as file:
            csv.writer(file, lineterminator='\n').writerows(
                [*([] if rows else [row]), row.values()])
            file.flush()
            os.fsync(file.fileno())
        self._by_key(section)[row['key']] = dict(row)


def read_csv(path: Path) -> list[dict]:
    """Return the whole rows of a file; cut off what an interruption left of the last one."""
    if not path.exists():
        return []
    content = path.read_bytes()
    whole = content[:content.rfind(b'\n') + 1]
    if whole != content:
        with open(path, 'r+b') as file:
            file.truncate(len(whole))
    rows = csv.DictReader(io.StringIO(whole.decode(), newline=''))
    return [{name: value if name == 'key' else _value(value) for name, value in row.items()}
            for row in rows]


def _value(text):
    """Return a field as what was written: None, a whole number, a number or text."""
    if text in ('', 'True', 'False'):
        return {'': None, 'True': True, 'False': False}[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


SESSIONS = 'sessions'  # name of the rows on the times in which a study was measured


class Batch(NamedTuple):
    """Rows of a section that are measured one after the other, once they have begun."""

    progress: str                           # what is printed of it
    rows: dict[str, Callable[[], dict]]     # {key: what measures the row's other columns}
    is_required: bool = False               # whether even the shortest study has it
    seconds: float = 0.0                    # that must be left for it to begin


class Budget:
    """The time that one section of a study has: seconds of it, from now."""

    def __init__(self, name: str, seconds: float):
        self.name = name
        self._end = time.monotonic() + seconds
        self._said = None

    def left(self) -> float:
        """Return the seconds that are left, negative when overdrawn."""
        return self._end - time.monotonic()

    def allows(self, seconds: float = 0.0) -> bool:
        """Return whether something that takes some seconds may still begin."""
        return self.left() > seconds

    def say(self, text: str) -> None:
        """Print how far the section has come, each text once."""
        if text != self._said:
            say(f'{self.name} ({max(self.left(), 0.0):.0f} s left): {text}')
        self._said = text


def say(text: str) -> None:
    """Print progress beside what is piped on."""
    print(text, file=sys.stderr, flush=True)


def share(seconds: float, sections: list) -> Iterator[tuple]:
    """
    Yield (section, its Budget) for sections that run one after the other.

    Each gets its SHARE of what is then left, so that what one does not use is of use to the next.
    """
    end = time.monotonic() + seconds
    shares = [section.SHARE for section in sections]
    for number, section in enumerate(sections):
        yield section, Budget(section.NAME, (
            (end - time.monotonic()) * section.SHARE / sum(shares[number:])))


def measure(section, store: Store, budget: Budget) -> None:
    """Add to a section's rows those that are missing, batch after batch, as the budget allows."""
    for batch in section.batches(store):
        missing = [key for key in batch.rows if not store.has(section.NAME, key)]
        if not missing:
            continue
        if not (batch.is_required or budget.allows(batch.seconds)):
            return
        budget.say(batch.progress)
        for key in missing:
            store.add(section.NAME, {'key': key, **batch.rows[key]()})


@contextlib.contextmanager
def session(store: Store):
    """Add a row on the time in which the block runs to a Store, also where it is interrupted."""
    watch = Watch()
    try:
        yield
    finally:
        others, seconds = watch.others(), watch.seconds()
        store.add(SESSIONS, {'key': str(len(store.rows(SESSIONS))), 'seconds': seconds,
                             'others': others})


def taken_by_others(store: Store) -> float | None:
    """Return how many processors others kept busy, on average over all sessions; or None."""
    rows = [row for row in store.rows(SESSIONS) if row['others'] is not None]
    total = sum(row['seconds'] for row in rows)
    return sum(row['seconds'] * row['others'] for row in rows) / total if total else None
