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
A judge of settings: what they cost, and how they do by the three measures, in one user's scene.

Follows (an error in pixels, until the horizon), behaves (statistics beyond it) and rests (calm
air) each have a module of their own; here are the references that they need, and rows of numbers.
"""
import functools
import math
from pathlib import Path
import time

from flag_sim.declarations.factories import cloth_of, look_of
from flag_sim.drawing import Camera, Picture
from flag_sim.study.measures import follows, rests
from flag_sim.study.measures.behaves import (
    behaves, dominant_frequency, own_scatter, together)
from flag_sim.study.measures.errors import pixel_distances
from flag_sim.study.measures.long_run import LongRun, observed
from flag_sim.study.measures.reference import exact, FINEST, Reference, Shot, steps
from flag_sim.study.measures.settings import changed, Settings
from flag_sim.study.measures.summary import rms
import numpy as np

RUNS = 4        # of the reference, each in gusts of its own
SETTLE = 3.0    # of a long run, that are left out: the flag, laid out flat, falls [s]
LENGTH = 20.0   # of a long run, that are compared [s]
OTHER_GUSTS = 1000  # added to gust.seed, for a shot that has nothing to do with it
LARGEST_WORK = 1.5e8  # of forecasts' reference: nodes times steps in a second, two of a core
LARGEST_LONG = 7e7    # the same of the reference's long runs
TIMED = 3  # pictures whose median time counts


def work(scene: Settings, rows: int, columns: int) -> float:
    """Return the nodes times the steps that a reference takes for a second of motion."""
    return rows * columns * steps(exact(scene, rows, columns))


def halved(grid: tuple[int, int]) -> tuple[int, int]:
    """Return rows and columns of a grid half as fine."""
    return tuple((count + 1) // 2 for count in grid)


def reference_grid(scene: Settings, largest: float,
                   finest: tuple[int, int]) -> tuple[int, int]:
    """Return rows and columns of a grid, or of the finest of its halves of less than such work."""
    rows, columns = finest
    while rows > 21 and work(scene, rows, columns) > largest:
        rows, columns = halved((rows, columns))
    return rows, columns


class Judge:
    """
    Measures settings in the scene of a user: wind, sheet, camera.

    scene: settings of the scene. folder: where references are kept from run to run. horizons: at
    which the error of a forecast is told [s]. others: {name: camera}: further cameras that
    forecasts are seen by, in columns that begin with the name. finest: rows and columns of the
    reference of forecasts; by default as fine a one as is quick.
    """

    def __init__(self, scene: Settings, folder: Path,
                 horizons: tuple[float, ...] = follows.HORIZONS,
                 others: dict[str, Camera] | None = None,
                 finest: tuple[int, int] | None = None):
        self.scene, self.folder, self.horizons = scene, folder, horizons
        self.camera = look_of(scene).camera
        self._cameras = {'': self.camera, **(others or {})}
        self.finest = finest or reference_grid(scene, LARGEST_WORK, FINEST)
        self.middle = reference_grid(scene, LARGEST_LONG, halved(FINEST))
        self.frames = follows.after(Shot(scene), horizons)
        self.columns = [f'px_{seconds:.2g}' for seconds in horizons]
        self._compiled = set()

    @functools.cache
    def reference(self, gusts: int = 0) -> Reference:
        """Return the reference of forecasts, in the shot whose gust.seed is higher by `gusts`."""
        return Reference(self._in_gusts(self.scene, gusts), max(self.frames),
                         self.folder / f'windows{gusts}', self.finest)

    @staticmethod
    def _in_gusts(settings, gusts):
        return changed(settings, {'gust.seed': settings['gust.seed'] + gusts})

    def warm_up(self, settings: Settings) -> None:
        """Compile what settings need, so that no time has it."""
        method = settings['solver'], settings['precision']
        if method not in self._compiled:
            self._compiled.add(method)
            cloth_of(settings).advance(1e-6)

    def follow(self, settings: Settings, window: int, gusts: int = 0) -> dict:
        """
        Return a row: the error at each horizon [pixel], and the processor time of a frame [ms].

        None where the run diverged.
        """
        self.warm_up(settings)
        reference = self.reference(gusts)
        start = reference.window(window)
        cloth = reference.start(start, settings)
        begin = time.process_time()
        found = follows.ends(reference.shot, cloth, start.frame, self.frames)
        taken = 1e3 * (time.process_time() - begin) / max(self.frames)
        return {**self._errors(found, self._ends(start)),
                'physics_ms': None if found[-1] is None else taken}

    def _ends(self, window):
        """Return where the reference is at the horizons of a window."""
        return [window.ends[count - 1] for count in self.frames]

    def _errors(self, found, right):
        """Return {column: error [pixel]} of positions at the horizons, by every camera."""
        return {f'{name}{column}': error for name, camera in self._cameras.items()
                for column, error in zip(self.columns, follows.errors_px(found, right, camera))}

    @functools.cache
    def convergence(self, window: int, gusts: int = 0) -> tuple[dict, dict, dict]:
        """
        Return three rows of distances at each horizon [pixel], from the state of a window.

        Of a grid half as fine as the reference's from the reference; of one a quarter as fine from
        that; and of a method of higher order from it, on the same grid: see ranking.own_error.
        """
        reference = self.reference(gusts)
        start, half = reference.window(window), halved(self.finest)

        def ends(grid, **changes):
            settings = changed(exact(self.scene, *grid), changes)
            return follows.ends(reference.shot, reference.start(start, settings), start.frame,
                                self.frames)

        of_half = ends(half)
        return (self._errors(of_half, self._ends(start)),
                self._errors(ends(halved(half)), of_half),
                self._errors(ends(half, solver='verlet'), of_half))

    def drawing_ms(self, settings: Settings) -> float:
        """Return the processor time of a picture of the flag at rest [ms]."""
        picture, look, positions = (
            Picture(settings['drawing.threads']), look_of(settings), cloth_of(settings).positions)
        times = []
        for _ in range(1 + TIMED):  # the first compiles, and does not count
            begin = time.process_time()
            picture.draw(positions, None, *look)
            times.append(1e3 * (time.process_time() - begin))
        return sorted(times[1:])[TIMED // 2]

    def long_run(self, settings: Settings, gusts: int) -> LongRun | None:
        """Return the long run of settings in some gusts, None if it diverges."""
        settings = self._in_gusts(settings, gusts)
        return observed(Shot(settings), cloth_of(settings), self.camera, SETTLE, LENGTH)

    @functools.cached_property
    def long_runs(self) -> list[LongRun]:
        """Return the reference's long runs, on the middle grid."""
        path = self.folder / 'long_runs.npz'
        if not path.exists():
            settings = exact(self.scene, *self.middle)
            runs = [self.long_run(settings, gusts) for gusts in range(RUNS)]
            np.savez(path, **{f'{name}{i}': value for i, run in enumerate(runs)
                              for name, value in run._asdict().items()})
        with np.load(path) as kept:
            return [LongRun(*(kept[f'{name}{i}'] for name in LongRun._fields))
                    for i in range(RUNS)]

    def behave(self, settings: Settings, runs: int = RUNS // 2) -> dict:
        """
        Return a row: each of STATISTICS, and all together, in the reference's own scatter.

        energy_j, frequency_hz: mean kinetic energy and the fly's dominant frequency; None where
        the run diverged.
        """
        self.warm_up(settings)
        found = [self.long_run(settings, gusts) for gusts in range(runs)]
        row = behaves(found, self.long_runs)
        whole = None not in found
        return {'behaves': together(row), **row,
                'energy_j': rms([math.sqrt(run.energy.mean()) for run in found])**2
                if whole else None,
                'frequency_hz': float(np.mean([dominant_frequency(run) for run in found]))
                if whole else None}

    def own_scatter(self) -> float:
        """Return by how much `behaves` of the reference's own runs differs (see behaves)."""
        return own_scatter(self.long_runs)

    @functools.cached_property
    def at_rest(self) -> rests.Rest:
        """Return how the reference of long runs rests: what statics says, but for its error."""
        settings = exact(self.scene, *self.middle)
        return rests.rest(Shot(settings), cloth_of(settings))

    def rest(self, settings: Settings) -> dict:
        """Return a row: residual speed [mm/s], and how much deeper than statics it hangs [mm]."""
        self.warm_up(settings)
        found = rests.rest(Shot(settings), cloth_of(settings))
        return {'rests': found.speed, 'sag_mm': 1e3 * (found.depth - self.at_rest.depth)}

    @functools.cache
    def horizon(self, seconds: float = 0.6) -> float | None:
        """
        Return when two converged runs part [s], None if not within so many seconds.

        A grid of FINEST as it is, and by a method of higher order; unrelated are two windows.
        """
        reference, grid = self.reference(), reference_grid(self.scene, LARGEST_WORK, FINEST)
        first, second = reference.window(0), reference.window(1)
        frames = list(range(1, reference.shot.frames(seconds) + 1))
        runs = [follows.ends(reference.shot, reference.start(first, changed(
            exact(self.scene, *grid), {'solver': solver})), first.frame, frames)
            for solver in ('symplectic', 'verlet')]
        apart = [rms(pixel_distances(*pair, self.camera)) for pair in zip(*runs)]
        unrelated = rms(pixel_distances(second.positions, first.positions, self.camera))
        return follows.horizon([count * reference.shot.dt for count in frames], apart, unrelated)
