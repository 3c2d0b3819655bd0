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

"""Which lines to log: the same reason ever less often, a wait once it is long."""
import collections
import re
from typing import NamedTuple

LOG_WAIT_AFTER = 2.0
"""How long a wait may last before it is logged [s]: while nodes start, frames come late."""
WARN_EVERY = 5.0
"""Before the second line with the same reason [s]; before each further one it is doubled."""
LONGEST_SILENCE = 600.0
"""Between lines with the same reason, however often it comes [s]."""
MAX_REASONS = 8
"""Different reasons logged within WARN_EVERY: a broken sender must not fill the log."""
MAX_REMEMBERED = 64
"""Reasons of which is known when they were logged last."""
MAX_CHARACTERS = 300
"""Of a line that holds what somebody else has sent."""


def shortened(text: str) -> str:
    """
    Return a text as one line of at most MAX_CHARACTERS, for what others send stands in it.

    What is not printable is escaped, so nobody writes lines of their own; of a long one the
    begin, where the rule stands, and the end are kept.
    """
    half = MAX_CHARACTERS // 2
    if len(text) > 4 * MAX_CHARACTERS:  # escaping ten million characters takes a while
        text = f'{text[:2 * half]}...{text[-2 * half:]}'
    line = ''.join(one if one.isprintable() else repr(one)[1:-1] for one in text)
    if len(line) <= MAX_CHARACTERS:
        return line
    begin = MAX_CHARACTERS - half // 2 - 5
    return f'{line[:begin]} ... {line[-half // 2:]}'


class Entry(NamedTuple):
    """A line for the log."""

    level: str  # info, warning or error
    text: str


def without_figures(reason: str) -> str:
    """Return the begin of a reason without its numbers, by which it is recognised."""
    return re.sub(r'[\d.]+', '', reason[:2 * MAX_CHARACTERS])[:MAX_CHARACTERS // 2]


class Refusals:
    """
    Decides which refusals to log: a new reason at once, the same again less and less often.

    Reasons that differ only in their numbers, or far from their begin, count as the same.
    """

    def __init__(self):
        # By reason: the steady time at which it was logged last, and how long it rests then [s].
        self._logged: dict[str, tuple[float, float]] = {}

    def __len__(self) -> int:
        return len(self._logged)

    def is_worth_logging(self, reason: str, now: float) -> bool:
        """Return whether to log a reason at steady time `now` [s]; it then counts as logged."""
        reason = without_figures(reason)
        at, rest = self._logged.get(reason, (now, 0.0))
        recent = sum(now - other < WARN_EVERY for other, _ in self._logged.values())
        if now - at < rest or recent >= MAX_REASONS:
            return False
        # A reason that has not come for long is told as a new one.
        is_rare = now - at > 2.0 * rest
        self._logged.pop(reason, None)
        self._logged[reason] = now, (
            WARN_EVERY if is_rare else min(max(2.0 * rest, WARN_EVERY), LONGEST_SILENCE))
        if len(self._logged) > MAX_REMEMBERED:
            del self._logged[next(iter(self._logged))]
        return True

    def end_silence(self) -> None:
        """Let what is over now be told again after WARN_EVERY, if it comes again."""
        self._logged = {reason: (at, min(rest, WARN_EVERY))
                        for reason, (at, rest) in self._logged.items()}


class RateLimit:
    """Lets MAX_REASONS lines by within WARN_EVERY, whatever they say: what is new each time."""

    def __init__(self):
        self._times = collections.deque(maxlen=MAX_REASONS)

    def allows(self, now: float) -> bool:
        """Return whether to log a line at steady time `now` [s]; it then counts as logged."""
        if len(self._times) == MAX_REASONS and now - self._times[0] < WARN_EVERY:
            return False
        self._times.append(now)
        return True


class Waiting:
    """
    Logs what a node waits for once it has waited for `patience` [s], and when that ends.

    Once a wait; if something else is missing meanwhile, that too: whoever was to send may be gone.
    """

    def __init__(self, patience: float = LOG_WAIT_AFTER):
        self._patience = patience
        self._since = None  # steady time at which the present wait began [s]
        self._served = 0
        self._logged = None  # (what was logged of this wait last, steady time of that [s])

    def look(self, missing: str, served: int, now: float) -> Entry | None:
        """
        Return what there is to log at steady time `now` [s], or None.

        missing: what the node waits for, in words, '' for nothing. served: how many frames it has
        served so far; with every frame its patience begins anew.
        """
        entry = None
        has_served, self._served = served != self._served, served
        if has_served or not missing:
            if self._logged:
                ends = 'frames are served again' if has_served else 'nothing is missing any more'
                entry = Entry('info', f'{ends}, after {now - self._since:.1f} s')
            self._since = self._logged = None
        if missing and self._since is None:
            self._since = now
        elif missing:
            reason, at = self._logged or ('', self._since)
            if now - at >= self._patience and without_figures(missing) != reason:
                entry = Entry('warning', f'waiting for {now - self._since:.1f} s for {missing}')
                self._logged = without_figures(missing), now
        return entry
