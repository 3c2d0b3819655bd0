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

"""What the study measures on: one shot, one camera, and the windows of its reference."""
import functools

from flag_sim.study.reference import FINEST, nested, on_grid, Reference
from flag_sim.study.settings import changed, defaults
from flag_sim.study.trial import Trials

BASE = defaults(gust__intensity=0.3)
"""The defaults of all dials, in gusty wind: in a steady one all windows would be much alike."""
LONG = 3
"""Frames of a window, 0.1 s; errors are ranked after the first of them."""


@functools.lru_cache(maxsize=1)
def trials(folder):
    """Return the Trials of a study in a folder."""
    return Trials(Reference(BASE, LONG, folder / 'windows', FINEST), BASE)


def finer():
    """Return BASE on the grid that is twice as fine."""
    return with_grid(2 * BASE['grid.columns'] - 1)


def coarser():
    """Return BASE on the grid that is half as fine."""
    return with_grid((BASE['grid.columns'] + 1) // 2)


def windows(store):
    """Return the numbers of the windows that are there, one after the other."""
    reference = trials(store.folder).reference
    found = []
    while reference.has(len(found)):
        found.append(len(found))
    return found


def with_grid(columns, **changes):
    """Return BASE for the same sheet on the nested grid of so many columns, otherwise changed."""
    (rows,) = [rows for rows, count in nested(FINEST) if count == columns]
    return changed(on_grid(BASE, rows, columns), changes)
