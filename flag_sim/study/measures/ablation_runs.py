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

"""Two runs, with a term and without it, that begin from the same states."""
import time

from flag_sim.cloth import Cloth, Diverged
from flag_sim.declarations.making import cloth_of, look_of
from flag_sim.study.measures import errors, summary
from flag_sim.study.measures.ablation_terms import settings_of, Term
from flag_sim.study.measures.reference import MILLI, Shot, Window
from flag_sim.study.measures.settings import DEFAULTS, picture_of, Settings
import numpy as np

SPIN_UP = 3.0  # until the first window: the flag, laid out flat, has then fallen into the wind [s]
WINDOWS = 6
SPACING = 0.7  # from one window to the next [s]
WINDOW = 0.3
"""Length of a window [s]: the control's runs are then still within a thousandth of a pixel."""
LONG = 20.0  # of the long run [s]; its first SPIN_UP seconds do not count
REPEATS = 15  # frames that are timed, of each of both runs in turn
VISIBLE = 3
"""Levels of 255 by which a channel of a pixel must change for the pixel to count as changed."""


class AblationRuns:
    """
    The runs with and without a Term, in this order, of a scene {parameter: value}.

    Where the run with the term has the finer grid, the other one, whose nodes are all among its
    nodes, takes every second of its nodes.
    """

    def __init__(self, term: Term, scene: Settings):
        on, off = self.settings = settings_of(term, scene)
        self.term = term
        self.shots = (Shot(on), Shot(off))
        self.every = (on['grid.columns'] - 1) // (off['grid.columns'] - 1)
        self.moves = bool(term.nudge or term.remake) or self.differ('physics', 'wind')

    def differ(self, *nodes: str) -> bool:
        """Return whether the settings differ in a parameter of these nodes."""
        on, off = self.settings
        return any(on[name] != off[name] for node in nodes for name in DEFAULTS[node])

    def starts(self, count: int = WINDOWS) -> list[Window]:
        """Return the first Windows of one run with the term, without their ends."""
        cloth, at, found = cloth_of(self.settings[0]), 0, []
        for number in range(count):
            frame = self.shots[0].frames(SPIN_UP + number * SPACING)
            self.shots[0].play(cloth, at, frame)
            found.append(Window(frame, cloth.positions, cloth.velocities, None))
            at = frame
        return found

    def begin(self, which: int, start: Window) -> Cloth:
        """Return the cloth of one of both runs at a window's start."""
        cloth = cloth_of(self.settings[which])
        if which and self.term.remake:
            cloth = self.term.remake(cloth)
        every = self.every if which else 1
        positions = start.positions[::every, ::every].copy()
        positions[:, 1:] += self.term.nudge * which
        cloth.place(positions, start.velocities[::every, ::every])
        return cloth

    def ends(self, start: Window, seconds: float = WINDOW) -> tuple:
        """Return the positions of both some time after a start; None for one that diverged."""
        found = []
        for which, shot in enumerate(self.shots):
            cloth = self.begin(which, start)
            try:
                shot.play(cloth, start.frame, start.frame + shot.frames(seconds))
                found.append(cloth.positions)
            except Diverged:
                found.append(None)
        return tuple(found)

    def common(self, on: np.ndarray, off: np.ndarray) -> tuple:
        """Return positions (rows, columns, 3) [m] of both runs at the nodes that both have."""
        return on[::self.every, ::self.every], off

    def measured(self) -> dict:
        """
        Return a row of numbers; None where the motion is the same, or diverged.

        px_rms, px_worst: at the windows' ends, as the camera sees it; shape_px: RMS distance of
        the mean shapes; energy: mean kinetic energy without, over with; psnr_db, ssim, levels
        (mean absolute), changed (share of pixels): of the pictures at the windows' ends; ms and
        spread_ms with and without: median and interquartile range of a frame's time, of the
        physics or the drawing or both, whichever has other parameters; None if they tell nothing.
        """
        row = dict.fromkeys(('px_rms', 'px_worst', 'shape_px', 'energy'))
        starts = self.starts()
        ends = [self.ends(start) if self.moves else (start.positions, start.positions)
                for start in starts]
        camera = look_of(self.settings[0]).camera
        whole = [end for end in ends if end[1] is not None]
        if self.moves and whole:
            apart = np.concatenate([errors.pixel_distances(off, on, camera) for on, off in
                                    (self.common(*end) for end in whole)])
            row |= {'px_rms': summary.rms(apart), 'px_worst': float(apart.max())}
            row |= self._long(starts[0], camera)
        times = self.times(starts[-1])
        return row | self._pictures(whole) | (dict.fromkeys(times) if self.term.remake else times)

    def _long(self, start, camera):
        """Return shape_px and energy of the long runs, None where one diverged."""
        runs = [shot.long_run(self.begin(which, start), start.frame, SPIN_UP, LONG - SPIN_UP)
                for which, shot in enumerate(self.shots)]
        if None in runs:
            return {'shape_px': None, 'energy': None}
        on, off = self.common(*(run.shape for run in runs))
        return {'shape_px': summary.rms(errors.pixel_distances(off, on, camera)),
                'energy': sum(runs[1].energies) / sum(runs[0].energies)}

    def _pictures(self, ends):
        """Return by how much the pictures of both runs differ at all the windows' ends."""
        row = dict.fromkeys(('psnr_db', 'ssim', 'levels', 'changed'))
        if not ends:
            return row
        on, off = ([picture_of(one).draw(end[which], None, *look_of(one)).colour for end in ends]
                   for which, one in enumerate(self.settings))
        apart = np.abs(np.int16(on) - np.int16(off))
        ssims = [errors.ssim(*pair) for pair in zip(off, on)]
        values = (errors.psnr(np.concatenate(off), np.concatenate(on)), np.mean(ssims),
                  apart.mean(), (apart.max(axis=-1) >= VISIBLE).mean())
        return dict(zip(row, map(float, values)))

    def times(self, start: Window) -> dict:
        """Return medians and interquartile ranges [ms] of one frame, taken in turns."""
        looks = [look_of(settings) for settings in self.settings]
        drawn = [picture_of(settings) for settings in self.settings]
        taken = ([], [])
        # Another grid is also drawn; the first turn compiles, and does not count.
        draws = self.differ('renderer') or self.every > 1
        for _ in range(REPEATS + 1):
            for which, shot in enumerate(self.shots):
                cloth = self.begin(which, start)
                wind = shot.wind(start.frame + 1)
                begin = time.perf_counter()
                if self.moves:
                    try:
                        cloth.advance(shot.dt, wind)
                    except Diverged:
                        pass  # it took its time all the same
                normals = cloth.normals()
                if draws:
                    drawn[which].draw(cloth.positions, normals, *looks[which])
                taken[which].append(MILLI * (time.perf_counter() - begin))
        row = {}
        for name, times in zip(('with', 'without'), taken):
            low, median, high = np.percentile(times[1:], [25, 50, 75])
            row |= {f'ms_{name}': float(median), f'spread_ms_{name}': float(high - low)}
        return row
