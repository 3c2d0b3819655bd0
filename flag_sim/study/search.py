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

A candidate's error is measured in several shots of other gusts, a few moments in each: moments of
one gust are alike, so that many of one shot tell little of another. Whatever refutes a candidate,
the next dearer one is tried.
"""
import math
from typing import NamedTuple

from flag_sim.declarations.factories import hang_of
from flag_sim.study.candidates import candidates, CHOSEN, YOURS
from flag_sim.study.measures import behaves, ranking, rests, summary
from flag_sim.study.measures.judge import (
    halved, Judge, LENGTH, OTHER_GUSTS, RUNS, SETTLE, work)
from flag_sim.study.measures.reference import LEAD, SPACING, SPIN_UP
from flag_sim.study.measures.settings import changed, Settings
from flag_sim.study.runner import key_of, measure_missing, print_progress
from flag_sim.study.store import Store
import numpy as np

SHOTS = 6    # of other gusts
WINDOWS = 2  # of each shot
MARGIN = 1.5
"""
Standard deviations by which a prediction is on the safe side.

1 of 10 fails: Student's t of SHOTS - 1 degrees of freedom.
"""
SCATTER = 1.5
"""
Least standard deviation of a new shot's mean square, in parts of what is predicted.

Rarely a fold snaps over in a window, which few moments do not show: of 192 pairs of shots of 6
windows each, the RMS error of one was above 1.5 times that of the other in 1 of 10, and of 9 other
scenes twice what had been measured in 2.
"""
HOPELESS = 2.0  # times the error that is allowed: what is so wrong in FIRST moments is dropped
FIRST = 4
MIN_GUSTS = 0.3  # least gust.intensity: in a steady wind all windows would be much alike
MAX_LOAD = 0.8
"""
Part of a frame's time that physics and drawing may take, one after the other.

The rest is for what tune does not see: messages, and moments in which the machine is slower.
"""
NODE_NS = 15.0  # processor time of a node in a step [ns], by which tune tells its own


def predicted(errors_px: np.ndarray, own_px: float = 0.0) -> float:
    """
    Return what the RMS error [px] of another shot should stay below.

    errors_px: (shots, windows) that were measured; inf where one diverged. The mean square of a
    new shot is predicted from those of n shots, by their standard deviation times the root of
    1 + 1 / n, or by SCATTER if that is more. own_px: error of the reference, from which that of
    settings is independent, so that the squares of both add up.
    """
    if not np.all(np.isfinite(errors_px)):
        return math.inf
    means = np.mean(np.square(errors_px), axis=1)
    spread = np.std(means, ddof=1) * math.sqrt(1.0 + 1.0 / len(means))
    return math.sqrt(np.mean(means) + own_px**2
                     + MARGIN * max(spread, SCATTER * np.mean(means)))


class Verdict(NamedTuple):
    """What is known of a candidate."""

    name: str
    cost_ms: float             # of a frame, physics and drawing: processor time
    errors_px: list[float]     # after the time that is asked, in the first moments; inf: diverged
    behaves: float = math.nan  # see Judge.behave; NaN: not looked at
    rests: float = math.nan    # see Judge.rest
    sag_mm: float = math.nan
    own_px: float = 0.0        # error of the reference itself

    @property
    def error_px(self) -> float:
        """Return the RMS error over all moments [pixel]."""
        return summary.rms(np.array(self.errors_px))

    @property
    def bound_px(self) -> float:
        """Return what the error of another shot should stay below [pixel]."""
        return predicted(self.by_shot, self.own_px)

    @property
    def by_shot(self) -> np.ndarray:
        """Return the errors of all moments: (shots, windows) [pixel]."""
        return np.reshape(self.errors_px, (WINDOWS, SHOTS)).T

    @property
    def of_shots(self) -> list[float]:
        """Return the RMS error of each shot [pixel]."""
        return [summary.rms(errors) for errors in self.by_shot]

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
        self.candidates = candidates(self.settings, self.judge.finest)
        self.limit_ms = MAX_LOAD * 1e3 / rate
        # Windows, and what is added to gust.seed: one of each shot first.
        self.moments = [(window, OTHER_GUSTS * shot) for window in range(WINDOWS)
                        for shot in range(SHOTS)]

    def minutes(self) -> float:
        """Return how long the references and one candidate of the user's grid may take [min]."""
        fine, half, middle, own = (work(self.settings, *grid) for grid in (
            self.judge.finest, halved(self.judge.finest), self.judge.middle,
            (self.settings['grid.rows'], self.settings['grid.columns'])))
        shots = SHOTS * (SPIN_UP + (WINDOWS - 1) * SPACING)
        windows = len(self.moments)
        long = RUNS * (SETTLE + LENGTH)
        resting = rests.BLOWN + rests.USUAL + rests.FREE
        references = (windows * (LEAD + self.seconds) * fine
                      + (shots + 2 * windows * self.seconds) * half + (long + resting) * middle)
        # References are in single precision.
        nodes = 0.5 * references + (windows * self.seconds + long / 2 + resting) * own
        return 1e-9 * NODE_NS * nodes / 60.0

    def find(self, error_px: float) -> Choice:
        """
        Return the Choice for an error that is allowed [pixel].

        The cheapest candidate that keeps it in all shots, behaves, rests and is fast enough. If
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
            verdict = self._verdict(name)
            if self._is_accurate(verdict, error_px):
                verdict = self._looked_at(verdict)
                if verdict.is_sound(self.length) and verdict.cost_ms <= self.limit_ms:
                    return Choice(self._safer(verdict, tried, error_px), True, True, True)
            tried.append(verdict)
        return self._second_best(tried, error_px)

    @staticmethod
    def _is_accurate(verdict, error_px):
        """
        Return whether a candidate keeps an error, also in other shots.

        Of the user's own settings it is enough that they keep it in all shots but one: nothing
        dearer is to be taken where they do.
        """
        if verdict.name == YOURS:
            return sorted(verdict.of_shots)[-2] <= error_px
        return verdict.bound_px <= error_px

    def _safer(self, verdict, tried, error_px):
        """
        Return the Verdict to take where one is good enough: another that is safer, or itself.

        The user's own settings may be good enough by less than the margin for other shots. What is
        cheaper, sound and of a lower bound then is the better choice.
        """
        if verdict.bound_px > error_px:
            for other in sorted((one for one in tried if len(one.errors_px) == len(self.moments)
                                 and one.cost_ms <= verdict.cost_ms
                                 and one.bound_px < verdict.bound_px),
                                key=lambda one: one.bound_px):
                other = self._looked_at(other)
                if other.is_sound(self.length):
                    return other
        return verdict

    def _second_best(self, tried, error_px):
        """Return the Choice where nothing keeps all: sound, fast, then of the least error."""
        for verdict in sorted(tried, key=lambda one: one.error_px):
            verdict = self._looked_at(self._verdict(verdict.name))
            if verdict.is_sound(self.length):
                break
        else:
            verdict = self._looked_at(self._verdict(YOURS))
        return Choice(verdict, self._is_accurate(verdict, error_px), verdict.is_sound(self.length),
                      verdict.cost_ms <= self.limit_ms)

    def chosen(self, name: str) -> Settings:
        """Return {parameter: value} of what is chosen with a candidate."""
        return {one: self.candidates[name][one] for one in CHOSEN}

    def _verdict(self, name, count=None):
        """Return the Verdict on the errors of a candidate in the first moments, or in all."""
        rows = [self._row('follows', name, lambda setting, window, gusts:
                          self.judge.follow(self.candidates[setting], window, gusts),
                          window=window, gusts=gusts)
                for window, gusts in self.moments[:count]]
        drawing = self._row('drawing', name, lambda setting: {
            'drawing_ms': self.judge.drawing_ms(self.candidates[setting])})
        times = [row['physics_ms'] for row in rows if row['physics_ms'] is not None]
        cost = float(np.median(times)) + drawing['drawing_ms'] if times else math.inf
        column = self.judge.columns[0]
        return Verdict(name, cost, [math.inf if row[column] is None else row[column]
                                    for row in rows],
                       own_px=self.own_px() if len(rows) == len(self.moments) else 0.0)

    def own_px(self) -> float:
        """Return the reference's own error [pixel], over all moments."""
        column, which = self.judge.columns[0], {'half': 0, 'quarter': 1}

        def measured(setting, window, gusts):
            return {column: self.judge.convergence(window, gusts)[which[setting]][column]}

        rows = [self._row('references', what, measured, window=window, gusts=gusts)
                for what in ('quarter', 'half') for window, gusts in self.moments]
        return ranking.own_error(*(summary.total(some, column)
                                   for some in summary.grouped(rows, 'setting').values()))

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
            if section in ('behaves', 'rests') or case.get('window') == case.get('gusts') == 0:
                print_progress(f'{section}: {name}')
            measure_missing(self.store, section, [case], measured)
        return self.store.row(section, key_of(case))
