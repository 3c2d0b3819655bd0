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

"""A sweep: many settings run through window after window, and the rows that come of it."""
from flag_sim.study.measures import summary, trials
from flag_sim.study.measures.errors import MEASURES
from flag_sim.study.measures.summary import COST
from flag_sim.study.runner import Batch
from flag_sim.study.sections import convergence

FIRST = 2  # turns that even the shortest study takes


def batches(store, settings, measure, numbers):
    """
    Yield a Batch for every turn, of a row for every one of settings {name: settings}.

    numbers: of the turns' windows. All settings take a turn before any takes the next, so that a
    disturbance of the machine hits all alike. measure(trials, settings, window) gives the numbers
    of a row.
    """
    base = trials.base_trials(store.folder)
    own_px = convergence.own_error(store.rows(convergence.NAME))

    def row(setting, turn, window):
        del turn
        return {**measure(base, settings[setting], base.reference.window(window)),
                'own_px': own_px}

    for turn, number in enumerate(numbers):
        yield Batch(f'{len(settings)} settings, turn {turn + 1}', [
            {'setting': name, 'turn': turn, 'window': number} for name in settings],
            row, turn < FIRST)


def summarised(rows, turns=None):
    """
    Return {setting: numbers} over the turns that all settings took, their times leveled.

    cost_ms, physics_ms, drawing_ms: (lower quartile, median, upper quartile), the first of both
    together; None if it always diverged. MEASURES: over the first `turns`, or all.
    """
    return {name: {'cost_ms': summary.quartiles(some, *COST),
                   **{column: summary.quartiles(some, column) for column in COST},
                   **{column: one.over_windows(some[:turns], column)
                      for column, one in MEASURES.items() if column in some[0]}}
            for name, some in summary.grouped(summary.leveled(rows), 'setting').items()}


def own_error(rows):
    """Return the least of the reference's own errors [px] that were known."""
    return min(row['own_px'] for row in rows)


def rank(numbers, rows):
    """Return in words whether the error of one of summarised can be ranked."""
    return '' if numbers['rms_px'] >= convergence.RANKED * own_error(rows) else 'below rank'


def noise(rows):
    """Return in words how far times spread."""
    found = [summary.quartiles(some, *COST) for some in summary.grouped(
        summary.complete(rows, 'setting'), 'setting').values()]
    wide = sorted((one[2] - one[0]) / one[1] for one in found if one)
    typical = wide[len(wide) // 2]
    if typical <= 0.15:
        return (f'Times are medians over the windows, all settings in turn, cleared of what is '
                f'common to a turn; before, their quartiles are {100 * typical:.0f} % apart in '
                'the median setting.')
    return (f'**The machine was noisy: the quartiles of the times are {100 * typical:.0f} % apart '
            'in the median setting.** Compare only times that differ by more.')
