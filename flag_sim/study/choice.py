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

"""Which settings to take, of what they cost and how wrong they are; and how sure that is."""
import math
from typing import NamedTuple

import numpy as np

SURE = 2.0
"""Standard deviations by which a prediction is on the safe side: 1 of 40 fails if it is normal."""


class Option(NamedTuple):
    """Settings by name; cost of a frame [ms]; error [px] that other shots should stay below."""

    name: str
    cost_ms: float
    error_px: float


class Verdict(NamedTuple):
    """The option to take, and whether it keeps the budget of error and that of time."""

    option: Option
    is_accurate: bool
    is_fast: bool


def predicted(errors, others):
    """
    Return what the RMS error [px] of as many `others` windows should stay below.

    errors: [px] of windows of one shot; inf if one diverged. The mean of their squares is
    predicted for new windows with its standard deviation, the root of s2 (1 / n + 1 / others).
    """
    squares = np.square(errors)
    if not np.all(np.isfinite(squares)):
        return math.inf
    spread = np.std(squares, ddof=1) * math.sqrt(1.0 / len(squares) + 1.0 / others)
    return math.sqrt(np.mean(squares) + SURE * spread)


def choose(options, error_px, limit_ms):
    """
    Return the Verdict on a list of Options for budgets of error [px] and time [ms].

    The cheapest that keeps both; if none does, the most accurate that keeps the time; if none
    keeps the time, the cheapest. Raises ValueError for an empty list.
    """
    def verdict(option):
        return Verdict(option, option.error_px <= error_px, option.cost_ms <= limit_ms)

    if not options:
        raise ValueError('there is nothing to choose from')
    fast = [option for option in options if option.cost_ms <= limit_ms]
    good = [option for option in fast if option.error_px <= error_px]
    if good:
        return verdict(min(good, key=lambda option: option.cost_ms))
    if fast:
        return verdict(min(fast, key=lambda option: (option.error_px, option.cost_ms)))
    return verdict(min(options, key=lambda option: option.cost_ms))
