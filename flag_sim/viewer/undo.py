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

"""Undo and redo of edits of the wind's parameters. No Qt."""
from collections.abc import Collection
import dataclasses

MOST = 200
"""Edits that can be undone."""
AUTOKEY = 'autokey'
"""The words of an edit that the wind has made by itself."""


@dataclasses.dataclass(frozen=True)
class Edit:
    """Parameters {name: value, None where there is none} before and after; words: what it was."""

    words: str
    before: dict
    after: dict


class History:
    """
    Edits that have been made, and that have been undone since.

    What others change meanwhile is not undone with them: such edits are forgotten.
    """

    def __init__(self):
        self._done, self._undone = [], []

    @property
    def next_undo(self) -> Edit | None:
        """Return the edit that would be undone."""
        return self._done[-1] if self._done else None

    @property
    def next_redo(self) -> Edit | None:
        """Return the edit that would be made again."""
        return self._undone[-1] if self._undone else None

    def add(self, edit: Edit) -> None:
        """
        Note an edit that has been made: what was undone before cannot be made again.

        Edits by AUTOKEY of the same parameters, one after another, are one: a slider makes many.
        """
        last = self.next_undo
        if edit.words == AUTOKEY and last and last.words == AUTOKEY and (
                last.after.keys() == edit.after.keys()):
            self._done.pop()
            edit = Edit(AUTOKEY, last.before, edit.after)
        self._done.append(edit)
        del self._done[:-MOST], self._undone[:]

    def undone(self) -> None:
        """Note that the last edit has been undone."""
        self._undone.append(self._done.pop())

    def redone(self) -> None:
        """Note that the edit that was undone last has been made again."""
        self._done.append(self._undone.pop())

    def forget(self, names: Collection[str]) -> None:
        """Forget the edits of parameters that somebody else has changed, and all before them."""
        for edits in (self._done, self._undone):
            for n in reversed(range(len(edits))):
                if not {*edits[n].after}.isdisjoint(names):
                    del edits[:n + 1]
                    break
