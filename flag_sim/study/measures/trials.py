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

"""A trial: settings that run through a window, timed, and measured against the reference."""
import functools
from pathlib import Path
import time

from flag_sim.cloth import Cloth
from flag_sim.cloth.stability import Plan
from flag_sim.declarations.factories import look_of
from flag_sim.drawing import Picture
from flag_sim.study.measures.errors import Measure, measured, MOTION, PICTURE, resized
from flag_sim.study.measures.reference import FINEST, on_grid, Reference, Window
from flag_sim.study.measures.settings import changed, defaults, rendered, Settings
import numpy as np

BEST = {'samples': 16, 'interpolation': 'perspective', 'hidden_surface': 'zbuffer',
        'shading': 'gouraud', 'outline': False, 'drawing.threads': 1}
"""How the reference picture is drawn."""
TIMED = 3  # frames whose median time counts


class Trials:
    """
    Compares settings with a Reference, as the camera of `base` settings sees both.

    frames: after how many frames of a window. Whatever has to be compiled is compiled before it is
    timed.
    """

    def __init__(self, reference: Reference, base: Settings, frames: int = 1):
        self.reference = reference
        self.base = base
        self.frames = frames
        self.camera = look_of(base).camera
        self._compiled = set()
        self._best_pictures = {}

    def start(self, settings: Settings, window: Window) -> Cloth:
        """Return the Cloth of settings at a window's start, with all compiled that moves it."""
        method = settings['solver'], settings['precision']
        if method not in self._compiled:
            self._compiled.add(method)
            self.reference.start(window, settings).advance(1e-6)
        return self.reference.start(window, settings)

    def run(self, settings: Settings, window: Window, frames: int,
            disturbance: np.ndarray | float = 0.0) -> tuple[list, list, Plan]:
        """
        Run settings through frames from a window's start, moved by a disturbance [m].

        Return the positions (rows, columns, 3) [m] after each frame, each frame's time [ms],
        normals included, and the last Plan of steps; fewer frames if the run diverged.
        """
        cloth, ends, times, steps = self.start(settings, window), [], [], None
        cloth.place(cloth.positions + disturbance, cloth.velocities)
        for steps, taken in self.reference.shot.timed(cloth, window.frame, window.frame + frames):
            begin = time.perf_counter()
            cloth.normals()
            times.append(taken + 1e3 * (time.perf_counter() - begin))
            ends.append(cloth.positions)
        return ends, times, steps

    def motion(self, settings: Settings, window: Window) -> tuple[dict, np.ndarray | None]:
        """
        Run settings through a window; return a row of numbers and where it ended.

        MOTION: at all nodes of the finest grid. physics_ms: the median of TIMED frames after the
        window, when what it needs is in the caches. stiffness: what the steps left of it. If the
        run diverged all are None, and so are the positions.
        """
        ends, times, steps = self.run(settings, window, self.frames + TIMED)
        if len(times) < self.frames + TIMED:
            return dict.fromkeys((*MOTION, 'physics_ms', 'substeps', 'stiffness')), None
        positions = ends[self.frames - 1]
        row = measured(MOTION, self.reference.on_finest(positions), self._end(window), self.camera)
        return {**row, 'physics_ms': sorted(times[self.frames:])[TIMED // 2],
                'substeps': steps.granted, 'stiffness': steps.stiffness_factor}, positions

    def picture(self, settings: Settings, positions: np.ndarray | None, window: Window,
                measures: dict[str, Measure] = PICTURE) -> dict:
        """
        Draw the positions that settings came to; return a row of numbers, None where none.

        drawing_ms: the median of TIMED; measures: against the reference's picture.
        """
        if positions is None:
            return dict.fromkeys(('drawing_ms', *measures))
        picture, look = Picture(settings['drawing.threads']), look_of(settings)
        times = []
        for _ in range(1 + TIMED):  # the first compiles, and does not count
            begin = time.perf_counter()
            frame = picture.draw(positions, None, *look)
            times.append(1e3 * (time.perf_counter() - begin))
        return {'drawing_ms': sorted(times[1:])[TIMED // 2],
                **self._likeness(measures, frame.colour, window)}

    def row(self, settings: Settings, window: Window, measures: dict = PICTURE) -> dict:
        """Return the numbers of motion and picture."""
        row, positions = self.motion(settings, window)
        return row | self.picture(settings, positions, window, measures)

    def still(self, settings: Settings, window: Window) -> dict:
        """Return what drawing the reference's own vertices by settings does to the picture."""
        found = self._likeness(PICTURE, rendered(settings, self._end(window)), window)
        return {f'drawing_{name}': value for name, value in found.items()}

    def _likeness(self, measures, image, window):
        """Return measures of an image, shown at the size of the reference's picture."""
        if window.frame not in self._best_pictures:
            self._best_pictures[window.frame] = rendered(
                changed(self.base, BEST), self._end(window))
        best = self._best_pictures[window.frame]
        return measured(measures, resized(image, *best.shape[:2]), best)

    def _end(self, window):
        """Return where the reference is at the end of a window: (rows, columns, 3) [m]."""
        return window.ends[self.frames - 1]


BASE = defaults(gust__intensity=0.3)
"""The defaults, in gusty wind: in a steady one all windows would be much alike."""
LONG = 3  # frames of a window, 0.1 s; errors are ranked after the first of them


@functools.lru_cache(maxsize=1)
def base_trials(folder: Path) -> Trials:
    """Return the Trials of a study in a folder, on BASE."""
    return Trials(Reference(BASE, LONG, folder / 'windows', FINEST), BASE)


def window_numbers(folder: Path) -> list[int]:
    """Return the numbers of the windows that are there, one after the other."""
    reference = base_trials(folder).reference
    found = []
    while reference.has(len(found)):
        found.append(len(found))
    return found


def rows_for(columns: int) -> int:
    """Return the rows of the grid of so many columns, whose cells are shaped as FINEST's are."""
    return (columns - 1) * (FINEST[0] - 1) // (FINEST[1] - 1) + 1


def with_grid(columns: int, **changes) -> Settings:
    """Return BASE for the same sheet on the grid of so many columns, otherwise changed."""
    return on_grid(BASE, rows_for(columns), columns, **changes)


def finer() -> Settings:
    """Return BASE on the grid that is twice as fine."""
    return with_grid(2 * BASE['grid.columns'] - 1)


def coarser() -> Settings:
    """Return BASE on the grid that is half as fine."""
    return with_grid((BASE['grid.columns'] + 1) // 2)
