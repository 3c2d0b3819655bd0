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

"""Which lines to log: the same reason at most every few seconds, a wait once it is long."""
import re
from typing import NamedTuple

LOG_WAIT_AFTER = 2.0
"""How long a wait may last before it is logged [s]: while nodes start, frames come late."""
WARN_EVERY = 5.0
"""How often a line with the same reason may be logged [s]."""
MAX_REASONS = 8
"""Different reasons logged within WARN_EVERY: a broken sender must not fill the log."""


class Entry(NamedTuple):
    """A line for the log."""

    level: str  # info, warning or error
    text: str


class Refusals:
    """
    Decides which refusals to log: a new reason at once, the same again only now and then.

    Reasons that differ only in their numbers count as the same.
    """

    def __init__(self):
        self._logged: dict[str, float] = {}  # steady time [s] at which a reason was logged last

    def is_worth_logging(self, reason: str, now: float) -> bool:
        """Return whether to log a reason at steady time `now` [s]; it then counts as logged."""
        reason = re.sub(r'[\d.]+', '', reason)
        self._logged = {r: at for r, at in self._logged.items() if now - at < WARN_EVERY}
        if reason in self._logged or len(self._logged) >= MAX_REASONS:
            return False
        self._logged[reason] = now
        return True


class Waiting:
    """Logs what a node waits for once it has waited for `patience` [s], and when that ends."""

    def __init__(self, patience: float = LOG_WAIT_AFTER):
        self._patience = patience
        self._since = None  # steady time at which the present wait began [s]
        self._served = 0
        self._is_logged = False

    def look(self, missing: str, served: int, now: float) -> Entry | None:
        """
        Return what there is to log at steady time `now` [s], or None.

        missing: what the node waits for, in words, '' for nothing. served: how many frames it has
        served so far; with every frame its patience begins anew.
        """
        entry = None
        has_served, self._served = served != self._served, served
        if has_served or not missing:
            if self._is_logged:
                ends = 'frames are served again' if has_served else 'nothing is missing any more'
                entry = Entry('info', f'{ends}, after {now - self._since:.1f} s')
            self._since, self._is_logged = None, False
        if missing and self._since is None:
            self._since = now
        elif missing and not self._is_logged and now - self._since >= self._patience:
            entry = Entry('warning', f'waiting for {now - self._since:.1f} s for {missing}')
            self._is_logged = True
        return entry
