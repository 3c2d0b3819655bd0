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

"""Rows of measurements in a folder, which survive an interruption."""
from collections.abc import Mapping
import csv
import io
import json
import os
from pathlib import Path
from types import MappingProxyType

from flag_sim.parameters import checks

IDENTITY = 'study.json'  # the file that marks a study's folder, and says what was measured where


class Store:
    """
    Rows of measurements in a folder, which a later run continues.

    identity: {word: text} of what the rows depend on (version, machine, settings); unspoken:
    {word: what is wrong in words} of those whose texts, such as digests, tell people nothing.
    Raises ValueError where the folder holds something else, rows of another identity, or cannot
    be written. A row is a dict with a `key` that is unique in its section; it is on the disk
    before add returns, so that an interruption loses at most the row that is being measured.
    """

    def __init__(self, folder: Path, identity: Mapping[str, str],
                 unspoken: Mapping[str, str] = MappingProxyType({})):
        self.folder = checks.path('folder', folder)
        self._rows = {}
        mark = self.folder / IDENTITY
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if not mark.exists():
                if any(self.folder.iterdir()):
                    raise ValueError(f'output must be a new folder or one of a study; '
                                     f'{self.folder} holds something else')
                mark.write_text(json.dumps(identity, indent=2) + '\n')
            known = _known(mark)
            # Also a folder of a finished study must take plots and a report.
            if not os.access(self.folder, os.W_OK):
                raise PermissionError('no permission to write there')
        except OSError as error:
            raise ValueError(f'output {self.folder} cannot be written: '
                             f'{error.strerror or error}') from error
        other = [unspoken.get(word) or f'its {word} is {known.get(word)}, not {text}'
                 for word, text in identity.items() if known.get(word) != text]
        if other:
            raise ValueError(f'output {self.folder} holds another study: {"; ".join(other)}. '
                             f'Name another --output, or remove {self.folder}')

    def path(self, section: str) -> Path:
        """Return the path of a section's file."""
        return self.folder / f'{section}.csv'

    def rows(self, section: str) -> list[dict]:
        """Return the rows of a section in the order in which they were added."""
        return list(self._by_key(section).values())

    def row(self, section: str, key: str) -> dict | None:
        """Return the row of a key, or None."""
        return self._by_key(section).get(key)

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
        if self.row(section, row['key']):
            raise ValueError(f'{section} already has a row {row["key"]!r}')
        with open(self.path(section), 'a', newline='') as file:
            csv.writer(file, lineterminator='\n').writerows(
                [*([] if rows else [row]), row.values()])
            file.flush()
            os.fsync(file.fileno())
        self._by_key(section)[row['key']] = dict(row)


def _known(mark):
    """Return the identity in a study's folder; raises ValueError for what is none."""
    try:
        known = json.loads(mark.read_text())
    except ValueError:  # no JSON, no UTF-8
        known = None
    if not isinstance(known, dict):
        raise ValueError(f'{mark} is broken: name another --output, or remove {mark.parent}')
    return known


def read_csv(path: Path) -> list[dict]:
    """Return the complete rows of a file; cut off an incomplete last one."""
    if not path.exists():
        return []
    content = path.read_bytes()
    complete = content[:content.rfind(b'\n') + 1]
    if complete != content:
        os.truncate(path, len(complete))
    rows = csv.DictReader(io.StringIO(complete.decode(), newline=''))
    return [{name: text if name == 'key' else _value(text) for name, text in row.items()}
            for row in rows]


def _value(text):
    """Return a field as what was written: None, a truth value, a number or text."""
    if text in ('', 'True', 'False'):
        return {'': None, 'True': True, 'False': False}[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text
