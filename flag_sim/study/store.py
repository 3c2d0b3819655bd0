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

"""Where a study keeps its rows: one CSV file a part, safe against interruption."""
import csv
import io
import json
import os

from flag_sim import checks

MARK = 'study.json'
"""The file that makes a folder the folder of a study, and says of which."""


class Store:
    """
    Rows of measurements in a folder, which a later run goes on with.

    identity: {word: text} of what the rows depend on (version, machine, settings). Raises
    ValueError where the folder holds something else, rows of another identity, or cannot be
    written. A row is a dict with a `key` that no other row of its part has, and is on the disk
    before add returns: an interruption loses at most the row that is being measured.
    """

    def __init__(self, folder, identity):
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

    def path(self, part):
        """Return the path of a part's file."""
        return self.folder / f'{part}.csv'

    def rows(self, part):
        """Return the rows of a part in the order in which they were added: a list of dicts."""
        if part not in self._rows:
            self._rows[part] = _read(self.path(part))
        return self._rows[part]

    def has(self, part, key):
        """Return whether a part has the row of a key."""
        return any(row['key'] == key for row in self.rows(part))

    def add(self, part, row):
        """
        Write a row {column: number or text}; None is an empty field.

        All rows of a part have the same columns, `key` among them; raises ValueError otherwise.
        """
        rows = self.rows(part)
        if 'key' not in row or (rows and list(rows[0]) != list(row)):
            raise ValueError(f'a row of {part} must have the columns '
                             f'{list(rows[0]) if rows else ["key", "..."]}, not {list(row)}')
        if self.has(part, row['key']):
            raise ValueError(f'{part} already has a row {row["key"]!r}')
        lines = [] if rows else [list(row)]
        with open(self.path(part), 'a', newline='') as file:
            file.write(_lines([*lines, ['' if value is None else value
                                        for value in row.values()]]))
            file.flush()
            os.fsync(file.fileno())
        rows.append(dict(row))


def _lines(table):
    """Return rows of values as CSV text."""
    text = io.StringIO()
    csv.writer(text, lineterminator='\n').writerows(table)
    return text.getvalue()


def _read(path):
    """Return the whole rows of a file; cut off what an interruption left of the last one."""
    if not path.exists():
        return []
    content = path.read_bytes()
    whole = content[:content.rfind(b'\n') + 1]
    if whole != content:
        with open(path, 'r+b') as file:
            file.truncate(len(whole))
    table = csv.DictReader(io.StringIO(whole.decode(), newline=''))
    return [{name: value if name == 'key' else _value(value) for name, value in row.items()}
            for row in table]


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
