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

"""How it was measured, and how exact the references are: what they can tell apart."""
from collections.abc import Iterator
import math

from flag_sim.study.measures import follows as horizons
from flag_sim.study.measures.behaves import scatter, STATISTICS
from flag_sim.study.measures.judge import EXACT, LENGTH, RUNS
from flag_sim.study.measures.reference import on_grid
from flag_sim.study.report import number, table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import follows
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 6, 'references', 3.0
STEP, GRID, COARSER, LONGER = WHAT = (
    'another method', 'a finer grid', 'a coarser grid', 'a finer grid, long')


def batches(store: Store) -> Iterator[Batch]:
    """Compare the references with more exact ones."""
    judge = follows.judge(store.folder)

    def measured(what):
        row = {**dict.fromkeys(judge.columns), 'horizon_s': None, 'behaves': None,
               'rests': None, 'sag_mm': None}
        if what in (STEP, GRID):
            grid = judge.finest if what == STEP else tuple(2 * n - 1 for n in judge.finest)
            solver = 'verlet' if what == STEP else EXACT['solver']
            exact = on_grid(judge.scene, *grid, **EXACT | {'solver': solver})
            found = judge.follow(exact, 0)
            row |= {column: found[column] for column in judge.columns}
        if what == STEP:
            row['horizon_s'] = judge.horizon()
        if what == COARSER:
            rows, columns = ((n + 1) // 2 for n in judge.middle)
            row |= judge.rest(on_grid(judge.scene, rows, columns, **EXACT))
        if what == LONGER:
            row['behaves'] = judge.behave(on_grid(
                judge.scene, *judge.finest, **EXACT | {'precision': 'float32'}), 1)['behaves']
        return row

    for what in (STEP, COARSER, GRID, LONGER):
        yield Batch(what, [{'what': what}], measured, what in (STEP, COARSER))


def own_error(store: Store, column: str) -> float | None:
    """Return how far the reference of forecasts is from more exact ones [px]; None: not known."""
    found = [row[column] for row in store.rows(NAME) if row[column] is not None]
    return math.hypot(*found) if found else None


def in_short(store: Store) -> str:
    """Return in a sentence what the references can tell apart."""
    row = store.row(NAME, GRID) or store.row(NAME, STEP)
    if not row:
        return 'How exact the references are was not measured.'
    own = own_error(store, follows.RANKED)
    return (f'The reference of forecasts is itself wrong by {own:.2g} px after '
            f'{horizons.HORIZONS[2]:g} s, so that errors below {5.0 * own:.2g} px are uncertain '
            'by more than a fifth.')


def text(store: Store) -> str:
    """Return what the references are, and how exact."""
    judge = follows.judge(store.folder)
    rows = store.rows(NAME)
    if not rows:
        return ''
    lines = [[row['what'], *(row[column] for column in judge.columns), row['behaves'],
              row['rests'], row['sag_mm']] for row in rows]
    apart = next((row['horizon_s'] for row in rows if row['horizon_s']), None)
    units = ', '.join(f'{number(value)} for the {STATISTICS[name].title}'
                      for name, value in scatter(judge.long_runs).items())
    missing = [what for what in WHAT if not store.row(NAME, what)]
    fine, middle = (f'{columns} x {count} nodes' for count, columns in (
        judge.finest, judge.middle))
    return f"""## How it was measured, and how exactly

The shot: the default flag, wind and camera, with gusts of {follows.BASE['gust.intensity']:g}.
Forecasts are compared with the same sheet on {fine} (symplectic steps), in windows that
begin from its states. The motion is chaotic: two converged runs part
{f'after {apart:.2g} s' if apart else 'after more than 0.6 s'} in this shot; that is the horizon.
Beyond it {RUNS} runs of {LENGTH:.0f} s on {middle}, in gusts of other seeds, are compared
as distributions (Wasserstein's distance of each statistic, as in the energy distance). Their mean
distance from one another is the unit of *behaves*: {units}. Statics is that same sheet at rest.

How far more exact references, and a coarser one, are from them:

{table(['compared with', *(f'px after {seconds:.2g} s' for seconds in judge.horizons), 'behaves',
        'rests, mm/s', 'deeper, mm'], lines)}
""" + (f'\nNot measured for lack of time: {", ".join(missing)}.' if missing else '')
