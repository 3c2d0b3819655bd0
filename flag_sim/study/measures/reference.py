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
A shot to measure on; and references: the same sheet on a fine grid, its states all along a shot.

The motion is chaotic, so that two simulations, however exact, part within a second. They are
therefore compared as forecasts are: over short windows, each of which starts from a state of the
reference. The grids are nested: each node of a coarser one is a node of the finest, whose state
it takes as it is.

The shot is played on the middle grid, every second node of the finest; the last LEAD seconds
before a window are played on the finest itself, so that its own small wrinkles are there.
"""
from collections.abc import Iterator
from pathlib import Path
import time
from typing import NamedTuple

from flag_sim.animation.gusts import Gusts
from flag_sim.animation.wind_vector import wind_vector
from flag_sim.cloth import Cloth, Diverged
from flag_sim.cloth.mesh import resample
from flag_sim.cloth.stability import SHORTEST_STEP
from flag_sim.declarations.factories import cloth_of
from flag_sim.study.measures.settings import changed, RANGES, Settings
from flag_sim.study.measures.stability_trial import largest_step
import numpy as np

FINEST = (81, 121)  # rows and columns of the finest grid: four times as fine as the default
EXACT = {'solver': 'symplectic', 'substeps': 0, 'step_safety': 0.9,
         'substeps_limit': RANGES['substeps_limit'][1]}
"""How a reference takes its steps: as many as it needs."""
SPIN_UP = 2.0  # until the first window: the flag, laid out flat, has then fallen into the wind [s]
SPACING = 1.0  # from one window to the next [s]
LEAD = 0.2  # on the finest grid before a window [s]


class Shot:
    """
    The wind of settings (see settings.WIND_DEFAULTS), frame by frame.

    Within a frame the wind is steady, as it is for the physics node.
    """

    def __init__(self, settings: Settings):
        self.dt = 1.0 / settings['rate']
        self._speed = settings['speed']
        self._direction = settings['azimuth'], settings['elevation']
        self._intensity = settings['gust.intensity']
        self._gusts = Gusts(settings['gust.length'], settings['gust.seed'])

    def frames(self, seconds: float) -> int:
        """Return how many frames there are in seconds."""
        return round(seconds / self.dt)

    def wind(self, frame: int) -> np.ndarray:
        """Return the wind in the frame of that number: (3,) [m/s]."""
        gust = self._intensity * self._gusts.at(self._speed * frame * self.dt)
        return wind_vector(self._speed, *self._direction, gust)

    def play(self, cloth: Cloth, first: int, last: int) -> None:
        """Move a cloth through the frames first + 1 .. last; raises Diverged."""
        for frame in range(first + 1, last + 1):
            cloth.advance(self.dt, self.wind(frame))

    def timed(self, cloth: Cloth, first: int, last: int) -> Iterator[float]:
        """Yield each frame's processor time [ms], as play goes on; end early if it diverges."""
        for frame in range(first + 1, last + 1):
            wind, begin = self.wind(frame), time.process_time()
            try:
                cloth.advance(self.dt, wind)
            except Diverged:
                return
            yield 1e3 * (time.process_time() - begin)


class Window(NamedTuple):
    """A state of the reference, and where it is after each of the following frames."""

    frame: int              # number of the frame that it starts from
    positions: np.ndarray   # (rows, columns, 3) [m]
    velocities: np.ndarray  # (rows, columns, 3) [m/s]
    ends: np.ndarray        # (frames, rows, columns, 3) [m]


def nested(finest: tuple[int, int]) -> list[tuple[int, int]]:
    """Return the grids (rows, columns) that are nested in the finest, from coarse to fine."""
    rows, columns = finest[0] - 1, finest[1] - 1
    return [(rows // every + 1, columns // every + 1) for every in range(columns // 2, 1, -1)
            if rows % every == 0 and columns % every == 0 and rows // every >= 2]


def on_grid(settings: Settings, rows: int, columns: int, **changes) -> Settings:
    """
    Return settings, also changed otherwise, for the same sheet on another grid.

    The parameter `damping` is a ratio to the critical damping of one spring, whose dashpot for a
    given ratio is proportional to the spacing; so that the sheet keeps its dashpots, the ratio is
    scaled with the number of intervals.
    """
    scale = (columns - 1) / (settings['grid.columns'] - 1)
    return changed(settings, {'grid.rows': rows, 'grid.columns': columns,
                              'damping': settings['damping'] * scale, **changes})


def steps(settings: Settings) -> float:
    """Return how many steps exact settings take for a second of motion."""
    cloth = cloth_of(settings)
    step = largest_step('symplectic', cloth.material, cloth.air, cloth.mesh)
    return max(settings['rate'], 1.0 / (settings['step_safety'] * step))


def exact(settings: Settings, rows: int, columns: int) -> Settings:
    """
    Return settings of the same sheet for a reference on a grid.

    In single precision, which takes half the time and differs by hundredths of a pixel until
    chaos takes over, but where it would lose the steps in rounding.
    """
    single = on_grid(settings, rows, columns, **EXACT, precision='float32')
    # Each frame has a whole number of steps, one more at most.
    lost = (steps(single) + settings['rate']) * SHORTEST_STEP['float32'] > 1.0
    return changed(single, {'precision': 'float64'}) if lost else single


class Reference:
    """
    The windows of a shot, computed when they are asked for.

    settings: of the shot and of the sheet. frames: length of a window. folder: where windows are
    kept from run to run. finest: rows and columns of the grid.
    """

    def __init__(self, settings: Settings, frames: int, folder: Path, finest: tuple[int, int]):
        self.settings = settings
        self.shot = Shot(settings)
        self.frames = frames
        self.finest = finest
        self.folder = folder
        self._windows = {}
        self._middle = self._frame = None  # the cloth on the middle grid, and its frame

    def window(self, number: int) -> Window:
        """Return a window."""
        if number not in self._windows:
            path = self._path(number)
            if not path.exists():
                path.parent.mkdir(exist_ok=True)
                unfinished = path.with_name('unfinished.npz')
                np.savez(unfinished, **self._computed(number)._asdict())
                unfinished.replace(path)
            with np.load(path) as kept:
                window = Window(**kept)
            self._windows[number] = window._replace(frame=int(window.frame))
        return self._windows[number]

    def start(self, window: Window, settings: Settings) -> Cloth:
        """Return the Cloth of settings in the state of a window's start: exact on nested grids."""
        cloth = cloth_of(settings)
        cloth.place(*(resample(values, cloth.mesh.rows, cloth.mesh.columns)
                      for values in (window.positions, window.velocities)))
        return cloth

    def _computed(self, number):
        """Return a window; the cloth on the middle grid moves on from the last one, if it can."""
        frame = self.shot.frames(SPIN_UP + number * SPACING)
        begin = frame - self.shot.frames(LEAD)
        rows, columns = ((count + 1) // 2 for count in self.finest)
        if self._middle is None or self._frame > begin:
            self._middle, self._frame = cloth_of(exact(self.settings, rows, columns)), 0
        self.shot.play(self._middle, self._frame, begin)
        self._frame = begin
        cloth = cloth_of(exact(self.settings, *self.finest))
        cloth.place(*(resample(values, *self.finest)
                      for values in (self._middle.positions, self._middle.velocities)))
        self.shot.play(cloth, begin, frame)
        start, ends = (cloth.positions, cloth.velocities), []
        for after in range(frame, frame + self.frames):
            self.shot.play(cloth, after, after + 1)
            ends.append(cloth.positions)
        return Window(frame, *start, np.array(ends))

    def _path(self, number):
        return self.folder / f'window{number}.npz'
