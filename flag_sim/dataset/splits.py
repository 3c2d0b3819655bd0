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

"""
Splits of a dataset: which clips are for training, and which are held out.

By clip, at random, in given shares; or by the value of a parameter, so that a network is tried
where it was never trained:

    splits: {train: 0.8, validation: 0.1, test: 0.1}
    splits: {by: wind.speed, train: [2.0, 12.0], test: [12.0, 14.0]}
"""
from collections.abc import Mapping
import dataclasses
import math
import re

from flag_sim.dataset.draws import Stream
from flag_sim.dataset.laws import Law
from flag_sim.dataset.marked_yaml import Marked
from flag_sim.parameters import checks

BY_CLIP = 'clip'
TOLERANCE = 1e-9
"""By how much shares may miss 1."""
MOST = 100
LONGEST_NAME = 64


@dataclasses.dataclass(frozen=True)
class Splits:
    """
    by: 'clip' or the name of a parameter; parts: {name of the split: (low, high)}.

    By clip low and high are parts of 1, one after another; else a clip whose value is at least
    low and below high is of that split, and at the upper end of all of the last.
    """

    by: str = BY_CLIP
    parts: tuple[tuple[str, float, float], ...] = (('train', 0.0, 1.0),)

    def of(self, stream: Stream, values: Mapping) -> str:
        """Return the split of a clip; stream: for this alone; values: {node.parameter: value}."""
        at = stream.unit() if self.by == BY_CLIP else values[self.by]
        for name, low, high in self.parts:
            if low <= at < high:
                return name
        return max(self.parts, key=lambda part: part[2])[0]


def check_name(name: str) -> None:
    """Raise ValueError for the name of a split that cannot name a file as well."""
    if not re.fullmatch(r'\w[\w.-]*', name) or len(name) > LONGEST_NAME:
        raise ValueError(f'the name of a split must be letters, digits, _, - and . (which is not '
                         f'the first), {LONGEST_NAME} at most, as it names files too; not '
                         f'{checks.shown(name)}')


def read_splits(marked: Marked, laws: Mapping[str, Law]) -> Splits:
    """
    Return a recipe's splits; laws: {node.parameter: Law} of its parameters.

    Raises MarkedError where shares are not 1 together, ranges leave a gap, overlap, or are not
    all that may be drawn, or a name cannot name a file.
    """
    entries = dict(marked.entries())
    by = entries.pop('by', None)
    if not 0 < len(entries) <= MOST:
        raise marked.error(f'splits must name from 1 to {MOST} splits, not {len(entries)}')
    for name, one in entries.items():
        try:
            check_name(name)
        except ValueError as error:
            raise one.error(error) from None
    if by is None or by.value == BY_CLIP:
        return _by_share(marked, entries)
    law = laws.get(by.value) if isinstance(by.value, str) else None
    if law is None or law.name in ('fixed', 'choice') or isinstance(law.values[0], list):
        raise by.error(f'splits by {by.plain()!r}: it must be clip, or a number that the recipe '
                       'draws from a range')
    parts = sorted((*_range(one), name) for name, one in entries.items())
    low, high = law.reach()
    ends = [(low, by.value), *((part[1], part[2]) for part in parts)]
    for (end, before), (begin, _, name) in zip(ends, parts):
        if begin != end:
            raise entries[name].error(
                f'splits: {name} must begin at {checks.text(end)}, where {before} '
                f'{"ends" if before != by.value else "begins"}, not at {checks.text(begin)}')
    if parts[-1][1] != high:
        _, end, name = parts[-1]
        raise entries[name].error(f'splits: {name} must end at {checks.text(high)}, where '
                                  f'{by.value} ends, not at {checks.text(end)}')
    return Splits(by.value, tuple((name, begin, end) for begin, end, name in parts))


def _by_share(marked, entries):
    shares = {name: one.checked(checks.finite, 0.0, 1.0) for name, one in entries.items()}
    total = math.fsum(shares.values())
    if abs(total - 1.0) > TOLERANCE:
        raise marked.error(f'splits must be 1 together, not {total:.12g}')
    parts, begin = [], 0.0
    for name, share in shares.items():
        parts.append((name, begin, begin + share))
        begin += share
    return Splits(BY_CLIP, tuple(parts))


def _range(marked):
    ends = [one.checked(checks.finite) for one in marked.items()]
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise marked.error(f'{marked.where} must be a range, [low, high], not {marked.plain()!r}')
    return ends
