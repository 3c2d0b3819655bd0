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

from flag_sim.study.measures import ranking, summary
from flag_sim.study.measures.behaves import scatter, STATISTICS
from flag_sim.study.measures.judge import halved, LENGTH, RUNS
from flag_sim.study.measures.reference import exact
from flag_sim.study.report import number, table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import follows, own_errors
from flag_sim.study.sections.own_errors import HALF, QUARTER
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 6, own_errors.ROWS, 1.5
STEP, COARSER, LONGER = 'another method', 'statics of a grid half as fine', 'a finer grid, long'
FORECASTS = HALF, QUARTER, STEP


def batches(store: Store) -> Iterator[Batch]:
    """Compare the references with coarser ones and with a finer one."""
    judge = follows.judge(store.folder)
    numbers = [f'{name}{column}' for name in ('', 'side_') for column in judge.columns]

    def measured(what, turn):
        row = dict.fromkeys((*numbers, 'horizon_s', 'behaves', 'rests', 'sag_mm'))
        if what in FORECASTS:
            window, gusts = follows.moment(turn)
            row |= judge.convergence(window, gusts)[FORECASTS.index(what)]
        if what == STEP and not turn:
            row['horizon_s'] = judge.horizon()
        if what == COARSER:
            row |= judge.rest(exact(judge.scene, *halved(judge.middle)))
        if what == LONGER:
            finer = (2 * count - 1 for count in judge.middle)
            row['behaves'] = judge.behave(exact(judge.scene, *finer), 1)['behaves']
        return row

    turns = sorted(summary.grouped(store.rows(follows.NAME), 'turn'))
    yield Batch('grids half and a quarter as fine', [
        {'what': what, 'turn': turn} for turn in turns for what in FORECASTS], measured, True)
    for what in (COARSER, LONGER):
        yield Batch(what, [{'what': what, 'turn': 0}], measured, what == COARSER)


def in_short(store: Store) -> str:
    """Return in a sentence what the reference of forecasts can tell apart."""
    own = [own_errors.own_px(store, column) for column in (follows.RANKED, follows.PROMISED)]
    if None in own:
        return 'How exact the references are was not measured.'
    return (f'The reference of forecasts is itself wrong by about {own[1]:.2g} px after '
            f'{follows.PROMISED_AT:g} s, too much to rank by; after {follows.RANKED_AT:g} s by '
            f'{own[0]:.2g} px, so that settings which differ by less than '
            f'{ranking.FROM * own[0]:.2g} px then are tied.')


def text(store: Store) -> str:
    """Return what the references are, and how exact."""
    rows = summary.grouped(store.rows(NAME), 'what')
    if not rows:
        return ''
    judge = follows.judge(store.folder)
    lines = [[what, *(summary.total(some, column) if what in FORECASTS else None
                      for column in judge.columns),
              *(some[0][column] for column in ('behaves', 'rests', 'sag_mm'))]
             for what, some in rows.items()]
    deeper = rows[COARSER][0]['sag_mm'] if COARSER in rows else None
    lines.append(['**own error**', *(own_errors.own_px(store, column) for column in judge.columns),
                  judge.own_scatter(), judge.at_rest.speed, deeper and abs(deeper)])
    lines.append(['**ranked from**', *(None if value is None else ranking.FROM * value
                                       for value in lines[-1][1:])])
    apart = next((row['horizon_s'] for row in rows.get(STEP, []) if row['horizon_s']), None)
    units = ', '.join(f'{number(value)} for the {STATISTICS[name].title}'
                      for name, value in scatter(judge.long_runs).items())
    missing = [what for what in (*FORECASTS, COARSER, LONGER) if what not in rows]
    fine, middle = (f'{columns} x {count} nodes' for count, columns in (
        judge.finest, judge.middle))
    return f"""## How it was measured, and how exactly

The shot: the default flag, wind and camera, with gusts of {follows.BASE['gust.intensity']:g}.
Forecasts are compared with the same sheet on {fine} (symplectic steps), in windows that
begin from its states, at the nodes that both have. The motion is chaotic: two converged runs part
{f'after {apart:.2g} s' if apart else 'after more than 0.6 s'} in this shot; that is the horizon.
Beyond it {RUNS} runs of {LENGTH:.0f} s on {middle}, in gusts of other seeds, are compared
as distributions (Wasserstein's distance of each statistic, as in the energy distance). Their mean
distance from one another is the unit of *behaves*: {units}. Statics is that same sheet at rest.

How far other grids and another method are from the references, and what these themselves are wrong
by: of forecasts, over {len(rows.get(HALF, []))} moments, the grid convergence index of the grids
half and a quarter as fine (Roache, 1994); of *behaves*, by how much that number differs among the
reference's own runs; of *rests*, its own residual speed, where statics has none, and by how much
a coarser grid hangs deeper. Only what differs by {ranking.FROM:g} times that is ranked:

{table(['compared with', *(f'px after {seconds:.2g} s' for seconds in judge.horizons), 'behaves',
        'rests, mm/s', 'deeper, mm'], lines)}
""" + (f'\nNot measured for lack of time: {", ".join(missing)}.' if missing else '')
