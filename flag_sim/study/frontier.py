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

"""Part: the dials together: the whole pipeline's cost against its error, and the frontier."""
import itertools
import math

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.study import plots as drawing, report, summary, sweep
from flag_sim.study.reference import WINDOW
from flag_sim.study.scene import with_grid
from flag_sim.study.settings import changed

NAME = 'frontier'
SHARE = 2.0
COLUMNS = (7, 13, 16, 25, 31, 61, 121)
SAMPLES = (1, 4)


def methods():
    """Return {name: changes}: the ways to take the steps of a frame."""
    return {
        **{name: {'solver': name} for name in SOLVERS if name not in ('xpbd', 'euler')},
        **{f'xpbd {count} steps': {'solver': 'xpbd', 'substeps': count, 'substeps_limit': count}
           for count in (5, 20, 80)},
        'softened': {'substeps_limit': None},
    }


def settings():
    """Return {name: settings} of all combinations of grid, method and samples."""
    found = {}
    for columns, (name, changes), samples in itertools.product(
            COLUMNS, methods().items(), SAMPLES):
        changes = dict(changes)
        if name == 'softened':
            # Half of what symplectic asks for at its safety: a quarter of the stiffness.
            changes['substeps_limit'] = max(1, round(1.1 * columns))
        if not (columns == 121 and name == 'rk4'):
            found[f'{columns} {name}, {samples} samples'] = changed(
                with_grid(columns, **changes), {'samples': samples})
    return found


def run(store, budget):
    """Run every combination through window after window."""
    sweep.run(store, budget, NAME, settings())


def points(rows):
    """Return ([name], [(cost [ms], error [px])]) of what did not diverge."""
    found = {name: (one['cost_ms'][1], one['rms_px'])
             for name, one in sweep.summarised(rows).items()
             if one['cost_ms'] and math.isfinite(one['rms_px'])}
    return list(found), list(found.values())


def best(rows):
    """Return the names on the frontier of cost and error in pixels, by their cost."""
    names, at = points(rows)
    return [names[index] for index in summary.frontier(at)]


def section(rows):
    """Return the frontier as a table."""
    found = sweep.summarised(rows)
    own = sweep.own_of(rows)
    names, at = points(rows)
    table = []
    for name in best(rows):
        one = found[name]
        table.append([name, one['cost_ms'][1],
                      f'{one["cost_ms"][0]:.3g} to {one["cost_ms"][2]:.3g}', one['rms_px'],
                      one['worst_px'], one['psnr_db'], one['ssim'],
                      '' if one['rms_px'] >= 10.0 * own else 'below rank'])
    return f"""## The frontier

{len(found)} combinations of grid (its columns), method and samples a pixel; the cost is that of
physics and drawing of one frame, one after the other, without messages. On the frontier are those
that no other beats in both cost and error after {1e3 * WINDOW:.0f} ms. {sweep.noise(rows)}

{report.table(['settings', 'ms a frame', 'quartiles', 'RMS px', 'worst px', 'PSNR dB', 'SSIM',
               ''], table, 'lrlrrrrl')}
"""


def plots(rows, folder):
    """Draw all combinations and the frontier."""
    names, at = points(rows)
    edge = [at[index] for index in summary.frontier(at)]
    with drawing.figure(folder / 'frontier.png', size=(8.0, 5.5)) as (_, axes):
        for method in methods():
            some = sorted(point for name, point in zip(names, at)
                          if name.split(' ', 1)[1] == f'{method}, 1 samples')
            if some:
                look = drawing.style(method.split()[0])
                if ' steps' in method:
                    look['alpha'] = {'5': 0.4, '20': 0.7}.get(method.split()[1], 1.0)
                axes.loglog(*zip(*some), label=method, **look)
        axes.loglog(*zip(*edge), color='C3', lw=6, alpha=0.25, label='frontier')
        axes.axhline(sweep.own_of(rows), color='0.6', ls=':', label="reference's own error")
        axes.set(xlabel='time of a frame, physics and drawing [ms]',
                 ylabel=f'RMS error after {1e3 * WINDOW:.0f} ms [px]')
        axes.legend(fontsize='small')
    return [('frontier.png', 'The whole pipeline: cost of a frame against what is wrong in it. '
                             'Along each line the grid grows from 7 to 121 columns.')]
