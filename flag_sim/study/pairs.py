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

from flag_sim.cloth import Diverged
from flag_sim.cloth.energy import kinetic_energy
from flag_sim.cloth.model import Model
from flag_sim.dials.settings import cloth_of, look_of
from flag_sim.study import error
from flag_sim.study.settings import picture_of
from flag_sim.study.shot import Shot
import numpy as np

SPIN_UP = 3.0
"""Until the first window: the flag, laid out flat, has then fallen into the wind [s]."""
WINDOWS = 6
SPACING = 0.7
"""From one window to the next [s]."""
WINDOW = 0.3
"""Length of a window [s]: the control's runs are then still within a thousandth of a pixel."""
LONG = 20.0
"""Of the long run [s]; its first SPIN_UP seconds do not count."""
REPEATS = 15
"""Frames that are timed, of each of both runs in turn."""


class Start:
    """A moment of the run with the term: its frame, and the cloth's state then."""

    def __init__(self, frame, cloth):
        self.frame = frame
        self.positions = cloth.positions
        self.velocities = cloth.velocities


class Pairs:
    """
    Runs with and without a term that begin together.

    Where the run with the term has the finer grid, the other one, whose nodes are all among its
    nodes, takes every second of its nodes. nudge, remake: of the run without it (see Term).
    """

    def __init__(self, on, off, nudge=0.0, remake=None):
        self.settings = (on, off)
        self.shots = (Shot(on), Shot(off))
        self.nudge = nudge
        self.remake = remake
        self.every = (on['grid.columns'] - 1) // (off['grid.columns'] - 1)

    def frames(self, seconds):
        """Return how many frames there are in seconds."""
        return round(seconds / self.shots[0].dt)

    def starts(self, count=WINDOWS):
        """Return the Starts of the first windows, from one run with the term."""
        cloth, at, found = cloth_of(self.settings[0]), 0, []
        for number in range(count):
            frame = self.frames(SPIN_UP + number * SPACING)
            self.shots[0].play(cloth, at, frame)
            found.append(Start(frame, cloth))
            at = frame
        return found

    def begin(self, which, start):
        """Return the cloth of one of both runs at a Start."""
        cloth = cloth_of(self.settings[which])
        if which and self.remake:
            cloth = self.remake(cloth)
        every = self.every if which else 1
        positions = start.positions[::every, ::every].copy()
        positions[:, 1:] += self.nudge * which
        cloth.place(positions, start.velocities[::every, ::every])
        return cloth

    def ends(self, start, seconds=WINDOW):
        """Return the positions of both some time after a Start; None for one that diverged."""
        found = []
        for which in range(2):
            cloth = self.begin(which, start)
            try:
                self.shots[which].play(cloth, start.frame, start.frame + self.frames(seconds))
                found.append(cloth.positions)
            except Diverged:
                found.append(None)
        return tuple(found)

    def common(self, on, off):
        """Return positions of both runs at the nodes that both have."""
        return on[::self.every, ::self.every], off

    def statistics(self, start, camera):
        """Return shape_px and energy of the long runs, None where one diverged."""
        shapes, energies = [], []
        for which, shot in enumerate(self.shots):
            cloth = self.begin(which, start)
            model = Model(cloth.mesh, cloth.material)
            positions, energy, count = 0.0, 0.0, 0
            for frame in range(start.frame, start.frame + self.frames(LONG)):
                try:
                    shot.play(cloth, frame, frame + 1)
                except Diverged:
                    return {'shape_px': None, 'energy': None}
                if frame - start.frame >= self.frames(SPIN_UP):
                    positions = positions + cloth.positions
                    energy += kinetic_energy(model, cloth.velocities)
                    count += 1
            shapes.append(positions / count)
            energies.append(energy)
        on, off = self.common(*shapes)
        return {'shape_px': error.rms(error.pixel_distances(off, on, camera)),
                'energy': energies[1] / energies[0]}

    def times(self, start, moves, draws):
        """Return medians and interquartile ranges [ms] of one frame, taken in turns."""
        looks = [look_of(settings) for settings in self.settings]
        drawn = [picture_of(settings) for settings in self.settings]
        taken = ([], [])
        # Another grid is also drawn; the first turn compiles, and does not count.
        draws = draws or self.every > 1
        for _ in range(REPEATS + 1):
            for which in range(2):
                cloth = self.begin(which, start)
                wind = self.shots[which].wind(start.frame + 1)
                begin = time.perf_counter()
                if moves:
                    try:
                        cloth.advance(self.shots[which].dt, wind)
                    except Diverged:
                        pass  # it took its time all the same
                normals = cloth.normals()
                if draws:
                    drawn[which].draw(cloth.positions, normals, *looks[which])
                taken[which].append(1e3 * (time.perf_counter() - begin))
        row = {}
        for name, times in zip(('with', 'without'), taken):
            low, median, high = np.percentile(times[1:], [25, 50, 75])
            row |= {f'ms_{name}': float(median), f'spread_ms_{name}': float(high - low)}
        return row
