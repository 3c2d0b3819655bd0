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
from flag_sim.study import convergence, summary
from flag_sim.study.scene import trials, windows

COST = ('physics_ms', 'drawing_ms')


def run(store, budget, part, settings):
    """
    Add a row to a part for every window and every one of settings {name: settings}.

    All settings take a window before any takes the next: so times are taken interleaved, and a
    disturbance of the machine hits all alike.
    """
    own = trials(store.folder)
    for number in windows(store):
        if number and not budget.allows():
            return
        budget.say(f'{len(settings)} settings in window {number + 1}')
        window = own.reference.window(number)
        for name, one in settings.items():
            key = f'{name}@{number}'
            if not store.has(part, key):
                store.add(part, {'key': key, 'setting': name, 'window': number,
                                 **own.whole(one, window), 'own_px': own_px(store)})


def own_px(store):
    """Return the reference's own error [px] as far as it is known."""
    return convergence.own_error(store.rows(convergence.NAME))


def summarised(rows):
    """
    Return {setting: numbers} over the windows that all settings took.

    cost_ms: (lower quartile, median, upper quartile) of physics and drawing; None if it always
    diverged. rms_px, rms_mm: over windows; worst_px: of all; psnr_db and the like: means.
    """
    found = {}
    for name, some in summary.grouped(summary.whole(rows, 'setting'), 'setting').items():
        found[name] = {
            'cost_ms': summary.quartiles(some, *COST),
            **{f'{column}_q': summary.quartiles(some, column) for column in COST},
            **{column: summary.total(some, column) for column in ('rms_mm', 'rms_px')},
            **{column: summary.worst(some, column) for column in ('worst_mm', 'worst_px')},
            **{column: summary.mean(some, column) for column in (
                'psnr_db', 'ssim', 'drawing_psnr_db', 'drawing_ssim', 'substeps', 'stiffness')}}
    return found


def own_of(rows):
    """Return the least of the reference's own errors [px] that were known."""
    return min(row['own_px'] for row in rows)


def noise(rows):
    """Say in words how far times spread, None where they are quiet."""
    wide = [(high - low) / middle for low, middle, high in (
        one['cost_ms'] for one in summarised(rows).values() if one['cost_ms'])]
    wide.sort()
    typical = wide[len(wide) // 2]
    if typical <= 0.15:
        return (f'Times are medians over the windows, all settings in turn; their quartiles are '
                f'{100 * typical:.0f} % apart in the median setting.')
    return (f'**The machine was noisy: the quartiles of the times are {100 * typical:.0f} % apart '
            'in the median setting.** Compare only times that differ by more.')
