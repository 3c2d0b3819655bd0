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

"""Part: the horizon, where trajectories part and only statistics are left to compare."""
import math

from flag_sim.cloth import Diverged
from flag_sim.study import error, plots as drawing, report, scene, summary
from flag_sim.study.reference import WINDOW
from flag_sim.study.settings import changed
import numpy as np

NAME = 'horizon'
SHARE = 1.0
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


def run(store, budget):
    """Let pairs of runs go on from the same state and part."""
    own = scene.trials(store.folder)
    for number in scene.windows(store):
        if number and not budget.allows():
            return
        if store.has(NAME, f'{number}@{FRAMES}'):
            continue
        budget.say(f'window {number + 1}')
        window = own.reference.window(number)
        columns = _distances(own.reference, window, own.reference.window(0), number)
        for frame in range(1, FRAMES + 1):
            if not store.has(NAME, f'{number}@{frame}'):
                store.add(NAME, {'key': f'{number}@{frame}', 'window': number, 'frame': frame,
                                 'time_s': frame * own.reference.shot.dt,
                                 **{name: values[frame - 1] for name, values in columns.items()}})


def _distances(reference, window, first, number):
    """Return {column: RMS distances [mm] from the default run, frame by frame}."""
    base = _play(reference, window, scene.BASE)
    source = np.random.default_rng(number)
    moved = _play(reference, window, scene.BASE,
                  ROUNDING * source.standard_normal(base[0].shape))
    runs = {
        'rounding_mm': moved,
        'step_mm': _play(reference, window, changed(scene.BASE, {'step_safety': 0.45})),
        **{f'{name}_mm': _play(reference, window, changed(scene.BASE, {'solver': name}))
           for name in ('rk4', 'xpbd', 'seed')},
        'grid_mm': [ends[::2, ::2] for ends in _play(reference, window, scene.finer())],
    }
    found = {name: _apart(run, base) for name, run in runs.items()}
    found['unrelated_mm'] = [None] * FRAMES if number == 0 else _apart(
        _play(reference, first, scene.BASE), base)
    return found


def _apart(run, base):
    """Return the RMS distances [mm] of two runs, None from where one of them has ended."""
    known = [1e3 * error.rms(error.distances(a, b)) for a, b in zip(run, base)]
    return known + [None] * (FRAMES - len(known))


def _play(reference, window, settings, disturbance=0.0):
    cloth = reference.start(window, settings)
    cloth.place(cloth.positions + disturbance, cloth.velocities)
    ends = []
    for frame in range(window.frame + 1, window.frame + FRAMES + 1):
        try:
            cloth.advance(reference.shot.dt, reference.shot.wind(frame))
        except Diverged:
            break
        ends.append(cloth.positions)
    return ends


def curves(rows):
    """Return {column: (times [s], geometric means over windows [mm])} where no run has ended."""
    found = {}
    for name in CURVES:
        points = []
        for time, some in summary.grouped(rows, 'time_s').items():
            values = [row[name] for row in some
                      if row[name] or (name != 'unrelated_mm' and row[name] is None)]
            if values and None not in values:
                points.append((time, math.exp(sum(map(math.log, values)) / len(values))))
        if points:
            found[name] = tuple(zip(*points))
    return found


def growth(times, values, limit):
    """Return the rate [1/s] of exponential growth below a limit, by least squares."""
    some = [(time, math.log(value)) for time, value in zip(times, values) if value < limit]
    return float(np.polyfit(*zip(*some), 1)[0]) if len(some) > 2 else None


def section(rows):
    """Return when trajectories part, and so which measure counts when."""
    found = curves(rows)
    apart = found.get('unrelated_mm')
    full = float(np.median(apart[1])) if apart else None
    table = []
    for name, (times, values) in found.items():
        if name != 'unrelated_mm':
            table.append([CURVES[name], values[0], values[min(2, len(values) - 1)], values[-1],
                          _reaches(times, values, full)])
    rate = growth(*found['rounding_mm'], 1.0)
    double = '' if not rate or rate <= 0.0 else (
        f' A disturbance grows {math.exp(rate * 0.1):.2g} times in 0.1 s ({rate:.2g}/s): it '
        f'doubles every {1e3 * math.log(2.0) / rate:.0f} ms.')
    saturated = '' if full is None else (
        f' Two states of the flag that have nothing to do with each other are {full:.0f} mm '
        'apart (RMS).')
    return f"""## The horizon

The flag's motion is chaotic.{double}{saturated} So how far two runs are apart tells of their
methods at first only; later it tells nothing, and they are both right if their statistics agree.
RMS distance from the default run on the default grid, from the same states of the reference,
over {len(summary.grouped(rows, 'window'))} windows:

{report.table(['run', '33 ms: mm', '100 ms: mm', f'{FRAMES / 30:.2g} s: mm',
               'a tenth of unrelated after'], table)}

Which measure applies when: **within {1e3 * WINDOW:.0f} ms** errors of trajectories, in mm and
px, as everywhere in this report where nothing else is said; **beyond the time in the last
column** only statistics, as in the next part.
"""


def _reaches(times, values, full):
    """Return when a curve comes to a tenth of what unrelated states are apart, in words."""
    if full is None:
        return None
    for time, value in zip(times, values):
        if value > 0.1 * full:
            return f'{time:.2f} s'
    return f'> {times[-1]:.2f} s'


def plots(rows, folder):
    """Draw how distances grow."""
    with drawing.figure(folder / 'horizon.png') as (_, axes):
        for name, (times, values) in curves(rows).items():
            style = {'color': 'black', 'ls': '--'} if name == 'seed_mm' else (
                {'color': '0.6', 'ls': ':'} if name == 'unrelated_mm' else {})
            axes.semilogy(times, values, label=CURVES[name], **style)
        axes.axvline(WINDOW, color='0.8', lw=6, zorder=0)
        axes.set(xlabel='time since the runs were in the same state [s]',
                 ylabel='RMS distance from the default run [mm]')
        axes.legend(fontsize='small')
    return [('horizon.png', 'How trajectories part. The grey bar is where this report ranks '
                            'errors; where a curve is flat, nothing is left of the common start.')]
