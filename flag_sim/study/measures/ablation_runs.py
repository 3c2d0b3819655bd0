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
import contextlib
import functools
import math
import time

from flag_sim.cloth import Cloth, Diverged
from flag_sim.cloth.mesh import resample
from flag_sim.declarations.factories import cloth_of, look_of
from flag_sim.drawing import Camera, Picture
from flag_sim.study.measures import errors, summary
from flag_sim.study.measures.ablation_terms import settings_of, SHOTS, Term
from flag_sim.study.measures.behaves import behaves, together
from flag_sim.study.measures.follows import HORIZONS
from flag_sim.study.measures.judge import LENGTH, SETTLE
from flag_sim.study.measures.long_run import LongRun, observed
from flag_sim.study.measures.reference import Shot, Window
from flag_sim.study.measures.rests import rest
from flag_sim.study.measures.settings import changed, DEFAULTS, rendered, Settings
import numpy as np

SPIN_UP = 3.0  # until the first window: the flag, laid out flat, has then fallen into the wind [s]
WINDOWS = 6
SPACING = 0.7  # from one window to the next [s]
WINDOW = HORIZONS[2]  # length of a window [s]
SEEDS = 3  # of the gusts, for the long runs with a term; without it one less
GUSTS = 0.3  # intensity for the long runs of a steady shot: else they would all be the same run
REPEATS = 15  # frames that are timed, of each of both runs in turn
VISIBLE = 3
"""Levels of 255 by which a channel of a pixel must change for the pixel to count as changed."""


def in_gusts(settings: Settings, gusts: int) -> Shot:
    """Return the shot of settings for long runs, whose gust.seed is higher by `gusts`."""
    return Shot(changed(settings, {
        'gust.intensity': settings['gust.intensity'] or GUSTS,
        'gust.seed': settings['gust.seed'] + gusts}))


def seen_by(settings: Settings) -> Camera:
    """Return the camera of settings."""
    return look_of(settings).camera


@functools.lru_cache(maxsize=len(SHOTS))
def runs_with(settings: tuple) -> list[LongRun | None]:
    """
    Return the long runs with a term, of the items of its settings.

    They are the same for all terms that are on by default, in one shot: so they are kept.
    """
    scene = dict(settings)
    return [observed(in_gusts(scene, gusts), cloth_of(scene), seen_by(scene), SETTLE, LENGTH)
            for gusts in range(SEEDS)]


class AblationRuns:
    """
    The runs with and without a Term, in this order, of a scene {parameter: value}.

    Where the run with the term has the finer grid, all nodes of the other one are among its nodes.
    """

    def __init__(self, term: Term, scene: Settings):
        with_it, without = self.settings = settings_of(term, scene)
        self.term = term
        self.shots = Shot(with_it), Shot(without)
        self.grid = without['grid.rows'], without['grid.columns']
        self.moves = bool(term.offset or term.replace) or self.differ('physics', 'wind')

    def differ(self, *nodes: str) -> bool:
        """Return whether the settings differ in a parameter of these nodes."""
        one, other = self.settings
        return any(one[name] != other[name] for node in nodes for name in DEFAULTS[node])

    def starts(self, count: int = WINDOWS) -> list[Window]:
        """Return the first Windows of one run with the term, without their ends."""
        cloth, frame, found = cloth_of(self.settings[0]), 0, []
        for number in range(count):
            last, frame = frame, self.shots[0].frames(SPIN_UP + number * SPACING)
            self.shots[0].play(cloth, last, frame)
            found.append(Window(frame, cloth.positions, cloth.velocities, None))
        return found

    def cloth(self, which: int) -> Cloth:
        """Return the cloth of one of both runs, laid out flat."""
        cloth = cloth_of(self.settings[which])
        if not which:
            return cloth
        if self.term.replace:
            cloth = self.term.replace(cloth)
        positions = cloth.positions
        positions[:, 1:] += self.term.offset
        cloth.place(positions, cloth.velocities)
        return cloth

    def begin(self, which: int, start: Window) -> Cloth:
        """Return the cloth of one of both runs at a window's start."""
        cloth = self.cloth(which)
        positions, velocities = start.positions, start.velocities
        if which:
            positions, velocities = (resample(values, *self.grid)
                                     for values in (positions, velocities))
            positions[:, 1:] += self.term.offset
        cloth.place(positions, velocities)
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

    def measured(self) -> dict:
        """
        Return a row of numbers; None where the motion is the same, or diverged.

        px_rms, px_worst: at the windows' ends, as the camera sees it; behaves: of the runs
        without, by those with the term (see behaves); rests: residual speed without it [mm/s];
        levels (mean absolute), changed (share of pixels): of the pictures at the windows' ends;
        ms and spread_ms with and without: median and interquartile range of a frame's processor
        time, of the physics or the drawing or both, whichever has other parameters; None if they
        tell nothing.
        """
        row = dict.fromkeys(('px_rms', 'px_worst', 'behaves', 'rests'))
        starts = self.starts()
        ends = [self.ends(start) if self.moves else (start.positions, start.positions)
                for start in starts]
        ends = [pair for pair in ends if pair[1] is not None]
        if self.moves and ends:
            apart = np.concatenate([self._pixels(*pair) for pair in ends])
            row |= {'px_rms': summary.rms(apart), 'px_worst': float(apart.max())}
            row |= self._sound()
        times = self.times(starts[-1])
        return row | self._pictures(ends) | (dict.fromkeys(times) if self.term.replace else times)

    def _pixels(self, one, other):
        """Return how far apart the common nodes are in the picture [pixel]."""
        return errors.pixel_distances(other, resample(one, *self.grid),
                                      look_of(self.settings[0]).camera)

    def _sound(self):
        """Return how the flag behaves and rests without the term; inf where it diverges."""
        scene, other = self.settings
        with_it = runs_with(tuple((name, tuple(value) if isinstance(value, list) else value)
                                  for name, value in scene.items()))
        without = [observed(in_gusts(other, gusts), self.cloth(1), seen_by(scene), SETTLE, LENGTH)
                   for gusts in range(SEEDS - 1)]
        number = math.inf if None in with_it else together(behaves(without, with_it))
        return {'behaves': number, 'rests': rest(self.shots[1], self.cloth(1)).speed}

    def _pictures(self, ends):
        """Return by how much the pictures of both runs differ at all the windows' ends."""
        row = dict.fromkeys(('levels', 'changed'))
        if not ends:
            return row
        one, other = ([rendered(settings, positions) for positions in run]
                      for settings, run in zip(self.settings, zip(*ends)))
        apart = np.abs(np.int16(one) - np.int16(other))
        values = apart.mean(), (apart.max(axis=-1) >= VISIBLE).mean()
        return dict(zip(row, map(float, values)))

    def times(self, start: Window) -> dict:
        """Return medians and interquartile ranges [ms] of one frame, taken in turns."""
        looks = [look_of(settings) for settings in self.settings]
        pictures = [Picture(settings['drawing.threads']) for settings in self.settings]
        times = [], []
        # Another grid is also drawn; the first turn compiles, and does not count.
        draws = self.differ('renderer') or self.settings[0]['grid.rows'] != self.grid[0]
        for _ in range(1 + REPEATS):
            for which, shot in enumerate(self.shots):
                cloth = self.begin(which, start)
                self._move(cloth, shot, start.frame + 1)  # makes ready what is then kept
                begin = time.process_time()
                self._move(cloth, shot, start.frame + 2)
                normals = cloth.normals()
                if draws:
                    pictures[which].draw(cloth.positions, normals, *looks[which])
                times[which].append(1e3 * (time.process_time() - begin))
        row = {}
        for name, some in zip(('with', 'without'), times):
            low, median, high = np.percentile(some[1:], [25, 50, 75])
            row |= {f'ms_{name}': float(median), f'spread_ms_{name}': float(high - low)}
        return row

    def _move(self, cloth, shot, frame):
        """Move a cloth to a frame from the one before, if the term has to do with its motion."""
        if self.moves:
            with contextlib.suppress(Diverged):  # it took its time all the same
                cloth.advance(shot.dt, shot.wind(frame))
