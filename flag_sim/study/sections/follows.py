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

"""Every method on every grid: what a frame costs, and how long it follows the reference."""
from collections.abc import Iterator
import functools
import math
from pathlib import Path

from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.factories import cloth_of, look_of
from flag_sim.study.measures import follows, ranking, summary
from flag_sim.study.measures.judge import Judge, OTHER_GUSTS
from flag_sim.study.measures.reference import on_grid
from flag_sim.study.measures.settings import changed, defaults, Settings
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import own_errors
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 2, 'follows', 3.0
BASE = defaults(gust__intensity=0.3)
"""The defaults, in gusty wind: in a steady one all windows would be much alike."""
DEFAULT = f'{BASE["grid.columns"]} {BASE["solver"]}'
"""Name of the defaults among the settings."""
FINEST = (161, 241)
"""Rows and columns of the reference: all nodes of all settings are among its nodes."""
COLUMNS = (13, 16, 25, 31, 49, 61)
FEWER = 31  # columns up to which other methods are tried than the default's
SOFT = 'softened'
SOFTENED = 0.7  # of the steps that are asked for: half of the stiffness
SHOWN = 3  # pairs of settings in another order that are named
TURNS = 6
REQUIRED = 4  # turns that even the shortest study takes
GUSTS = (0, OTHER_GUSTS)  # added to gust.seed, turn by turn
SIDE = {'camera.azimuth': -0.4}  # of the second camera, which looks at the flag's end
RANKED_AT, PROMISED_AT = follows.HORIZONS[1:3]
"""
After how long errors are ranked, and after how long users ask for them [s].

Later than the first, references are wrong by more than a fifth of what settings differ by.
"""
RANKED, PROMISED = (f'px_{seconds:.2g}' for seconds in (RANKED_AT, PROMISED_AT))


def methods(others: bool = False) -> dict[str, Settings]:
    """Return {name: changes}: of methods for use, or of the others."""
    counted = {f'{name} 10': {'solver': name, 'substeps': 10, 'substeps_limit': 10}
               for name in ('implicit', 'xpbd')}
    used = {'symplectic': {}, 'symplectic float32': {'precision': 'float32'},
            'verlet': {'solver': 'verlet'}, **counted}
    if not others:
        return used
    left = [name for name in SOLVERS if name not in [one.partition(' ')[0] for one in used]]
    return {SOFT: None, **{name: {'solver': name} for name in left}}


def settings() -> dict[str, Settings]:
    """Return {name: settings} of all methods and grids, each name beginning with the columns."""
    found = {}
    for columns in COLUMNS:
        rows = (columns - 1) * (BASE['grid.rows'] - 1) // (BASE['grid.columns'] - 1) + 1
        for name, changes in {**methods(), **methods(True)}.items():
            if columns > FEWER and (changes is None or changes.get('solver')):
                continue
            own = on_grid(BASE, rows, columns, **(changes or {}))
            if changes is None:
                asked = cloth_of(own).advance(1.0 / BASE['rate']).demanded
                own = changed(own, {'substeps_limit': max(1, round(SOFTENED * asked))})
            found[f'{columns} {name}'] = own
    return found


@functools.lru_cache(maxsize=1)
def judge(folder: Path) -> Judge:
    """Return the Judge of a study in a folder, on BASE."""
    return Judge(BASE, folder, others={'side_': look_of(changed(BASE, SIDE)).camera},
                 finest=FINEST)


def moment(turn: int) -> tuple[int, int]:
    """Return the window and the gusts of a turn."""
    return turn // len(GUSTS), GUSTS[turn % len(GUSTS)]


def batches(store: Store) -> Iterator[Batch]:
    """Run all settings through window after window, so that what disturbs hits all alike."""
    one, own = judge(store.folder), settings()
    drawing = functools.cache(lambda name: one.drawing_ms(own[name]))

    def measured(setting, turn, gusts):
        return {**one.follow(own[setting], moment(turn)[0], gusts),
                'drawing_ms': drawing(setting)}

    for turn in range(TURNS):
        yield Batch(f'{len(own)} settings, turn {turn + 1} of {TURNS}', [
            {'setting': name, 'turn': turn, 'gusts': moment(turn)[1]} for name in own],
            measured, turn < REQUIRED)


def errors(rows: summary.Rows, column: str = RANKED) -> dict[str, float]:
    """Return {setting: RMS error [px]} in a column, inf where one diverged."""
    return {name: summary.total(some, column)
            for name, some in summary.grouped(rows, 'setting').items()}


def costs(rows: summary.Rows) -> dict[str, float]:
    """Return {setting: median processor time of a frame [ms]}, inf where all diverged."""
    found = {name: summary.quartiles(some, *summary.COST)
             for name, some in summary.grouped(summary.leveled(rows), 'setting').items()}
    return {name: one[1] if one else math.inf for name, one in found.items()}


def best(rows: summary.Rows, least: float = 0.0) -> list[str]:
    """Return the settings of the frontier of cost and RANKED, by cost: see ranking.frontier."""
    cost, error = costs(rows), errors(rows)
    names = [name for name in error if math.isfinite(error[name])]
    return [names[i] for i in ranking.frontier(
        [(cost[name], error[name]) for name in names], summary.resolution(rows), least)]


def rankings(rows: summary.Rows) -> dict[str, tuple[dict, dict]]:
    """Return {what differs: two rankings {setting: error}} of all settings but diverged ones."""
    pairs = {
        'two seeds of the gusts': [errors([row for row in rows if row['gusts'] == gusts])
                                   for gusts in GUSTS],
        'two cameras': [errors(rows, column) for column in (RANKED, f'side_{RANKED}')],
        'the moments of a short study and all': [
            errors([row for row in rows if row['turn'] < REQUIRED]), errors(rows)]}
    found = {}
    for what, pair in pairs.items():
        names = [name for name in pair[0] if all(
            math.isfinite(one.get(name, math.inf)) for one in pair)]
        found[what] = tuple({name: one[name] for name in names} for one in pair)
    return found


def agreement(rows: summary.Rows, least: float) -> str:
    """Return in words where the order of settings agrees, and where it does not."""
    words = []
    for what, (one, other) in rankings(rows).items():
        tau = ranking.kendall(*(list(some.values()) for some in (one, other)), least)
        swapped = [f'{a} and {b}' for a, b in ranking.reversed_pairs(one, other, least)]
        words.append(f'{"all are tied" if tau is None else f"{tau:.2f}"} between {what}' + (
            f' (reversed: {", ".join(swapped[:SHOWN])}'
            f'{f" and {len(swapped) - SHOWN} more" if len(swapped) > SHOWN else ""})'
            if swapped else ' (none is reversed, some are tied in one)'
            if tau is not None and tau < 1.0 else ''))
    return ', '.join(words)


def text(store: Store) -> str:
    """Return the errors of the frontier at each horizon, and of the defaults."""
    rows = store.rows(NAME)
    if not rows:
        return ''
    rows = summary.complete(rows, 'setting')
    least = own_errors.least_px(store, RANKED)
    cost, names = costs(rows), best(rows, least)
    columns = judge(store.folder).columns
    by_column = {column: errors(rows, column) for column in columns}
    place = ranking.ranks({name: error for name, error in by_column[RANKED].items()
                           if math.isfinite(error)}, least)
    lines = [[name, cost[name], *(by_column[column][name] for column in columns),
              place.get(name)]
             for name in sorted({*names, *_of_default_method(cost)}, key=cost.get)]
    own = [own_errors.own_px(store, column) for column in columns]
    lines.append(["the reference's own error", None, *own, None])
    titles = [f'px after {seconds:.2g} s' for seconds in judge(store.folder).horizons]
    return f"""## Follows: how far off, and for how long

RMS error of the vertices in pixels of the camera, a while after the flag and the reference were in
the same state; over {len(summary.grouped(rows, 'turn'))} moments of two gusty shots. **It applies
to what must be right frame by frame, for as long as that is possible at all.** Of
{len(by_column[RANKED])} settings (columns of the grid, method), those of the default method, and
the frontier: none other is both cheaper and surely nearer after {RANKED_AT:g} s. Only what differs
by {ranking.FROM:g} times the reference's own error is ranked, by {least:.2g} px then; settings
that differ by less are tied. The rank: 1 + how many are surely nearer.

{table(['setting', 'ms a frame', *titles, 'rank'], lines)}

A method's number is that of its steps in a frame; 'softened' is symplectic with `substeps_limit`
at {100 * SOFTENED:g} % of the steps that it asks for, so with {100 * SOFTENED**2:.0f} % of the
stiffness: another sheet, which is compared with the reference of the stiff one, and may be nearer
on grids too coarse to fold as finely. On more than {FEWER} columns only the default's method was
tried. Costs less than {100.0 * summary.resolution(rows):.2g} % apart count as one, as times
scatter.
Order of errors then, with ties (Kendall's tau-b; 1 is the same order): of the frontier
{agreement([row for row in rows if row['setting'] in names], least)}; of all settings
{agreement(rows, least)}."""


def _of_default_method(cost):
    """Return the names of the settings of the default's method, on all grids."""
    return [name for name in cost if name.partition(' ')[2] == BASE['solver']]
