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
from flag_sim.study import convergence, scene, summary

COST = ('physics_ms', 'drawing_ms')
MEANS = ('psnr_db', 'ssim', 'drawing_psnr_db', 'drawing_ssim')
FIRST = 2
"""Turns that even the shortest study takes."""


def run(store, budget, part, settings, row_of, turns):
    """
    Add a row to a part for every turn and every one of settings {name: settings}.

    turns: numbers of the windows. All settings take a turn before any takes the next: so times
    are taken interleaved, and a disturbance of the machine hits all alike. The first FIRST turns
    are taken in any case. row_of(trials, settings, window) gives a row's numbers.
    """
    own = scene.trials(store.folder)
    for turn, number in enumerate(turns):
        if turn >= FIRST and not budget.allows():
            return
        budget.say(f'{len(settings)} settings, turn {turn + 1}')
        window = own.reference.window(number)
        for name, one in settings.items():
            key = f'{name}@{turn}'
            if not store.has(part, key):
                store.add(part, {'key': key, 'setting': name, 'turn': turn, 'window': number,
                                 **row_of(own, one, window), 'own_px': own_px(store)})


def own_px(store):
    """Return the reference's own error [px] as far as it is known."""
    return convergence.own_error(store.rows(convergence.NAME))


def summarised(rows, turns=None):
    """
    Return {setting: numbers} over the turns that all settings took, their times leveled.

    cost_ms, physics_ms, drawing_ms: (lower quartile, median, upper quartile), the first of both
    together; None if it always diverged. Of the first `turns`, or all: rms_px, rms_mm over them,
    worst_px and worst_mm of all, and means of the others.
    """
    found = {}
    for name, some in summary.grouped(_leveled(rows), 'setting').items():
        first = some[:turns]
        found[name] = {
            'cost_ms': summary.quartiles(some, *COST),
            **{column: summary.quartiles(some, column) for column in COST},
            **{column: summary.total(first, column) for column in ('rms_mm', 'rms_px')},
            **{column: summary.worst(first, column) for column in ('worst_mm', 'worst_px')},
            **{column: summary.mean(first, column) for column in MEANS if column in some[0]}}
    return found


def resolution(rows):
    """Return the part by which costs of a frame must differ to be told apart in these rows."""
    return summary.resolution(_leveled(rows), *COST)


def _leveled(rows):
    return summary.leveled(summary.whole(rows, 'setting'), *COST)


def own_of(rows):
    """Return the least of the reference's own errors [px] that were known."""
    return min(row['own_px'] for row in rows)


def noise(rows):
    """Return in words how far times spread."""
    found = [summary.quartiles(some, *COST) for some in summary.grouped(
        summary.whole(rows, 'setting'), 'setting').values()]
    wide = sorted((one[2] - one[0]) / one[1] for one in found if one)
    typical = wide[len(wide) // 2]
    if typical <= 0.15:
        return (f'Times are medians over the windows, all settings in turn, cleared of what is '
                f'common to a turn; before, their quartiles are {100 * typical:.0f} % apart in '
                'the median setting.')
    return (f'**The machine was noisy: the quartiles of the times are {100 * typical:.0f} % apart '
            'in the median setting.** Compare only times that differ by more.')
