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

"""The first page: what to take, by all three measures, and their plots against the cost."""
from collections.abc import Iterator

from flag_sim.study import plots as drawing
from flag_sim.study.measures import behaves, rests, summary
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import follows, own_errors, references, sound
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 1, 'frontier', 0.0
MOST = 6  # rows of the table
WITHIN_PX = (20.0, 10.0, 5.0, 3.0)  # errors that a user may allow
SLOWEST_MS = 1e-3  # where the plots of what has no speed at all begin, in mm/s


def batches(store: Store) -> Iterator[Batch]:
    """Measure nothing: what is shown here is measured by the sections after it."""
    del store
    yield from ()


def text(store: Store) -> str:
    """Return the table of what to take."""
    rows = summary.complete(store.rows(follows.NAME), 'setting')
    known = {row['setting']: row for row in store.rows(sound.NAME)}
    # A softened sheet is not the one that the user asked for, and physics warns of it.
    good = {name for name, row in known.items()
            if sound.is_sound(row) and name.partition(' ')[2] != follows.SOFT}
    if not rows or not good:
        return ''
    cost, ranked, promised = follows.costs(rows), follows.errors(rows), follows.errors(
        rows, follows.PROMISED)

    def line(want, name):
        row = known[name]
        return [want, f'**{name}**', cost[name], ranked[name], promised[name], row['behaves'],
                row['rests']]

    own = own_errors.own_px(store, follows.PROMISED) or 0.0
    tied = min(ranked[name] for name in good) + own_errors.least_px(store, follows.RANKED)
    wanted = [('a flag that looks right, for least', good),
              *((f'within {allowed:g} px for {follows.PROMISED_AT:g} s',
                 {name for name in good if promised[name] + own <= allowed})
                for allowed in WITHIN_PX),
              ('as near as any that was tried, but for ties',
               {name for name in good if ranked[name] <= tied}),
              ('the nearest by the numbers', {min(good, key=ranked.get)})]
    lines = []
    for want, names in wanted:
        name = min(names, key=cost.get, default=None)
        if name and all(name not in one[1].split('**') for one in lines):
            lines.append(line(want, name))
    if follows.DEFAULT in known:
        words = '' if follows.DEFAULT in good else ', which does not behave or rest'
        what = line(f'to know what the defaults are{words}', follows.DEFAULT)
        lines = [*lines[:MOST - 1], [what[0], follows.DEFAULT, *what[2:]]]
    return f"""## If you want ..., take ...

{table(['if you want', 'take (columns of the grid, method)', 'ms a frame',
        f'follows: px after {follows.RANKED_AT:g} s', f'after {follows.PROMISED_AT:g} s',
        'behaves', 'rests: mm/s'], lines)}

Costs are processor time of a frame, physics and drawing. *Follows*: how far off a vertex is in the
picture, a while after both were in the same state. *Behaves*: how far its statistics are from
the reference's, in its own scatter (RMS); up to {behaves.WITHIN:g} is allowed. *Rests*: the
speed that is left in calm air; up to {rests.SLOW:g} mm/s is at rest. Nothing is recommended that
does not behave and rest, and within so many pixels is what still is with the reference's own
error added. {references.in_short(store)}"""


def plots(store: Store) -> Iterator[tuple[str, str]]:
    """Draw cost against each measure: methods for use above, the others below."""
    rows = summary.complete(store.rows(follows.NAME), 'setting')
    known = {row['setting']: row for row in store.rows(sound.NAME)}
    cost, error = follows.costs(rows), follows.errors(rows)
    panels = (
        ('follows', f'error after {follows.RANKED_AT:g} s [px]', error, None),
        ('behaves', "statistics' distance [own scatter]",
         {name: row['behaves'] for name, row in known.items()}, behaves.WITHIN),
        ('rests', 'speed in calm air [mm/s]',
         {name: max(row['rests'], SLOWEST_MS) for name, row in known.items()}, rests.SLOW))
    panels = [panel for panel in panels if len(panel[2]) > 1]
    with drawing.figure(store.folder / 'frontier.png', len(panels), 2, (4.6, 3.6), sharex=True,
                        sharey='col', squeeze=False) as (_, grid):
        for axes_of_row, others in zip(grid, (False, True)):
            for axes, (name, label, values, limit) in zip(axes_of_row, panels):
                for number, method in enumerate(follows.methods(others)):
                    _line(axes, method, drawing.LINES[number], cost, values, known)
                axes.set(xscale='log', yscale='log', ylabel=label, title=name)
                # Of methods that were not run for long there is nothing to see.
                axes.set_visible(any(len(line.get_xdata()) for line in axes.lines))
                axes.plot(cost[follows.DEFAULT], values.get(follows.DEFAULT, float('nan')), 's',
                          ms=15, mfc='none', mec='0.4')
                if limit:
                    axes.axhline(limit, color='0.6', lw=1)
            last = [axes for axes in axes_of_row if axes.get_visible()][-1:]
            for axes in last:
                axes.legend(*axes_of_row[0].get_legend_handles_labels(), fontsize='small')
        own = own_errors.own_px(store, follows.RANKED)
        if own:
            for axes in grid[:, 0]:
                axes.axhline(own, color='0.6', ls=':')
        for column in grid.T:
            for axes in [axes for axes in column if axes.get_visible()][-1:]:
                axes.set_xlabel('processor time of a frame [ms]')
                axes.tick_params(labelbottom=True)
        drawing.decimal_ticks(*grid.flat)
    yield 'frontier.png', (
        'Cost against each measure: lower left is better. Along a line the grid grows. Above: '
        'methods for use; below: the others. Hollow: does not behave or does not rest, or was not '
        'run for long; do not take it. Grey lines: what is allowed; dotted: the own error of the '
        'reference. The square is the defaults.')


def _line(axes, method, style, cost, values, known):
    """Draw a method's settings by their grids; full where they are sound."""
    names = [name for name in cost if name.partition(' ')[2] == method]
    finite = [name for name in names if 0.0 < values.get(name, 0.0) < float('inf')
              and cost[name] < float('inf')]
    if not finite:
        return
    axes.plot([cost[name] for name in finite], [values[name] for name in finite],
              label=method, mfc='none', **style)
    good = [name for name in finite if name in known and sound.is_sound(known[name])]
    axes.plot([cost[name] for name in good], [values[name] for name in good],
              **{**style, 'ls': 'none'})
