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

"""Part: how exact the references themselves are, which says what they can rank."""
from flag_sim.cloth import Diverged
from flag_sim.cloth.mesh import resample
from flag_sim.dials.settings import cloth_of, hang_of
from flag_sim.study import error, plots as drawing, report, scene, summary
from flag_sim.study.reference import WINDOW
import numpy as np

NAME = 'convergence'
SHARE = 3.0
WINDOWS = 8
FIRST = 2
"""Windows that every study has, however short; of so many one is run on the refined grid too."""
COLUMNS = (16, 31, 61, 121)
TENTH = 10.0
"""An error is ranked where it is so many times the reference's own."""


def grids():
    """Return (rows, columns) of the reference and of its refinement."""
    rows, columns = scene.FINEST
    return scene.FINEST, (2 * rows - 1, 2 * columns - 1)


def run(store, budget):
    """Make windows; compare each with coarser grids, half the step, and one with a finer grid."""
    finest, finer = grids()
    refined = 0
    for number in range(WINDOWS):
        if number >= FIRST and not budget.allows():
            return
        budget.say(f'window {number + 1}, on {finest[1]} x {finest[0]} nodes')
        _compare(store, number)
        if number + 1 >= FIRST * (refined + 1) and budget.allows():
            budget.say(f'window {refined + 1}, on {finer[1]} x {finer[0]} nodes')
            _add(store, refined, finer, 1.0)
            refined += 1


def _compare(store, number):
    scene.trials(store.folder).reference.window(number)
    for columns in COLUMNS:
        for solver in ('symplectic', 'seed'):
            _add(store, number, (scene.with_grid(columns)['grid.rows'], columns), 1.0, solver)
    _add(store, number, scene.FINEST, 0.5)


def _add(store, number, grid, step, solver='symplectic'):
    """Add the distance from the reference of a run on a grid with a part of its step."""
    key = f'{number}@{grid[1]}@{step}@{solver}'
    if store.has(NAME, key):
        return
    own = scene.trials(store.folder)
    reference, window = own.reference, own.reference.window(number)
    safety = step * reference.settings['step_safety']
    settings = reference.grid(*grid, step_safety=safety, solver=solver)
    is_finer = grid == grids()[1]
    if is_finer:
        cloth = cloth_of(settings)
        cloth.place(resample(window.positions, *grid), resample(window.velocities, *grid))
    else:
        cloth = reference.start(window, settings)
    row = {'key': key, 'window': number, 'time_s': window.frame * reference.shot.dt,
           'solver': solver, 'columns': grid[1], 'step': step,
           'moved_mm': 1e3 * error.rms(error.distances(window.ends[0], window.positions)),
           'rms_mm': None, 'worst_mm': None, 'rms_px': None}
    try:
        reference.shot.play(cloth, window.frame, window.frame + 1)
    except Diverged:
        store.add(NAME, row)
        return
    positions = cloth.positions[::2, ::2] if is_finer else reference.filled(cloth.positions)
    metres = error.distances(positions, window.ends[0])
    pixels = error.pixel_distances(positions, window.ends[0], own.camera)
    row.update(rms_mm=1e3 * error.rms(metres), worst_mm=1e3 * float(metres.max()),
               rms_px=error.rms(pixels))
    store.add(NAME, row)


def _order(rows):
    """Return in words how fast the error falls with the spacing."""
    coarse, fine = (error.rms([row['rms_mm'] for row in _of(rows, columns)])
                    for columns in COLUMNS[-2:])
    return (f'Half the spacing, from {COLUMNS[-2]} to {COLUMNS[-1]} columns, divides the error by '
            f'{coarse / fine:.2g}: the folds in\nthe free end are sharp, and a coarse sheet '
            'cannot have the shape of a folded one.\n')


def _of(rows, columns, step=1.0, solver='symplectic'):
    return [row for row in rows if (row['columns'], row['step'], row['solver'])
            == (columns, step, solver)]


def own_error(rows, column='rms_px'):
    """
    Return the references' own error in a column: that of step and of grid together.

    The grid's is the distance from the finer grid where that was run; otherwise the distance of
    the next coarser grid, which is more.
    """
    finest, finer = grids()
    grid = _of(rows, finer[1]) or _of(rows, COLUMNS[-1])
    step = _of(rows, finest[1], 0.5)
    return error.rms([row[column] for row in grid]) + error.rms([row[column] for row in step])


def section(rows):
    """Return what the references are, and how exact."""
    finest, finer = grids()
    count = len(_of(rows, finest[1], 0.5))
    finer_by = (finest[1] - 1) // (scene.BASE['grid.columns'] - 1)
    table = []
    for columns, step, what in (
            *((columns, 1.0, f'grid {columns} x {scene.with_grid(columns)["grid.rows"]}')
              for columns in COLUMNS),
            (finer[1], 1.0, f'grid {finer[1]} x {finer[0]}: the refined grid'),
            (finest[1], 0.5, 'the reference in half the step')):
        some = _of(rows, columns, step)
        if some:
            table.append([what, len(some), *(error.rms([row[name] for row in some])
                                             for name in ('rms_mm', 'worst_mm', 'rms_px'))])
    own_mm, own_px = (own_error(rows, name) for name in ('rms_mm', 'rms_px'))
    moved = error.rms([row['moved_mm'] for row in rows])
    how = ('measured on the refined grid' if _of(rows, finer[1]) else
           'taken as the distance of the next coarser grid, which is more than it is: the time '
           'did not suffice for the refined grid')
    return f"""## How errors are measured, and how exact the reference is

Every run is compared with the same sheet on {finest[1]} x {finest[0]} nodes, {finer_by} times as
fine as the default, in **{count} windows of {1e3 * WINDOW:.0f} ms**: each starts from a state of
the reference, spread over a gusty shot of the default wind, and ends one frame later. In that time
the flag moves by {moved:.0f} mm (RMS). An error in pixels is the distance on the screen of the
default camera between where a point of the cloth is drawn and where the reference has it, at
all {finest[0] * finest[1]} nodes of the reference that are in the picture; grids between are
filled by their triangles. 'Worst' is the worst node.

{report.table(['compared with the reference', 'windows', 'RMS mm', 'worst mm', 'RMS px'], table)}

The reference's own error is {own_mm:.2g} mm or **{own_px:.2g} px** (step and grid; the grid's
part is {how}). It ranks errors that are ten times as large: from **{TENTH * own_px:.2g} px**
up. Smaller errors in this report are true to about {own_px:.2g} px and stand there without
a rank: two of them that differ by less than twice that may be in either order.
{_order(rows)}"""


def plots(rows, folder):
    """Draw the error over the spacing of the nodes."""
    grids = {columns: error.rms([row['rms_mm'] for row in _of(rows, columns)])
             for columns in COLUMNS if _of(rows, columns)}
    spacing = 1e3 * hang_of(scene.BASE)[1] / (np.array(list(grids)) - 1)
    with drawing.figure(folder / 'convergence.png') as (_, axes):
        axes.loglog(spacing, list(grids.values()), 'o-', label='symplectic')
        seed = [summary.total(_of(rows, columns, solver='seed'), 'rms_mm') for columns in grids]
        axes.loglog(spacing, seed, label='seed', **drawing.style('seed'))
        for order, style in ((1, ':'), (2, '-.')):
            axes.loglog(spacing, grids[max(grids)] * (spacing / spacing.min())**order, style,
                        color='0.6', label=f'order {order}')
        axes.axhline(own_error(rows, 'rms_mm'), color='0.4', ls='--',
                     label="the reference's own error")
        axes.set(xlabel='spacing of the nodes [mm]',
                 ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [mm]')
        axes.legend()
        drawing.plain(axes)
    return [('convergence.png', 'What a coarser grid of the same sheet costs within one frame.')]
