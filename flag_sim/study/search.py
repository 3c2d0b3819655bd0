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

"""
The search of tune: candidates by what they cost, until one keeps all that is asked.

A candidate's error is measured in two shots of other gusts; the later rows are those of a shot in
which nothing was dropped before. Whatever refutes a candidate, the next dearer one is tried.
"""
import math
from typing import NamedTuple

from flag_sim.declarations.factories import cloth_of, hang_of, look_of
from flag_sim.study.measures import behaves, errors, ranking, rests, summary
from flag_sim.study.measures.judge import (
    halved, Judge, LENGTH, OTHER_GUSTS, RUNS, SETTLE, work)
from flag_sim.study.measures.reference import LEAD, nested, on_grid, SPACING, SPIN_UP
from flag_sim.study.measures.settings import changed, Settings
from flag_sim.study.runner import key_of, measure_missing, print_progress
from flag_sim.study.store import Store
import numpy as np

WINDOWS = 6  # of each of two shots
OTHERS = 6       # windows of another shot, for which the promise is to hold
MARGIN = 1.3
"""Standard deviations by which a prediction is on the safe side: 1 of 10 fails if it is normal."""
COARSEST = 7     # columns of the coarsest grid that is tried
HOPELESS = 2.0  # times the error that is allowed: what is so wrong in FIRST windows is dropped
FIRST = 2
MIN_GUSTS = 0.3  # least gust.intensity: in a steady wind all windows would be much alike
MAX_WORK = 1e9   # nodes times steps of a second that the coarsest reference may take
MAX_LOAD = 0.8
"""
Part of a frame's time that physics and drawing may take, one after the other.

The rest is for what tune does not see: messages, and moments in which the machine is slower.
"""
NODE_NS = 15.0  # processor time of a node in a step [ns], by which tune tells its own
CHOSEN = ('rate', 'grid.columns', 'grid.rows', 'damping', 'solver', 'substeps',
          'substeps_limit', 'step_safety', 'precision')
"""
The parameters that are chosen.

Not threads: they would be taken from the renderer, which draws one frame while the next moves.
"""
BETWEEN = (8, 12, 16)
"""Of grids of 3 n x 2 n cells, between those that are nested in the reference's."""
YOURS = 'your own settings'


def methods() -> dict[str, Settings]:
    """Return {name: changes}: steps that keep the material as it is, and friction in it."""
    exact = {'solver': 'symplectic', 'substeps': 0, 'precision': 'float64'}
    return {
        'symplectic float32': {**exact, 'precision': 'float32'},
        'symplectic': exact,
        'verlet': {**exact, 'solver': 'verlet'},
        **{f'{name} {steps}': {**exact, 'solver': name, 'substeps': steps,
                               'substeps_limit': steps}
           for name, steps in (('xpbd', 5), ('implicit', 5), ('implicit', 10))},
    }


def require(settings: Settings) -> None:
    """
    Raise ValueError for settings that make no scene, or that cannot be tuned.

    Their camera must see the flag, and the reference must not take hours.
    """
    at_rest = cloth_of(settings).positions
    errors.pixel_distances(at_rest, at_rest, look_of(settings).camera)
    coarsest = work(settings, 21, 31)
    if coarsest > MAX_WORK:
        raise ValueError(
            f'a reference may take {MAX_WORK:.0e} nodes times steps a second, and this sheet '
            f'needs {coarsest:.1e} on 31 x 21 nodes: lower its stiffness or damping')


def predicted(errors_px: list[float], own_px: float = 0.0, others: int = OTHERS) -> float:
    """
    Return what the RMS error [px] of as many `others` windows should stay below.

    errors_px: of windows that were measured; inf if one diverged. The mean of their squares is
    predicted for new windows with its standard deviation, the root of s2 (1 / n + 1 / others).
    own_px: error of the reference, from which that of settings is independent, so that the
    squares of both add up.
    """
    squares = np.square(errors_px)
    if not np.all(np.isfinite(squares)):
        return math.inf
    spread = np.std(squares, ddof=1) * math.sqrt(1.0 / len(squares) + 1.0 / others)
    return math.sqrt(np.mean(squares) + own_px**2 + MARGIN * spread)


class Verdict(NamedTuple):
    """What is known of a candidate."""

    name: str
    cost_ms: float             # of a frame, physics and drawing: processor time
    errors_px: list[float]     # after the time that is asked, in each window; inf: diverged
    behaves: float = math.nan  # see Judge.behave; NaN: not looked at
    rests: float = math.nan    # see Judge.rest
    sag_mm: float = math.nan
    own_px: float = 0.0        # error of the reference itself

    @property
    def error_px(self) -> float:
        """Return the RMS error over all windows [pixel]."""
        return summary.rms(np.array(self.errors_px))

    @property
    def bound_px(self) -> float:
        """Return what the error of another shot should stay below [pixel]."""
        return predicted(self.errors_px, self.own_px)

    def is_sound(self, length: float) -> bool:
        """Return whether it behaves, rests and does not hang too long; length: of the flag [m]."""
        return (self.behaves <= behaves.WITHIN and self.rests <= rests.SLOW
                and abs(self.sag_mm) <= 1e3 * rests.DEEPER * length)


class Choice(NamedTuple):
    """The candidate to take, and what of the promise it keeps."""

    verdict: Verdict
    is_accurate: bool
    is_sound: bool
    is_fast: bool


class Search:
    """
    Tries settings for one scene and one rate; what it has measured is kept in a Store.

    settings: of the user's scene, camera and sheet; rate: frames a second; seconds: after how long
    the error counts.
    """

    def __init__(self, settings: Settings, rate: float, seconds: float, store: Store):
        gusts = max(settings['gust.intensity'], MIN_GUSTS)
        self.settings = changed(settings, {'rate': rate, 'gust.intensity': gusts})
        self.store = store
        self.judge = Judge(self.settings, store.folder, (seconds,))
        self.seconds = self.judge.frames[0] / rate
        self.length = hang_of(settings)[1]
        self.candidates = self._candidates()
        self.limit_ms = MAX_LOAD * 1e3 / rate
        self.shots = (0, OTHER_GUSTS)  # added to gust.seed: one shot to look in, one to check

    def _candidates(self):
        """Return {name: settings}: the user's own, and every method on every grid."""
        found, half = {YOURS: self.settings}, (self.judge.finest[0] + 1) // 2
        between = [(2 * n + 1, 3 * n + 1) for n in BETWEEN if 2 * n < half]
        for rows, columns in [*nested(self.judge.finest), *between]:
            if columns < COARSEST:
                continue
            for method, changes in methods().items():
                found[f'{columns} x {rows}, {method}'] = on_grid(
                    self.settings, rows, columns, **changes)
        return found

    def minutes(self) -> float:
        """Return how long the references and one candidate of the user's grid may take [min]."""
        fine, half, middle, own = (work(self.settings, *grid) for grid in (
            self.judge.finest, halved(self.judge.finest), self.judge.middle,
            (self.settings['grid.rows'], self.settings['grid.columns'])))
        shot = SPIN_UP + WINDOWS * SPACING
        resting = rests.BLOWN + rests.USUAL + rests.FREE
        nodes = (WINDOWS * (LEAD + self.seconds) * fine
                 + shot * half + 0.5 * (RUNS * (SETTLE + LENGTH) + resting) * middle
                 + (2 * WINDOWS * self.seconds + RUNS * (SETTLE + LENGTH) + resting) * own)
        return 1e-9 * NODE_NS * nodes / 60.0

    def find(self, error_px: float) -> Choice:
        """
        Return the Choice for an error that is allowed [pixel].

        The cheapest candidate that keeps it in both shots, behaves, rests and is fast enough. If
        none does: of those that are fast enough, one that behaves and rests, of the least error.
        """
        costs = {name: self._verdict(name, 1).cost_ms for name in self.candidates}
        order = sorted(self.candidates, key=costs.get)
        fast = [name for name in order if costs[name] <= self.limit_ms]
        tried = []
        for name in fast or order[:1]:
            first = self._verdict(name, FIRST)
            if first.error_px > HOPELESS * error_px:
                tried.append(first)
                continue
            verdict = self._verdict(name, WINDOWS)
            if self._is_accurate(verdict, error_px):
                verdict = self._looked_at(verdict)
                if verdict.is_sound(self.length) and verdict.cost_ms <= self.limit_ms:
                    return Choice(verdict, True, True, True)
            tried.append(verdict)
        return self._second_best(tried, error_px)

    def _is_accurate(self, verdict, error_px):
        """
        Return whether a candidate keeps an error, also in other shots.

        Of the user's own settings it is enough that they keep it in both shots: nothing dearer
        is to be taken where they do.
        """
        if verdict.name == YOURS:
            return all(self.errors_of(YOURS, gusts) <= error_px for gusts in self.shots)
        return verdict.bound_px <= error_px

    def _second_best(self, tried, error_px):
        """Return the Choice where nothing keeps all: sound, fast, then of the least error."""
        for verdict in sorted(tried, key=lambda one: one.error_px):
            verdict = self._looked_at(self._verdict(verdict.name, WINDOWS))
            if verdict.is_sound(self.length):
                break
        else:
            verdict = self._looked_at(self._verdict(YOURS, WINDOWS))
        return Choice(verdict, self._is_accurate(verdict, error_px), verdict.is_sound(self.length),
                      verdict.cost_ms <= self.limit_ms)

    def chosen(self, name: str) -> Settings:
        """Return {parameter: value} of what is chosen with a candidate."""
        return {one: self.candidates[name][one] for one in CHOSEN}

    def _verdict(self, name, windows):
        """Return the Verdict on the errors of a candidate in the first windows of both shots."""
        rows = []
        for number in range(windows):
            for gusts in self.shots[:1 if windows == 1 else 2]:
                rows.append(self._row('follows', name, lambda setting, window, gusts:
                                      self.judge.follow(self.candidates[setting], window, gusts),
                                      window=number, gusts=gusts))
        drawing = self._row('drawing', name, lambda setting: {
            'drawing_ms': self.judge.drawing_ms(self.candidates[setting])})
        times = [row['physics_ms'] for row in rows if row['physics_ms'] is not None]
        cost = float(np.median(times)) + drawing['drawing_ms'] if times else math.inf
        column = self.judge.columns[0]
        return Verdict(name, cost, [math.inf if row[column] is None else row[column]
                                    for row in rows],
                       own_px=self.own_px() if windows == WINDOWS else 0.0)

    def own_px(self) -> float:
        """Return the reference's own error [pixel], over all windows of both shots."""
        column, rows = self.judge.columns[0], {'half': [], 'quarter': []}
        for number in range(WINDOWS):
            for gusts in self.shots:
                for what, some in rows.items():
                    some.append(self._row(
                        'references', what, lambda setting, window, gusts: {
                            column: self.judge.convergence(window, gusts)[
                                ('half', 'quarter').index(setting)][column]},
                        window=number, gusts=gusts))
        return ranking.own_error(*(summary.total(rows[what], column)
                                   for what in ('quarter', 'half')))

    def errors_of(self, name: str, gusts: int) -> float:
        """Return the RMS error [pixel] of a candidate in all windows of one of the shots."""
        rows = [row for row in self.store.rows('follows')
                if (row['setting'], row['gusts']) == (name, gusts)]
        return summary.total(rows, self.judge.columns[0])

    def _looked_at(self, verdict):
        """Return a Verdict with how a candidate behaves and rests."""
        moving = self._row('behaves', verdict.name,
                           lambda setting: self.judge.behave(self.candidates[setting]))
        at_rest = self._row('rests', verdict.name,
                            lambda setting: self.judge.rest(self.candidates[setting]))
        return verdict._replace(behaves=moving['behaves'], rests=at_rest['rests'],
                                sag_mm=at_rest['sag_mm'])

    def _row(self, section, name, measured, **case):
        """Return the row of a candidate in a section; measure it where it is missing."""
        case = {'setting': name, **case}
        if not self.store.row(section, key_of(case)):
            if section != 'drawing' and not case.get('window'):
                print_progress(f'{section}: {name}')
            measure_missing(self.store, section, [case], measured)
        return self.store.row(section, key_of(case))
