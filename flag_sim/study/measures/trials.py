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
from flag_sim.declarations.making import look_of
from flag_sim.study.measures.errors import Measure, measured, MOTION, PICTURE, resized
from flag_sim.study.measures.reference import (
    FINEST, MILLI, nested, on_grid, Reference, Window)
from flag_sim.study.measures.settings import changed, defaults, picture_of, Settings
import numpy as np

BEST = {'samples': 16, 'interpolation': 'perspective', 'hidden_surface': 'zbuffer',
        'shading': 'gouraud', 'outline': False, 'drawing.threads': 1}
"""How the reference picture is drawn."""
TIMED = 3  # frames whose median time counts


class Trials:
    """
    Compares settings with a Reference, as the camera of `base` settings sees both.

    frames: after how many frames of a window. Compiles what it meets for the first time before
    it measures.
    """

    def __init__(self, reference: Reference, base: Settings, frames: int = 1):
        self.reference = reference
        self.base = base
        self.frames = frames
        self.camera = look_of(base).camera
        self._compiled = set()
        self._drawn = {}

    def start(self, settings: Settings, window: Window) -> Cloth:
        """Return the Cloth of settings at a window's start, with all compiled that moves it."""
        method = settings['solver'], settings['precision']
        if method not in self._compiled:
            self._compiled.add(method)
            self.reference.start(window, settings).advance(1e-6)
        return self.reference.start(window, settings)

    def motion(self, settings: Settings, window: Window) -> tuple[dict, np.ndarray | None]:
        """
        Run settings through a window; return a row of numbers and where it ended.

        MOTION: at all nodes of the finest grid. physics_ms: the median of TIMED frames after the
        window, when what it needs is in the caches. stiffness: what the steps left of it. If the
        run diverged all are None, and so are the positions.
        """
        cloth, last = self.start(settings, window), window.frame + self.frames
        times, positions = [], None
        for steps, taken in self.reference.shot.timed(cloth, window.frame, last + TIMED):
            begin = time.perf_counter()
            cloth.normals()
            times.append(taken + MILLI * (time.perf_counter() - begin))
            if len(times) == self.frames:
                positions = cloth.positions
        if len(times) < self.frames + TIMED:
            return dict.fromkeys((*MOTION, 'physics_ms', 'substeps', 'stiffness')), None
        row = measured(MOTION, self.reference.filled(positions), self._end(window), self.camera)
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
        picture, look = picture_of(settings), look_of(settings)
        picture.draw(positions, None, *look)
        times = []
        for _ in range(TIMED):
            begin = time.perf_counter()
            frame = picture.draw(positions, None, *look)
            times.append(MILLI * (time.perf_counter() - begin))
        return {'drawing_ms': sorted(times)[TIMED // 2],
                **self._likeness(measures, frame.colour, window)}

    def row(self, settings: Settings, window: Window, measures: dict = PICTURE) -> dict:
        """Return the numbers of motion and picture."""
        row, positions = self.motion(settings, window)
        return row | self.picture(settings, positions, window, measures)

    def still(self, settings: Settings, window: Window) -> dict:
        """Return what drawing the reference's own vertices by settings does to the picture."""
        image = picture_of(settings).draw(self._end(window), None, *look_of(settings)).colour
        return {f'drawing_{name}': value
                for name, value in self._likeness(PICTURE, image, window).items()}

    def _likeness(self, measures, image, window):
        """Return measures of an image, shown at the size of the reference's picture."""
        right = self._right(window)
        return measured(measures, resized(image, *right.shape[:2]), right)

    def _end(self, window):
        """Return where the reference is at the end of a window: (rows, columns, 3) [m]."""
        return window.ends[self.frames - 1]

    def _right(self, window):
        """Return the reference's picture."""
        if window.frame not in self._drawn:
            best = changed(self.base, BEST)
            self._drawn[window.frame] = picture_of(best).draw(
                self._end(window), None, *look_of(best)).colour.copy()
        return self._drawn[window.frame]


BASE = defaults(gust__intensity=0.3)
"""The defaults, in gusty wind: in a steady one all windows would be much alike."""
LONG = 3  # frames of a window, 0.1 s; errors are ranked after the first of them


@functools.lru_cache(maxsize=1)
def base_trials(folder: Path) -> Trials:
    """Return the Trials of a study in a folder, on BASE."""
    return Trials(Reference(BASE, LONG, folder / 'windows', FINEST), BASE)


def windows(folder: Path) -> list[int]:
    """Return the numbers of the windows that are there, one after the other."""
    reference = base_trials(folder).reference
    found = []
    while reference.has(len(found)):
        found.append(len(found))
    return found


def with_grid(columns: int, **changes) -> Settings:
    """Return BASE for the same sheet on the nested grid of so many columns, otherwise changed."""
    (rows,) = [rows for rows, count in nested(FINEST) if count == columns]
    return changed(on_grid(BASE, rows, columns), changes)


def finer() -> Settings:
    """Return BASE on the grid that is twice as fine."""
    return with_grid(2 * BASE['grid.columns'] - 1)


def coarser() -> Settings:
    """Return BASE on the grid that is half as fine."""
    return with_grid((BASE['grid.columns'] + 1) // 2)
