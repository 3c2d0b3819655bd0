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
from collections.abc import Iterator
import functools
import itertools
from pathlib import Path

from flag_sim.cloth import Diverged
from flag_sim.declarations.factories import hang_of
from flag_sim.study import plots as drawing
from flag_sim.study.measures import errors, summary, trials
from flag_sim.study.measures.reference import on_grid, WINDOW
from flag_sim.study.measures.summary import Rows
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store
import numpy as np

PLACE, NAME, SHARE = 1, 'convergence', 3.0
WINDOWS = 8
FIRST = 2
"""Windows that every study has, however short; of so many one is run on the refined grid too."""
COLUMNS = (16, 31, 61, 121)
MEASURES = {name: errors.MOTION[name] for name in ('rms_mm', 'worst_mm', 'rms_px')}
RANKED = 10.0  # an error is ranked where it is so many times the reference's own


def finest_columns():
    """Return the columns of the reference and of its refinement."""
    return trials.FINEST[1], 2 * trials.FINEST[1] - 1


def batches(store: Store) -> Iterator[Batch]:
    """Compare windows with coarser grids and half the step, and some with a finer grid."""
    finest, finer = finest_columns()
    measure = functools.partial(_measured, store.folder)

    def case(number, columns, step=1.0, solver='symplectic'):
        return {'window': number, 'columns': columns, 'step': step, 'solver': solver}

    def grid(columns):
        return f'on {columns} x {trials.rows_for(columns)} nodes'

    for number in range(WINDOWS):
        cases = [case(number, columns, solver=solver) for columns, solver in
                 itertools.product(COLUMNS, ('symplectic', 'seed'))]
        yield Batch(f'window {number + 1}, {grid(finest)}', [*cases, case(number, finest, 0.5)],
                    measure, number < FIRST)
        refined, later = divmod(number + 1, FIRST)
        if not later:
            yield Batch(f'window {refined}, {grid(finer)}', [case(refined - 1, finer)], measure)


def _measured(folder, window, columns, step, solver):
    """Return the distance from the reference of a run on a grid with a part of its step."""
    base = trials.base_trials(folder)
    reference, start = base.reference, base.reference.window(window)
    cloth = reference.start(start, on_grid(
        reference.settings, trials.rows_for(columns), columns, solver=solver,
        step_safety=step * reference.settings['step_safety']))
    row = {'time_s': start.frame * reference.shot.dt,
           'moved_mm': 1e3 * summary.rms(errors.distances(start.ends[0], start.positions))}
    try:
        reference.shot.play(cloth, start.frame, start.frame + 1)
    except Diverged:
        return row | dict.fromkeys(MEASURES)
    return row | errors.measured(MEASURES, reference.on_finest(cloth.positions), start.ends[0],
                                 base.camera)


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
    finest, finer = finest_columns()
    grid = finer if _of(rows, finer) else COLUMNS[-1]
    return _total(rows, column, grid) + _total(rows, column, finest, 0.5)


def text(rows: Rows) -> str:
    """Return what the references are, and how exact."""
    finest, finer = finest_columns()
    grids = {columns: f'{columns} x {trials.rows_for(columns)}'
             for columns in (*COLUMNS, finer, finest)}
    lines = [[what, len(_of(rows, *which)), *(_total(rows, name, *which) for name in MEASURES)]
             for *which, what in (
                 *((columns, f'grid {grids[columns]}') for columns in COLUMNS),
                 (finer, f'grid {grids[finer]}: the refined grid'),
                 (finest, 0.5, 'the reference in half the step')) if _of(rows, *which)]
    own_mm, own_px = (own_error(rows, name) for name in ('rms_mm', 'rms_px'))
    moved = summary.rms([row['moved_mm'] for row in rows])
    coarse, fine = (_total(rows, 'rms_mm', columns) for columns in COLUMNS[-2:])
    how = ('measured on the refined grid' if _of(rows, finer) else
           'taken as the distance of the next coarser grid, which is more than it is: there was '
           'not enough time for the refined grid')
    head = ['compared with the reference', 'windows', *(one.title for one in MEASURES.values())]
    return f"""## How errors are measured, and how exact the reference is

Every run is compared with the same sheet on {grids[finest]} nodes,
{(finest - 1) // (trials.BASE['grid.columns'] - 1)} times as
fine as the default, in **{len(_of(rows, finest, 0.5))} windows of {1e3 * WINDOW:.0f} ms**: each
starts from a state of the reference, spread over a gusty shot of the default wind, and ends one
frame later. In that time the flag moves by {moved:.0f} mm (RMS). An error in pixels is the
distance on the screen of the default camera between where a point of the cloth is drawn and where
the reference has it, at all {np.prod(trials.FINEST)} nodes of the reference that are in the
picture; coarser grids are filled by their triangles. 'Worst' is the worst node.

{table(head, lines)}

The reference's own error is {own_mm:.2g} mm or **{own_px:.2g} px** (step and grid; the grid's
part is {how}). It ranks errors that are ten times as large: from **{RANKED * own_px:.2g} px**
up. Smaller errors in this report are true to about {own_px:.2g} px and stand there without
a rank: two of them that differ by less than twice that may be in either order.
Half the spacing, from {COLUMNS[-2]} to {COLUMNS[-1]} columns, divides the error by
{coarse / fine:.2g}: the folds in the free end are sharp, and a coarse sheet cannot have the shape
of a folded one."""


def plots(rows: Rows, folder: Path) -> Iterator[tuple[str, str]]:
    """Draw the error over the spacing of the nodes."""
    grids_run = [columns for columns in COLUMNS if _of(rows, columns)]
    spacing = 1e3 * hang_of(trials.BASE)[1] / (np.array(grids_run) - 1)
    with drawing.figure(folder / 'convergence.png') as (_, axes):
        for solver in ('symplectic', 'seed'):
            axes.loglog(spacing, [_total(rows, 'rms_mm', columns, 1.0, solver)
                                  for columns in grids_run], label=solver,
                        **drawing.solver_style(solver))
        finest = _total(rows, 'rms_mm', max(grids_run))
        for order, style in ((1, ':'), (2, '-.')):
            axes.loglog(spacing, finest * (spacing / spacing.min())**order, style,
                        color='0.6', label=f'order {order}')
        axes.axhline(own_error(rows, 'rms_mm'), color='0.4', ls='--',
                     label="the reference's own error")
        axes.set(xlabel='spacing of the nodes [mm]',
                 ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes.legend()
        drawing.decimal_ticks(axes)
    yield 'convergence.png', ('The error that a coarser grid of the same sheet makes within one '
                              'frame, over its spacing; finer grids are on the left.')
