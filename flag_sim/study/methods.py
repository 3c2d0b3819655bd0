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

"""Part: each method of the steps on one grid, against an exact motion of that same grid."""
import math
import time

from flag_sim.cloth import Diverged
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.dials.settings import cloth_of
from flag_sim.study import error, plots as drawing, report, scene, summary
from flag_sim.study.reference import WINDOW
from flag_sim.study.settings import changed

NAME = 'methods'
SHARE = 1.5
EXACT = {'solver': 'rk4', 'step_safety': 0.05}
STEPS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512)
"""Steps a frame that are tried, from the fewest that are stable on."""
SHOWN = 64
"""Steps a frame up to which the table goes in any case."""
UNDAMPED = 'symplectic, damping 0'


def kinds():
    """Return {name: changes} of what is compared."""
    return {**{name: {'solver': name} for name in SOLVERS},
            UNDAMPED: {'solver': 'symplectic', 'damping': 0.0}}


def run(store, budget):
    """Run every method with every number of steps through window after window."""
    own = scene.trials(store.folder)
    for number in scene.windows(store):
        if number and not budget.allows():
            return
        budget.say(f'window {number + 1}')
        window = own.reference.window(number)
        exact = None
        for name, changes in {'exact': {**EXACT, 'step_safety': 0.1}, **kinds()}.items():
            settings = changed(scene.BASE, {'step_safety': 1.0, **changes})
            fewest = cloth_of(settings).advance(own.reference.shot.dt).demanded
            counts = [0] if name == 'exact' else _counts(SOLVERS[settings['solver']], fewest)
            for count in counts:
                # A method without a limit may take fewer steps than it would choose.
                steps = {'substeps': count, 'substeps_limit': count or 10**6}
                key = f'{name}@{count}@{number}'
                if store.has(NAME, key):
                    continue
                if exact is None:
                    exact = _run(own, changed(scene.BASE, EXACT), window)
                row = _run(own, changed(settings, steps), window)
                store.add(NAME, {'key': key, 'method': name, 'steps': count or row['steps'],
                                 'turn': number, **_compared(row, exact, own.camera)})


def _counts(solver, fewest):
    """Return the numbers of steps to try: the fewest stable, then STEPS above."""
    if math.isfinite(solver.useful_step):
        fewest = 1
    return [fewest] + [count for count in STEPS if count > 1.2 * fewest]


def _run(own, settings, window):
    """Return where a run is after each frame of a window, and what a frame costs."""
    shot = own.reference.shot
    own.reference.start(window, settings).advance(1e-6)  # compiles
    cloth = own.reference.start(window, settings)
    ends, times, steps = [], [], None
    for frame in range(window.frame + 1, window.frame + scene.LONG + 1):
        begin = time.perf_counter()
        try:
            steps = cloth.advance(shot.dt, shot.wind(frame)).granted
        except Diverged:
            return {'ends': None, 'ms': None, 'steps': steps}
        times.append(1e3 * (time.perf_counter() - begin))
        ends.append(cloth.positions)
    return {'ends': ends, 'ms': sorted(times)[1], 'steps': steps}


def _compared(row, exact, camera):
    if row['ends'] is None:
        return dict.fromkeys(('rms_mm', 'worst_mm', 'rms_px', 'long_rms_mm', 'physics_ms'))
    first, last = (error.distances(row['ends'][k], exact['ends'][k]) for k in (0, -1))
    pixels = error.pixel_distances(row['ends'][0], exact['ends'][0], camera)
    return {'rms_mm': 1e3 * error.rms(first), 'worst_mm': 1e3 * float(first.max()),
            'rms_px': error.rms(pixels), 'long_rms_mm': 1e3 * error.rms(last),
            'physics_ms': row['ms']}


def _own_error(rows):
    """
    Return the error [mm] of the exact motion itself.

    Where 'exact', at twice its step, is at a distance, it is itself at a fifteenth of that, its
    order being 4 (Richardson).
    """
    return summary.total([row for row in rows if row['method'] == 'exact'], 'rms_mm') / 15.0


def section(rows):
    """Return which method is worth its time, and what is wrong with the source's scheme."""
    own = _own_error(rows)
    rows = summary.whole([row for row in rows if row['method'] != 'exact'], 'method', 'steps')
    groups = summary.grouped(rows, 'method', 'steps')
    fewest = {}
    for name, count in groups:
        fewest[name] = min(count, fewest.get(name, count))
    table = [[name, count, summary.milliseconds(some, 'physics_ms'),
              *(summary.total(some, column) for column in ('rms_mm', 'rms_px', 'long_rms_mm'))]
             for (name, count), some in groups.items()
             if name != UNDAMPED and count <= max(4 * fewest[name], SHOWN)]
    windows = len(summary.grouped(rows, 'turn'))
    return f"""## Methods and steps

All on the default grid, against the motion of that same grid in very small steps
(`{EXACT['solver']}` at a twentieth of its largest step, exact to {own:.1g} mm): so these are
errors of time alone. They start where the windows start. The fewest steps that are stable, and
up to four times as many or {SHOWN}, in {windows} windows:

{report.table(['method', 'steps a frame', 'ms a frame', 'RMS mm', 'RMS px',
               f'RMS mm after {1e3 * scene.LONG * WINDOW:.0f} ms'], table)}

{_seed(groups)}
"""


def _seed(groups):
    """Explain the source's scheme by its error beside symplectic's at the same steps."""
    table = []
    for count in sorted({count for name, count in groups if name == 'seed'}):
        if ('symplectic', count) in groups:
            table.append([count, *(summary.total(groups[name, count], 'long_rms_mm')
                                   for name in ('seed', 'symplectic', UNDAMPED)
                                   if (name, count) in groups)])
    table = [row for row in table if len(row) == 4]
    return f"""### The scheme of the source text

`seed` follows the source's equations to the letter. They are the symplectic method's but for one
thing: x = x0 + v (1.10) keeps the velocity in metres **per step**, and the forces that depend on
velocity, the dashpots and the relative wind, are given this number where metres per second are
meant. At n steps a frame they are therefore 30 n times too weak, whatever the step. So the
error of `seed` does not vanish with the step, as symplectic's does: it goes to a motion without
dashpots and without the drag of the cloth's own speed. RMS mm after
{1e3 * scene.LONG * WINDOW:.0f} ms:

{report.table(['steps a frame', 'seed', 'symplectic', 'symplectic without dashpots'], table)}

The last column has the relative wind, but no dashpots: what it lacks to `seed` is the relative
wind's share."""


def plots(rows, folder):
    """Draw error over cost and over steps for every method."""
    own = _own_error(rows)
    rows = summary.whole([row for row in rows if row['method'] not in ('exact', UNDAMPED)],
                         'method', 'steps')
    with drawing.figure(folder / 'methods.png', columns=2) as (_, axes):
        for name, some in summary.grouped(rows, 'method').items():
            points = []
            for count, more in summary.grouped(some, 'steps').items():
                times = summary.quartiles(more, 'physics_ms')
                found = summary.total(more, 'rms_mm')
                if times and 10.0 * own <= found < math.inf:
                    points.append((count, times[1], found))
            points.sort()
            if points:
                counts, times, errors = zip(*points)
                style = drawing.style(name)
                axes[0].loglog(counts, errors, label=name, **style)
                axes[1].loglog(times, errors, label=name, **style)
        axes[0].set(xlabel='steps a frame of 1/30 s',
                    ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes[1].set(xlabel='time of a frame [ms]',
                    ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes[0].legend()
    return [('methods.png', "Each method's error by its steps (left) and by its cost (right), on "
                            'the default grid. `seed` stays where it is: its error is not one of '
                            'the step.')]
