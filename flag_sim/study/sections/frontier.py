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

"""The parameters together: the whole pipeline's cost against its error, and the frontier."""
from collections.abc import Iterator
import itertools
import math
from pathlib import Path

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.study import plots as drawing
from flag_sim.study.measures import summary, trials
from flag_sim.study.measures.errors import MEASURES, PICTURE
from flag_sim.study.measures.reference import WINDOW
from flag_sim.study.measures.summary import Rows
from flag_sim.study.report import median_and_quartiles, table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import sweep
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 6, 'frontier', 2.0
TURNS = 5
COLUMNS = (7, 13, 16, 25, 31, 61, 121)
PICTURES = {'4 samples': {'samples': 4}, '320 x 240': {'width': 320, 'height': 240}}
"""Other pictures than the default's; they are tried with symplectic steps."""
HIGHLIGHT = '#ffe48a'  # colour of the frontier: no method's


def methods():
    """Return {name: changes}: how to take the steps of a frame; for 'softened' see settings."""
    return {
        **{name: {'solver': name} for name in SOLVERS if name != 'xpbd'},
        'symplectic float32': {'precision': 'float32'},
        **{f'xpbd {count} steps': {'solver': 'xpbd', 'substeps': count, 'substeps_limit': count}
           for count in (5, 20, 80)},
        'softened': {},
    }


def settings():
    """Return {name: settings} of combinations of grid, method and picture."""
    found = {}
    for columns, (name, changes) in itertools.product(COLUMNS, methods().items()):
        if name == 'softened':
            # Half of what symplectic asks for at its safety: a quarter of the stiffness.
            changes = {'substeps_limit': max(1, round(1.1 * columns))}
        found[f'{columns} {name}'] = trials.with_grid(columns, **changes)
    return found | {f'{columns} symplectic, {name}': trials.with_grid(columns, **changes)
                    for columns, (name, changes) in itertools.product(COLUMNS, PICTURES.items())}


def batches(store: Store) -> Iterator[Batch]:
    """Run every combination through the windows, again and again."""
    return sweep.batches(store, settings(), _measured, list(range(sweep.FIRST)) * TURNS)


def _measured(base, settings, window):
    return base.row(settings, window, {'psnr_db': PICTURE['psnr_db']})


def summarised(rows):
    """
    Return the numbers of every combination.

    Errors are those of the windows that every study has, so that they do not depend on its
    length; more turns take more times.
    """
    return sweep.summarised(rows, sweep.FIRST)


def points(rows, column='rms_px'):
    """Return {name: (cost [ms], column)} of what did not diverge."""
    return {name: (one['cost_ms'][1], one[column]) for name, one in summarised(rows).items()
            if one['cost_ms'] and math.isfinite(one['rms_px'])}


def best(rows, column='rms_px'):
    """
    Return the names on the frontier of cost and a column, by their cost.

    PSNR counts as the root mean square of the colours' errors that it stands for. Error in pixels
    of another picture would be in other pixels: only motions are compared by it.
    """
    at = points(rows, column)
    if column == 'psnr_db':
        at = {name: (cost, 10.0**(-value / 20.0)) for name, (cost, value) in at.items()}
    else:
        at = {name: point for name, point in at.items() if ',' not in name}
    return [list(at)[index] for index in summary.frontier(
        list(at.values()), summary.resolution(rows))]


def text(rows: Rows) -> str:
    """Return the frontier as a table."""
    found = summarised(rows)
    default = found[_default()]
    columns = ('rms_px', 'worst_px', 'psnr_db')

    def frontier(column):
        return table(
            ['settings', 'ms a frame', 'quartiles', *(MEASURES[name].title for name in columns),
             ''],
            [[name, *median_and_quartiles(found[name]['cost_ms']),
              *(found[name][one] for one in columns), sweep.rank(found[name], rows)]
             for name in best(rows, column)])
    return f"""## The frontier

{len(found)} combinations of grid (its columns), method and picture; the cost is that of
physics and drawing of one frame, one after the other, without messages. On the frontier are those
that no other beats in both cost and error after {1e3 * WINDOW:.0f} ms, and that lower the error
by a tenth or more. Costs less than {100 * summary.resolution(rows):.1f} % apart count as one: so
much do the medians of two equal settings differ in 1 of 20 pairs, by the scatter of this run's
own times. {sweep.noise(rows)}

**The defaults ({_default()}): {default['cost_ms'][1]:.2g} ms a frame
({default['cost_ms'][0]:.2g} to {default['cost_ms'][2]:.2g}), {default['rms_px']:.2g} px (RMS after
{1e3 * WINDOW:.0f} ms, in the first {sweep.FIRST} windows of the gusty shot), PSNR
{default['psnr_db']:.3g} dB.**

{frontier('rms_px')}

'softened' is symplectic with `substeps_limit` at half the steps that it asks for or less, which
lowers the stiffness to a quarter or less.

The same for the picture as a whole (PSNR against the reference's picture), other pictures
included:

{frontier('psnr_db')}
"""


def plots(rows: Rows, folder: Path) -> Iterator[tuple[str, str]]:
    """Draw all combinations and the frontier, for pixels and for the picture."""
    with drawing.figure(folder / 'frontier.png', columns=2, size=(7.0, 5.7)) as (figure, axes):
        for axis, column, title, label in (
                (axes[0], 'rms_px', 'error of the vertices: lower left is better',
                 f'RMS error after {1e3 * WINDOW:.0f} ms [px]'),
                (axes[1], 'psnr_db', 'likeness of the picture: upper left is better',
                 'PSNR of the picture [dB]')):
            at = points(rows, column)
            for method in (*methods(), *(f'symplectic, {name}' for name in PICTURES)):
                some = [point for name, point in at.items() if name.split(' ', 1)[1] == method]
                if some and (axis is axes[1] or ',' not in method):
                    axis.plot(*zip(*some), label=method, **_style(method))
            axis.plot(*zip(*(at[name] for name in best(rows, column))), color=HIGHLIGHT, lw=9,
                      zorder=0, label='frontier')
            axis.plot(*at[_default()], 'o', ms=13, mfc='none', mec='black', mew=1.5, ls='none',
                      label='the defaults')
            axis.set(xscale='log', xlabel='time of a frame, physics and drawing [ms]',
                     ylabel=label, title=title)
        axes[0].set_yscale('log')
        own = sweep.own_error(rows)
        axes[0].axhline(own, color='0.6', ls=':')
        axes[0].text(axes[0].get_xlim()[0], own, " the reference's own error", va='bottom')
        figure.legend(*axes[1].get_legend_handles_labels(), loc='outside lower center', ncols=5,
                      frameon=False)
        drawing.decimal_ticks(*axes)
    yield 'frontier.png', (
        'The whole pipeline: cost of a frame against what is wrong in it, in pixels (left, less '
        'is better) and as a picture (right, more is better). Along each line the grid grows from '
        f'{COLUMNS[0]} to {COLUMNS[-1]} columns; the circle is the defaults. A point that is '
        'missing diverged; other pictures are on the right only.')


def _default():
    """Return the name of the combination that is the defaults."""
    return f'{trials.BASE["grid.columns"]} {trials.BASE["solver"]}'


def _style(method):
    """Return the solver's style, varied by what else the method is."""
    solver, _, rest = method.replace(',', ' ').partition(' ')
    style = drawing.solver_style(solver)
    if 'steps' in rest:
        style['alpha'] = {'5': 0.4, '20': 0.7}.get(rest.split()[0], 1.0)
    if 'float32' in rest:
        style.update(ls='-.', mfc='none')
    if ',' in method:
        style.update(alpha=0.6, ls=':', marker='x' if 'samples' in rest else '+', ms=7)
    return style
