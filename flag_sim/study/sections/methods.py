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
from collections.abc import Iterator
import functools
import math
from pathlib import Path

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.factories import cloth_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import summary, trials
from flag_sim.study.measures.errors import measured, MOTION
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.measures.settings import changed
from flag_sim.study.measures.summary import Rows
from flag_sim.study.report import median_and_quartiles, table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 2, 'methods', 1.5
EXACT = {'solver': 'rk4', 'step_safety': 0.05}
STEPS = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512)
"""Steps a frame that are tried, from the fewest that are stable on."""
SHOWN = 64  # steps a frame up to which the table goes in any case
UNDAMPED = 'symplectic, damping 0'
MEASURES = {name: MOTION[name] for name in ('rms_mm', 'worst_mm', 'rms_px')}


def runs():
    """Return {(name, steps a frame): settings} of every method; the exact one, twice as coarse."""
    found = {('exact', 0): changed(trials.BASE, {**EXACT, 'step_safety': 0.1})}
    for name, changes in {**{name: {'solver': name} for name in SOLVERS},
                          UNDAMPED: {'solver': 'symplectic', 'damping': 0.0}}.items():
        settings = changed(trials.BASE, {'step_safety': 1.0, **changes})
        fewest = cloth_of(settings).advance(1.0 / settings['rate']).demanded
        if math.isfinite(SOLVERS[settings['solver']].useful_step):
            fewest = 1  # a method without a limit may take fewer steps than it would choose
        for count in [fewest] + [count for count in STEPS if count > 1.2 * fewest]:
            found[name, count] = changed(settings, {'substeps': count, 'substeps_limit': count})
    return found


def batches(store: Store) -> Iterator[Batch]:
    """Run every method with every number of steps through window after window."""
    settings, base = runs(), trials.base_trials(store.folder)

    def run(settings, number):
        return base.run(settings, base.reference.window(number), trials.LONG)[:2]

    exact = functools.cache(lambda number: run(changed(trials.BASE, EXACT), number)[0])

    def measure(method, steps, turn):
        ends, times = run(settings[method, steps], turn)
        if len(ends) < trials.LONG:
            return dict.fromkeys((*MEASURES, 'long_rms_mm', 'physics_ms'))
        return {**measured(MEASURES, ends[0], exact(turn)[0], base.camera),
                'long_rms_mm': MOTION['rms_mm'].of(ends[-1], exact(turn)[-1], base.camera),
                'physics_ms': sorted(times)[1]}

    for number in trials.window_numbers(store.folder):
        yield Batch(f'window {number + 1}', [
            {'method': name, 'steps': count, 'turn': number} for name, count in settings],
            measure, number == 0)


def _own_error(rows):
    """
    Return the error [mm] of the exact motion itself.

    Where 'exact', at twice its step, is at a distance, it is itself at a fifteenth of that, its
    order being 4 (Richardson).
    """
    return summary.total([row for row in rows if row['method'] == 'exact'], 'rms_mm') / 15.0


def _groups(rows):
    """Return {(method, steps): rows} of the turns that all took, without the exact motion."""
    return summary.grouped(summary.complete(
        [row for row in rows if row['method'] != 'exact'], 'method', 'steps'), 'method', 'steps')


def text(rows: Rows) -> str:
    """Return which method is worth its time, and what is wrong with the source's scheme."""
    groups = _groups(rows)
    fewest = {name: min(count for one, count in groups if one == name) for name, _ in groups}
    lines = [[name, count, *median_and_quartiles(summary.quartiles(some, 'physics_ms')),
              *(summary.total(some, column) for column in ('rms_mm', 'rms_px', 'long_rms_mm'))]
             for (name, count), some in groups.items()
             if name != UNDAMPED and count <= max(4 * fewest[name], SHOWN)]
    long_ms = 1e3 * trials.LONG * WINDOW
    compared = ('seed', 'symplectic', UNDAMPED)
    seed = [[count, *(summary.total(groups[name, count], 'long_rms_mm') for name in compared)]
            for count in sorted({count for name, count in groups if name == 'seed'})
            if all((name, count) in groups for name in compared)]
    head = ['method', 'steps a frame', 'ms a frame', 'quartiles', 'RMS mm', 'RMS px']
    return f"""## Methods and steps

All on the default grid, against the motion of that same grid in very small steps
(`{EXACT['solver']}` at a twentieth of its largest step, exact to {_own_error(rows):.1g} mm): so
these are errors of time alone. They start where the windows start. The fewest steps that are
stable, and up to four times as many or {SHOWN}, in {len(next(iter(groups.values())))} windows:

{table([*head, f'RMS mm after {long_ms:.0f} ms'], lines)}

### The scheme of the source text

`seed` follows the source's equations exactly as published. They are the symplectic method's but
for one thing: x = x0 + v (eq. 1.10) keeps the velocity in metres **per step**, and the forces that
depend on velocity, the dashpots and the relative wind, are given this number where metres per
second are meant. At n steps a frame they are therefore 30 n times too weak, whatever the step. So
the error of `seed` does not vanish with the step, as symplectic's does: it goes to a motion
without dashpots and without the drag of the cloth's own speed. RMS mm after
{long_ms:.0f} ms:

{table(['steps a frame', 'seed', 'symplectic', 'symplectic without dashpots'], seed)}

The last column has the relative wind, but no dashpots: its difference from `seed` is due to
the relative wind."""


def plots(rows: Rows, folder: Path) -> Iterator[tuple[str, str]]:
    """Draw error over cost and over steps for every method."""
    least, curves = 10.0 * _own_error(rows), {}
    for (name, count), some in _groups(rows).items():
        times, found = summary.quartiles(some, 'physics_ms'), summary.total(some, 'rms_mm')
        if name != UNDAMPED and times and least <= found < math.inf:
            curves.setdefault(name, []).append((count, times[1], found))
    with drawing.figure(folder / 'methods.png', columns=2) as (_, axes):
        for name, points in curves.items():
            counts, times, errors = zip(*sorted(points))
            for axis, at in zip(axes, (counts, times)):
                axis.loglog(at, errors, label=name, **drawing.solver_style(name))
        for axis, label in zip(axes, ('steps a frame of 1/30 s', 'time of a frame [ms]')):
            axis.set(xlabel=label, ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes[0].legend()
    yield 'methods.png', (
        "Each method's error by its steps (left) and by its cost (right), on the default grid. "
        '`seed` stays where it is: its error is not one of the step.')
