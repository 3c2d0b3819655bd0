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

"""How exact the references themselves are, which says what they can rank."""
import functools

from flag_sim.cloth import Diverged
from flag_sim.cloth.mesh import resample
from flag_sim.declarations.making import cloth_of, hang_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import errors, summary, trials
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
import numpy as np

PLACE, NAME, SHARE = 1, 'convergence', 3.0
WINDOWS = 8
FIRST = 2
"""Windows that every study has, however short; of so many one is run on the refined grid too."""
COLUMNS = (16, 31, 61, 121)
MEASURES = {name: errors.MOTION[name] for name in ('rms_mm', 'worst_mm', 'rms_px')}
TENTH = 10.0  # an error is ranked where it is so many times the reference's own


def grids():
    """Return (rows, columns) of the reference and of its refinement."""
    rows, columns = trials.FINEST
    return trials.FINEST, (2 * rows - 1, 2 * columns - 1)


def batches(store):
    """Compare windows with coarser grids and half the step, and some with a finer grid."""
    finest, finer = grids()
    refined = 0

    def rows(number, grid, step=1.0, solver='symplectic'):
        return {f'{number}@{grid[1]}@{step}@{solver}': functools.partial(
            _row, store, number, grid, step, solver)}

    for number in range(WINDOWS):
        compared = {}
        for columns in COLUMNS:
            for solver in ('symplectic', 'seed'):
                grid = trials.with_grid(columns)['grid.rows'], columns
                compared |= rows(number, grid, solver=solver)
        yield Batch(f'window {number + 1}, on {finest[1]} x {finest[0]} nodes',
                    compared | rows(number, finest, 0.5), number < FIRST)
        if number + 1 >= FIRST * (refined + 1):
            yield Batch(f'window {refined + 1}, on {finer[1]} x {finer[0]} nodes',
                        rows(refined, finer))
            refined += 1


def _row(store, number, grid, step, solver):
    """Return the distance from the reference of a run on a grid with a part of its step."""
    own = trials.base_trials(store.folder)
    reference, window = own.reference, own.reference.window(number)
    safety = step * reference.settings['step_safety']
    settings = reference.grid(*grid, step_safety=safety, solver=solver)
    is_finer = grid == grids()[1]
    if is_finer:
        cloth = cloth_of(settings)
        cloth.place(resample(window.positions, *grid), resample(window.velocities, *grid))
    else:
        cloth = reference.start(window, settings)
    row = {'window': number, 'time_s': window.frame * reference.shot.dt, 'solver': solver,
           'columns': grid[1], 'step': step,
           'moved_mm': 1e3 * summary.rms(errors.distances(window.ends[0], window.positions))}
    try:
        reference.shot.play(cloth, window.frame, window.frame + 1)
    except Diverged:
        return row | dict.fromkeys(MEASURES)
    positions = cloth.positions[::2, ::2] if is_finer else reference.filled(cloth.positions)
    return row | errors.measured(MEASURES, positions, window.ends[0], own.camera)


def _of(rows, columns, step=1.0, solver='symplectic'):
    return [row for row in rows if (row['columns'], row['step'], row['solver'])
            == (columns, step, solver)]


def _total(rows, column, *which):
    return summary.total(_of(rows, *which), column)


def own_error(rows, column='rms_px'):
    """
    Return the references' own error in a column: that of step and of grid together.

    The grid's is the distance from the finer grid where that was run; otherwise the distance of
    the next coarser grid, which is more.
    """
    finest, finer = grids()
    grid = finer[1] if _of(rows, finer[1]) else COLUMNS[-1]
    return _total(rows, column, grid) + _total(rows, column, finest[1], 0.5)


def text(rows: list[dict]) -> str:
    """Return what the references are, and how exact."""
    finest, finer = grids()
    count = len(_of(rows, finest[1], 0.5))
    finer_by = (finest[1] - 1) // (trials.BASE['grid.columns'] - 1)
    lines = [[what, len(_of(rows, *which)), *(_total(rows, name, *which) for name in MEASURES)]
             for *which, what in (
                 *((columns, f'grid {columns} x {trials.with_grid(columns)["grid.rows"]}')
                   for columns in COLUMNS),
                 (finer[1], f'grid {finer[1]} x {finer[0]}: the refined grid'),
                 (finest[1], 0.5, 'the reference in half the step')) if _of(rows, *which)]
    own_mm, own_px = (own_error(rows, name) for name in ('rms_mm', 'rms_px'))
    moved = summary.rms([row['moved_mm'] for row in rows])
    coarse, fine = (_total(rows, 'rms_mm', columns) for columns in COLUMNS[-2:])
    how = ('measured on the refined grid' if _of(rows, finer[1]) else
           'taken as the distance of the next coarser grid, which is more than it is: the time '
           'did not suffice for the refined grid')
    head = ['compared with the reference', 'windows', *(one.title for one in MEASURES.values())]
    return f"""## How errors are measured, and how exact the reference is

Every run is compared with the same sheet on {finest[1]} x {finest[0]} nodes, {finer_by} times as
fine as the default, in **{count} windows of {1e3 * WINDOW:.0f} ms**: each starts from a state of
the reference, spread over a gusty shot of the default wind, and ends one frame later. In that time
the flag moves by {moved:.0f} mm (RMS). An error in pixels is the distance on the screen of the
default camera between where a point of the cloth is drawn and where the reference has it, at
all {finest[0] * finest[1]} nodes of the reference that are in the picture; grids between are
filled by their triangles. 'Worst' is the worst node.

{table(head, lines)}

The reference's own error is {own_mm:.2g} mm or **{own_px:.2g} px** (step and grid; the grid's
part is {how}). It ranks errors that are ten times as large: from **{TENTH * own_px:.2g} px**
up. Smaller errors in this report are true to about {own_px:.2g} px and stand there without
a rank: two of them that differ by less than twice that may be in either order.
Half the spacing, from {COLUMNS[-2]} to {COLUMNS[-1]} columns, divides the error by
{coarse / fine:.2g}: the folds in the free end are sharp, and a coarse sheet cannot have the shape
of a folded one."""


def plots(rows, folder):
    """Draw the error over the spacing of the nodes."""
    grids_run = [columns for columns in COLUMNS if _of(rows, columns)]
    spacing = 1e3 * hang_of(trials.BASE)[1] / (np.array(grids_run) - 1)
    with drawing.figure(folder / 'convergence.png') as (_, axes):
        for solver, style in (('symplectic', {'marker': 'o'}), ('seed', drawing.style('seed'))):
            axes.loglog(spacing, [_total(rows, 'rms_mm', columns, 1.0, solver)
                                  for columns in grids_run], label=solver, **style)
        finest = _total(rows, 'rms_mm', max(grids_run))
        for order, style in ((1, ':'), (2, '-.')):
            axes.loglog(spacing, finest * (spacing / spacing.min())**order, style,
                        color='0.6', label=f'order {order}')
        axes.axhline(own_error(rows, 'rms_mm'), color='0.4', ls='--',
                     label="the reference's own error")
        axes.set(xlabel='spacing of the nodes [mm]',
                 ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes.legend()
        drawing.plain(axes)
    return [('convergence.png', 'What a coarser grid of the same sheet costs within one frame.')]
