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

"""The horizon, where trajectories part and only statistics are left to compare."""
from collections.abc import Iterator
import functools
import math
from pathlib import Path

from flag_sim.study import plots as drawing
from flag_sim.study.measures import errors, summary, trials
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.measures.settings import changed
from flag_sim.study.measures.summary import Rows
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store
import numpy as np

PLACE, NAME, SHARE = 3, 'horizon', 1.0
FRAMES = 45
ROUNDING = 1e-9
"""Disturbance of the start [m]: a millionth of what can be seen, far above rounding errors."""
CURVES = {
    'rounding_mm': 'a start disturbed by a nanometre',
    'step_mm': 'half the step',
    'rk4_mm': 'rk4',
    'xpbd_mm': 'xpbd',
    'seed_mm': 'seed',
    'grid_mm': 'a grid twice as fine',
    'unrelated_mm': 'another window: unrelated states',
}


def batches(store: Store) -> Iterator[Batch]:
    """Let pairs of runs start from the same state and part."""
    for number in trials.window_numbers(store.folder):
        distances = functools.cache(functools.partial(_distances, store.folder, number))
        yield Batch(f'window {number + 1}', [
            {'window': number, 'frame': frame} for frame in range(1, FRAMES + 1)],
            functools.partial(_row, distances), number == 0)


def _row(distances, window, frame):
    del window
    return {'time_s': frame / trials.BASE['rate'],
            **{name: run[frame - 1] if frame <= len(run) else None
               for name, run in distances().items()}}


def _distances(folder, number):
    """Return {curve: RMS distances [mm] from the default run, of each frame while both last}."""
    base = trials.base_trials(folder)

    def ends(settings=trials.BASE, start=number, disturbance=0.0):
        return base.run(settings, base.reference.window(start), FRAMES, disturbance)[0]

    default = ends()
    noise = ROUNDING * np.random.default_rng(number).standard_normal(default[0].shape)
    runs = {
        'rounding_mm': ends(disturbance=noise),
        'step_mm': ends(changed(trials.BASE, {'step_safety': 0.45})),
        **{f'{name}_mm': ends(changed(trials.BASE, {'solver': name}))
           for name in ('rk4', 'xpbd', 'seed')},
        'grid_mm': [end[::2, ::2] for end in ends(trials.finer())],
        'unrelated_mm': ends(start=0) if number else [],
    }
    return {name: [1e3 * summary.rms(errors.distances(*pair)) for pair in zip(run, default)]
            for name, run in runs.items()}


def curves(rows):
    """Return {column: (times [s], geometric means over windows [mm])} where no run has ended."""
    found = {}
    for name in CURVES:
        points = []
        for time, some in summary.grouped(rows, 'time_s').items():
            values = [row[name] for row in some
                      if row[name] or (name != 'unrelated_mm' and row[name] is None)]
            if values and None not in values:
                points.append((time, math.exp(np.mean(np.log(values)))))
        if points:
            found[name] = tuple(zip(*points))
    return found


def growth(times, values, limit):
    """Return the rate [1/s] of exponential growth below a limit, by least squares."""
    some = [(time, math.log(value)) for time, value in zip(times, values) if value < limit]
    return float(np.polyfit(*zip(*some), 1)[0]) if len(some) > 2 else None


def text(rows: Rows) -> str:
    """Return when trajectories part, and so which measure counts when."""
    found = curves(rows)
    apart = found.pop('unrelated_mm', None)
    unrelated = float(np.median(apart[1])) if apart else None
    lines = [[CURVES[name], values[0], values[min(2, len(values) - 1)], values[-1],
              _reaches(times, values, unrelated)] for name, (times, values) in found.items()]
    rate = growth(*found['rounding_mm'], 1.0)
    double = '' if not rate or rate <= 0.0 else (
        f' A disturbance grows {math.exp(rate * 0.1):.2g} times in 0.1 s ({rate:.2g}/s): it '
        f'doubles every {1e3 * math.log(2.0) / rate:.0f} ms.')
    saturated = '' if unrelated is None else (
        f' Two states of the flag that have nothing to do with each other are {unrelated:.0f} mm '
        'apart (RMS).')
    head = ['run', '33 ms: mm', '100 ms: mm', f'{FRAMES / 30:.2g} s: mm',
            'a tenth of unrelated after']
    return f"""## The horizon

The flag's motion is chaotic.{double}{saturated} So how far two runs are apart tells of their
methods at first only; later it tells nothing, and they are both right if their statistics agree.
RMS distance from the default run on the default grid, from the same states of the reference,
over {len(summary.grouped(rows, 'window'))} windows:

{table(head, lines)}

Which measure applies when: **within {1e3 * WINDOW:.0f} ms** errors of trajectories, in mm and
px, as everywhere in this report where nothing else is said; **beyond the time in the last
column** only statistics, as in the next part.
"""


def _reaches(times, values, unrelated):
    """Return when a curve comes to a tenth of what unrelated states are apart, in words."""
    if unrelated is None:
        return None
    late = [time for time, value in zip(times, values) if value > 0.1 * unrelated]
    return f'{late[0]:.2f} s' if late else f'> {times[-1]:.2f} s'


def plots(rows: Rows, folder: Path) -> Iterator[tuple[str, str]]:
    """Draw how distances grow."""
    styles = {'seed_mm': {'color': 'black', 'ls': '--'},
              'unrelated_mm': {'color': '0.6', 'ls': ':'}}
    with drawing.figure(folder / 'horizon.png') as (_, axes):
        for name, (times, values) in curves(rows).items():
            axes.semilogy(times, values, label=CURVES[name], **styles.get(name, {}))
        axes.axvline(WINDOW, color='0.8', lw=6, zorder=0)
        axes.set(xlabel='time since the runs were in the same state [s]',
                 ylabel='RMS distance from the default run [mm]')
        axes.legend(fontsize='small')
    yield 'horizon.png', ('How trajectories part. The grey bar is where this report ranks errors; '
                          'where a curve is flat, nothing is left of the common start.')
