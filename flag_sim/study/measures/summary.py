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

"""From the rows of many windows to one line: errors by their mean square, times by the median."""
import math

import numpy as np

Rows = list[dict]
"""Rows of measurements {column: value}, None where a run diverged."""

COST = ('physics_ms', 'drawing_ms')  # columns whose sum is what a frame costs
SIGNIFICANT = 2.0
"""Standard deviations by which two costs must differ to count as two: 1 of 20 pairs errs."""
QUARTILE = 0.6745  # of the standard normal distribution: half of all values are nearer to zero


def rms(values: np.ndarray) -> float:
    """Return the root mean square of an array."""
    return math.sqrt(float(np.mean(np.square(values))))


def grouped(rows: Rows, *columns: str) -> dict:
    """Return {value or tuple of values of some columns: rows}, in the order of the rows."""
    groups = {}
    for row in rows:
        key = tuple(row[column] for column in columns)
        groups.setdefault(key if len(columns) > 1 else key[0], []).append(row)
    return groups


def total(rows: Rows, column: str) -> float:
    """Return the root of the mean square of a column; inf where a run diverged."""
    values = [row[column] for row in rows]
    return math.inf if None in values else rms(values)


def quartiles(rows: Rows, *columns: str) -> tuple[float, float, float] | None:
    """Return (lower quartile, median, upper quartile) of the sum of some columns, None if none."""
    values = [sum(row[column] for column in columns) for row in rows
              if None not in [row[column] for column in columns]]
    return tuple(float(q) for q in np.percentile(values, (25, 50, 75))) if values else None


def complete(rows: Rows, *columns: str) -> Rows:
    """
    Return the rows of the turns in which every setting was run.

    columns: that name a setting. An interruption or the end of the time leaves the last turn
    with some settings only, which would otherwise be judged by other turns than the rest.
    """
    settings = set(grouped(rows, *columns))
    full = [turn for turn, some in grouped(rows, 'turn').items()
            if set(grouped(some, *columns)) == settings]
    return [row for row in rows if row['turn'] in full] if full else rows


def leveled(rows: Rows) -> Rows:
    """
    Return the rows of complete turns, their times cleared of what is common to a turn.

    A turn in which the machine was slow for all settings says nothing on their order.
    """
    rows = complete(rows, 'setting')
    logs = _log_costs(rows)
    if not len(logs):
        return rows
    common = np.exp(np.median(logs - np.median(logs, axis=1, keepdims=True), axis=0))
    factors = dict(zip(grouped(rows, 'turn'), common))
    return [{**row, **{column: row[column] and float(row[column] / factors[row['turn']])
                       for column in COST}} for row in rows]


def resolution(rows: Rows) -> float:
    """
    Return the part of a cost by which the medians of two settings must differ to be told apart.

    The logarithm of a time scatters by s from turn to turn, once the turns are leveled. So two
    turns of one setting differ by sqrt(2) s, in the median by QUARTILE times that, which a few
    disturbed frames do not move. A median of n turns has the standard error
    sqrt(pi / 2) s / sqrt(n), the difference of two medians sqrt(2) times that.
    """
    logs = _log_costs(leveled(rows))
    count = logs.shape[1]
    one, other = np.triu_indices(count, 1)
    if not len(one) * len(logs):
        return 0.0
    scatter = np.median(np.abs(logs[:, one] - logs[:, other])) / (QUARTILE * math.sqrt(2.0))
    return math.expm1(SIGNIFICANT * math.sqrt(math.pi / count) * scatter)


def _log_costs(rows):
    """Return logarithms of costs, (settings, turns), of the settings that never diverged."""
    found = [[sum(row[column] for column in COST) for row in some]
             for some in grouped(rows, 'setting').values()
             if not any(row[column] is None for row in some for column in COST)]
    return np.log(np.array(found).reshape(len(found), -1 if found else 0))
