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

"""Every method on every grid, beyond the horizon: whether it behaves, and whether it rests."""
from collections.abc import Iterator
import math

from flag_sim.declarations.factories import hang_of
from flag_sim.study.measures import behaves, ranking, rests
from flag_sim.study.measures.behaves import STATISTICS
from flag_sim.study.measures.judge import LENGTH
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.sections import follows
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 3, 'sound', 5.0
FIRST = (31, 25, 16, 13)  # columns of the grids that are run first
SOONEST = ('symplectic float32', 'symplectic')  # methods that are run before the others


def batches(store: Store) -> Iterator[Batch]:
    """Run every setting once for long, and once into calm air."""
    judge, own = follows.judge(store.folder), follows.settings()

    def place(name):
        columns, _, method = name.partition(' ')
        grid = int(columns)
        return (grid > follows.FEWER and method != SOONEST[0], method not in SOONEST,
                method in follows.methods(True),
                FIRST.index(grid) if grid in FIRST else len(FIRST) + grid)

    def measured(setting):
        return {**judge.behave(own[setting], runs=1), **judge.rest(own[setting])}

    for name in sorted(own, key=place):
        yield Batch(f'{LENGTH:.0f} s with {name}', [{'setting': name}], measured,
                    name == follows.DEFAULT)


def is_sound(row: dict) -> bool:
    """Return whether a row's setting behaves, rests and hangs as deep as it should."""
    _, length, _ = hang_of(follows.BASE)
    return (row['behaves'] <= behaves.WITHIN and row['rests'] <= rests.SLOW
            and abs(row['sag_mm']) <= 1e3 * rests.DEEPER * length)


def text(store: Store) -> str:
    """Return how all settings behave and rest."""
    rows = store.rows(NAME)
    if not rows:
        return ''
    own = follows.judge(store.folder).own_scatter()
    lines = [[row['setting'], row['behaves'], *(row[name] for name in STATISTICS),
              None if math.isinf(row['rests']) else row['rests'],
              None if math.isinf(row['rests']) else row['sag_mm'],
              'yes' if is_sound(row) else 'no'] for row in rows]
    missing = {}
    for name in follows.settings():
        columns, _, method = name.partition(' ')
        if not store.row(NAME, name):
            missing.setdefault(method, []).append(columns)
    words = '; '.join(f'{method} on {", ".join(columns)}' for method, columns in missing.items())
    return f"""## Behaves and rests: what is left beyond the horizon

**Behaves applies to all that is watched for longer than the horizon.** Over {LENGTH:.0f} s, how
far is each statistic from the reference's, if 1 is how far the reference's own runs in other gusts
are from one another? The number is the RMS over all of them; {behaves.WITHIN:g} is allowed. It is
uncertain by {own:.2g}, as among those runs: what differs by less than {ranking.FROM * own:.2g} is
tied.
**Rests applies to shots with calm air.** The wind stops, a hand stills the flag
(`node_damping` until it moves by less than {rests.STILL:g} mm/s, for {rests.STILLED:g} s at most),
and it is let alone: the speed that is left after
{rests.FREE:g} s (RMS) may be {rests.SLOW:g} mm/s, and it may hang {100 * rests.DEEPER:g} % of its
length deeper or higher than statics says.

{table(['setting', 'behaves', *STATISTICS, 'rests, mm/s', 'deeper, mm', 'both'], lines)}
""" + (f'\nNot run for lack of time (method on columns): {words}.' if words else '')
