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
The search for the cheapest settings: candidates from cheap to dear, each on all windows.

A candidate's error is measured in a shot to tune on, predicted for other shots, and checked in one
that it was not tuned on.
"""
import math
from typing import NamedTuple

from flag_sim.cloth import Air
from flag_sim.declarations.factories import cloth_of, hang_of, look_of
from flag_sim.study.measures import errors, summary
from flag_sim.study.measures.reference import FINEST, nested, on_grid, Reference, WINDOW
from flag_sim.study.measures.settings import changed, Settings
from flag_sim.study.measures.stability_trial import largest_step
from flag_sim.study.measures.trials import Trials
from flag_sim.study.runner import key_of, measure_missing, print_progress
from flag_sim.study.store import Store
import numpy as np

MARGIN = 2.0
"""Standard deviations by which a prediction is on the safe side: 1 of 40 fails if it is normal."""
WINDOWS, CHECKS = 6, 6  # windows of the shot to tune on, and of the shot to check on
OTHER_SEED = 1000  # added to gust.seed, for the shot to check on
MIN_GUSTS = 0.3  # least gust.intensity: in a steady wind all windows would be much alike
STRETCH_RUN = 4.0
"""Length of the run that tells how far a sheet is stretched [s]; its second half counts."""
MAX_STEPS = 20000  # steps that the reference may take in a frame, some ten seconds
DEARER = 2.0
"""How much dearer a candidate may be, by its work, than the cheapest good one to be tried."""
MAX_LOAD = 0.8
"""
Part of a frame's time that physics and drawing may take, one after the other.

The rest is for what tune does not see: messages, and moments in which the machine is slower.
"""
CHOSEN = ('rate', 'grid.columns', 'grid.rows', 'damping', 'solver', 'substeps',
          'substeps_limit', 'step_safety', 'precision')
"""
The parameters that are chosen.

Not threads: they would be taken from the renderer, which draws one frame while the next moves.
"""


def methods() -> dict[str, Settings]:
    """Return {name: changes}: steps that keep the material as it is, and friction in it."""
    exact = {'solver': 'symplectic', 'substeps': 0, 'precision': 'float64'}
    return {
        'symplectic': exact,
        'symplectic float32': {**exact, 'precision': 'float32'},
        **{f'{name} {steps}': {**exact, 'solver': name, 'substeps': steps,
                               'substeps_limit': steps}
           for name in ('xpbd', 'implicit') for steps in (2, 5, 10)},
    }


def require(settings: Settings) -> None:
    """
    Raise ValueError for settings that make no scene, or that cannot be tuned.

    Their camera must see the flag, and the reference must not take hours.
    """
    at_rest = cloth_of(settings).positions
    errors.pixel_distances(at_rest, at_rest, look_of(settings).camera)
    fine = cloth_of(on_grid(settings, *FINEST))
    steps = 1.0 / (settings['rate'] * largest_step('symplectic', fine.material, Air(), fine.mesh))
    if steps > MAX_STEPS:
        raise ValueError(
            f'the reference, on {FINEST[1]} x {FINEST[0]} nodes, may take at most {MAX_STEPS} '
            f'steps a frame, and this sheet needs {steps:.0f}: lower its stiffness or damping')


class Option(NamedTuple):
    """Settings by name; cost of a frame [ms]; error [px] that other shots should stay below."""

    name: str
    cost_ms: float
    error_px: float


class Choice(NamedTuple):
    """The option to take, and whether it keeps the budget of error and that of time."""

    option: Option
    is_accurate: bool
    is_fast: bool


def predicted(errors_px: list[float], others: int) -> float:
    """
    Return what the RMS error [px] of as many `others` windows should stay below.

    errors_px: of windows of one shot; inf if one diverged. The mean of their squares is
    predicted for new windows with its standard deviation, the root of s2 (1 / n + 1 / others).
    """
    squares = np.square(errors_px)
    if not np.all(np.isfinite(squares)):
        return math.inf
    spread = np.std(squares, ddof=1) * math.sqrt(1.0 / len(squares) + 1.0 / others)
    return math.sqrt(np.mean(squares) + MARGIN * spread)


def choose(options: list[Option], error_px: float, limit_ms: float) -> Choice:
    """
    Return the Choice from a list of Options for budgets of error [px] and time [ms].

    The cheapest that keeps both; if none does, the most accurate that keeps the time; if none
    keeps the time, the cheapest. Raises ValueError for an empty list.
    """
    if not options:
        raise ValueError('there is nothing to choose from')
    fast = [option for option in options if option.cost_ms <= limit_ms]
    good = [option for option in fast if option.error_px <= error_px]
    if good or not fast:
        best = min(good or options, key=lambda option: option.cost_ms)
    else:
        best = min(fast, key=lambda option: (option.error_px, option.cost_ms))
    return Choice(best, best.error_px <= error_px, best.cost_ms <= limit_ms)


class Search:
    """
    Tries settings for one camera and one rate; what it has measured is kept in a Store.

    settings: of the user's scene, camera and sheet; rate: frames a second.
    """

    def __init__(self, settings: Settings, rate: float, store: Store):
        gusts = max(settings['gust.intensity'], MIN_GUSTS)
        self.settings = changed(settings, {'rate': rate, 'gust.intensity': gusts})
        self.store = store
        frames = max(1, round(WINDOW * rate))
        self.window_s = frames / rate
        self._trials = {}
        for part, seed in (('tune', 0), ('check', OTHER_SEED)):
            shot = changed(self.settings, {'gust.seed': self.settings['gust.seed'] + seed})
            self._trials[part] = Trials(
                Reference(shot, frames, store.folder / part, FINEST), shot, frames)
        self.candidates, self._works = {}, {}
        self._add_candidates()
        self.limit_ms = MAX_LOAD * 1e3 / rate

    def _add_candidates(self):
        """Set {name: settings} and {name: work of a frame}, from cheap to dear by that work."""
        found = {}
        for rows, columns in nested(FINEST):
            for method, changes in methods().items():
                settings = on_grid(self.settings, rows, columns, **changes)
                steps = cloth_of(settings).advance(1.0 / self.settings['rate']).granted
                work = rows * columns * steps * (1 if 'symplectic' in method else 4)
                found[f'{columns} x {rows}, {method}'] = work, settings
        for name, (work, settings) in sorted(found.items(), key=lambda item: item[1][0]):
            self.candidates[name], self._works[name] = settings, work

    def find(self, error_px: float) -> tuple[Choice, list[float]]:
        """
        Return the Choice, and the errors [px] of what it takes in the shot to check on.

        Settings that prove more wrong or dearer in the check count as what they proved to be; the
        best is then chosen anew, until it is one that has been checked.
        """
        options = {option.name: option for option in self._options(error_px)}
        while True:
            choice = choose(list(options.values()), error_px, self.limit_ms)
            option, name = choice.option, choice.option.name
            rows = self._rows('check', name, CHECKS)
            found = _errors(rows)
            checked = option._replace(
                cost_ms=max(option.cost_ms, self._cost(rows)),
                error_px=max(option.error_px, summary.rms(found), self._stretch_error(name)))
            if checked == option or not choice.is_fast:
                return choice, found
            options[name] = checked

    def chosen(self, name: str) -> Settings:
        """Return {parameter: value} of what is chosen with a candidate."""
        return {one: self.candidates[name][one] for one in CHOSEN}

    def _options(self, error_px):
        """Return Options of the candidates that are worth trying."""
        options, enough, slow = [], math.inf, set()
        for name in self.candidates:
            if self._works[name] > enough:
                break
            method = name.partition(', ')[2]
            if method in slow:
                continue
            rows = self._rows('tune', name, 1)
            if self._cost(rows) > 2.0 * self.limit_ms:
                # On finer grids it is slower still.
                slow.add(method)
                if options:
                    continue
            if _errors(rows)[0] <= 3.0 * error_px:
                rows = self._rows('tune', name, WINDOWS)
            found = _errors(rows)
            bound = predicted(found, CHECKS) if len(rows) == WINDOWS else 2.0 * found[0]
            if bound <= error_px:
                bound = max(bound, self._stretch_error(name))
            options.append(Option(name, self._cost(rows), bound))
            if bound <= error_px and options[-1].cost_ms <= self.limit_ms:
                enough = min(enough, DEARER * self._works[name])
        return options

    def _stretch_error(self, name):
        """
        Return the error [px] that stays beyond the horizon because the sheet is stretched.

        A softened sheet may keep near the reference for the length of a window and be longer by a
        third in the end. A stretch e moves the point at distance s from the hoist by e s, over
        the length L by e L / sqrt(3) (RMS), seen here from the camera's distance.
        """
        trials, length = self._trials['tune'], hang_of(self.settings)[1]

        def measured(setting):
            right = _stretch(trials.reference.window(0).positions, length)
            cloth, shot = cloth_of(self.candidates[setting]), trials.reference.shot
            frames = shot.frames(STRETCH_RUN)
            found = [_stretch(cloth.positions, length) for _ in shot.timed(cloth, 0, frames)]
            metres = math.inf if len(found) < frames else (
                abs(np.mean(found[frames // 2:]) - right) * length / math.sqrt(3.0))
            depth = trials.camera.pose[2] @ np.append(cloth.positions.mean(axis=(0, 1)), 1.0)
            return {'rms_px': float(metres * trials.camera.pixels_per_metre(depth))}

        case = {'setting': name}
        measure_missing(self.store, 'stretch', [case], measured)
        return self.store.row('stretch', key_of(case))['rms_px']

    @staticmethod
    def _cost(rows):
        """Return the median cost of a frame [ms], inf if all diverged."""
        found = summary.quartiles(rows, *summary.COST)
        return math.inf if found is None else found[1]

    def _rows(self, part, name, count):
        """Return the rows of a candidate in the first windows of a shot; measure what is new."""
        trials = self._trials[part]

        def measured(setting, window):
            if not trials.reference.has(window):
                print_progress(f'{part}: reference {window + 1} of {WINDOWS}')
            elif window == 0:
                print_progress(f'{part}: {setting}')
            return trials.row(self.candidates[setting], trials.reference.window(window), {})

        cases = [{'setting': name, 'window': number} for number in range(count)]
        measure_missing(self.store, part, cases, measured)
        return [self.store.row(part, key_of(case)) for case in cases]


def _errors(rows):
    """Return the errors [px] of rows, inf where a run diverged."""
    return [math.inf if row['rms_px'] is None else row['rms_px'] for row in rows]


def _stretch(positions, length):
    """Return the mean strain along the rows of positions (rows, columns, 3) [m]."""
    return float(errors.distances(positions[:, 1:], positions[:, :-1]).sum(axis=1).mean()
                 / length - 1.0)
