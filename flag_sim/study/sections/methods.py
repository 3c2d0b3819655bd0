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

"""Each method of the steps on one grid, against an exact motion of that same grid."""
import functools
import math

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.making import cloth_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import summary, trials
from flag_sim.study.measures.errors import measured, MOTION
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.measures.settings import changed
from flag_sim.study.report import table
from flag_sim.study.runner import Batch

PLACE, NAME, SHARE = 2, 'methods', 1.5
EXACT = {'solver': 'rk4', 'step_safety': 0.05}
STEPS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512)
"""Steps a frame that are tried, from the fewest that are stable on."""
SHOWN = 64  # steps a frame up to which the table goes in any case
UNDAMPED = 'symplectic, damping 0'
MEASURES = {name: MOTION[name] for name in ('rms_mm', 'worst_mm', 'rms_px')}


def runs():
    """Yield (name, settings) of every method with every number of steps, the exact one first."""
    yield 'exact', 0, changed(trials.BASE, {**EXACT, 'step_safety': 0.1})
    for name, changes in {**{name: {'solver': name} for name in SOLVERS},
                          UNDAMPED: {'solver': 'symplectic', 'damping': 0.0}}.items():
        settings = changed(trials.BASE, {'step_safety': 1.0, **changes})
        fewest = cloth_of(settings).advance(1.0 / settings['rate']).demanded
        if math.isfinite(SOLVERS[settings['solver']].useful_step):
            fewest = 1  # a method without a limit may take fewer steps than it would choose
        for count in [fewest] + [count for count in STEPS if count > 1.2 * fewest]:
            yield name, count, changed(settings, {'substeps': count, 'substeps_limit': count})


def batches(store):
    """Run every method with every number of steps through window after window."""
    methods = list(runs())
    for number in trials.windows(store.folder):
        exact = functools.cache(lambda number=number: _run(
            store, changed(trials.BASE, EXACT), number)[0])
        yield Batch(f'window {number + 1}', {
            f'{name}@{count}@{number}': functools.partial(
                _row, store, name, count, settings, number, exact)
            for name, count, settings in methods}, number == 0)


def _run(store, settings, number):
    """Return where a run is after each frame of a window, their times [ms] and steps."""
    own = trials.base_trials(store.folder)
    window = own.reference.window(number)
    cloth = own.start(settings, window)
    ends, times, steps = [], [], None
    for taken, time in own.reference.shot.timed(cloth, window.frame, window.frame + trials.LONG):
        ends.append(cloth.positions)
        times.append(time)
        steps = taken.granted
    return ends, times, steps


def _row(store, name, count, settings, number, exact):
    """Return the numbers of a run, None where it diverged."""
    ends, times, steps = _run(store, settings, number)
    row = {'method': name, 'steps': count or steps, 'turn': number}
    if len(ends) < trials.LONG:
        return row | dict.fromkeys((*MEASURES, 'long_rms_mm', 'physics_ms'))
    camera = trials.base_trials(store.folder).camera
    after = measured({'long_rms_mm': MOTION['rms_mm']}, ends[-1], exact()[-1], camera)
    return {**row, **measured(MEASURES, ends[0], exact()[0], camera), **after,
            'physics_ms': sorted(times)[1]}


def _own_error(rows):
    """
    Return the error [mm] of the exact motion itself.

    Where 'exact', at twice its step, is at a distance, it is itself at a fifteenth of that, its
    order being 4 (Richardson).
    """
    return summary.total([row for row in rows if row['method'] == 'exact'], 'rms_mm') / 15.0


def text(rows: list[dict]) -> str:
    """Return which method is worth its time, and what is wrong with the source's scheme."""
    own = _own_error(rows)
    rows = summary.whole([row for row in rows if row['method'] != 'exact'], 'method', 'steps')
    groups = summary.grouped(rows, 'method', 'steps')
    fewest = {}
    for name, count in groups:
        fewest[name] = min(count, fewest.get(name, count))
    lines = [[name, count, summary.milliseconds(some, 'physics_ms'),
              *(summary.total(some, column) for column in ('rms_mm', 'rms_px', 'long_rms_mm'))]
             for (name, count), some in groups.items()
             if name != UNDAMPED and count <= max(4 * fewest[name], SHOWN)]
    long_ms = 1e3 * trials.LONG * WINDOW
    compared = ('seed', 'symplectic', UNDAMPED)
    seed = [[count, *(summary.total(groups[name, count], 'long_rms_mm') for name in compared)]
            for count in sorted({count for name, count in groups if name == 'seed'})
            if all((name, count) in groups for name in compared)]
    head = ['method', 'steps a frame', 'ms a frame', 'RMS mm', 'RMS px']
    return f"""## Methods and steps

All on the default grid, against the motion of that same grid in very small steps
(`{EXACT['solver']}` at a twentieth of its largest step, exact to {own:.1g} mm): so these are
errors of time alone. They start where the windows start. The fewest steps that are stable, and
up to four times as many or {SHOWN}, in {len(summary.grouped(rows, 'turn'))} windows:

{table([*head, f'RMS mm after {long_ms:.0f} ms'], lines)}

### The scheme of the source text

`seed` follows the source's equations to the letter. They are the symplectic method's but for one
thing: x = x0 + v (1.10) keeps the velocity in metres **per step**, and the forces that depend on
velocity, the dashpots and the relative wind, are given this number where metres per second are
meant. At n steps a frame they are therefore 30 n times too weak, whatever the step. So the
error of `seed` does not vanish with the step, as symplectic's does: it goes to a motion without
dashpots and without the drag of the cloth's own speed. RMS mm after
{long_ms:.0f} ms:

{table(['steps a frame', 'seed', 'symplectic', 'symplectic without dashpots'], seed)}

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
                times, found = summary.quartiles(more, 'physics_ms'), summary.total(more, 'rms_mm')
                if times and 10.0 * own <= found < math.inf:
                    points.append((count, times[1], found))
            if points:
                counts, times, errors = zip(*sorted(points))
                for axis, at in zip(axes, (counts, times)):
                    axis.loglog(at, errors, label=name, **drawing.style(name))
        for axis, label in zip(axes, ('steps a frame of 1/30 s', 'time of a frame [ms]')):
            axis.set(xlabel=label, ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes[0].legend()
    return [('methods.png', "Each method's error by its steps (left) and by its cost (right), on "
                            'the default grid. `seed` stays where it is: its error is not one of '
                            'the step.')]
