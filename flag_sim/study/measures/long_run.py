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
What is kept of a long run of the cloth: of every frame what an eye, or a pole, can tell of it.

Beyond the horizon no two runs are alike from frame to frame, so that only such statistics are left
to compare (see behaves).
"""
from typing import NamedTuple

from flag_sim.cloth import Cloth
from flag_sim.cloth.energy import kinetic_energy
from flag_sim.cloth.mesh import resample
from flag_sim.drawing import Camera
from flag_sim.study.measures.errors import on_screen
from flag_sim.study.measures.reference import Shot
import numpy as np

SEEN = (9, 13)  # rows and columns of the nodes that are followed, whatever the grid
ALONG = 48       # intervals along a row, of which waves are taken
SHORTEST = 24    # half-waves along a row, from one on, that count; each is 1 / n of it long


class LongRun(NamedTuple):
    """The motion of a flag, frame by frame."""

    dt: float             # from one frame to the next [s]
    pixels: np.ndarray    # (frames, rows, columns, 2): where the nodes of SEEN are [pixel]
    energy: np.ndarray    # (frames,): kinetic energy [J]
    fly: np.ndarray       # (frames, 3): upper end, middle, lower end of the fly, across y [m]
    wrinkles: np.ndarray  # (frames, SHORTEST): mean square height of waves, long to short [m2]
    load: np.ndarray      # (frames,): force on the pole [N]


def observed(shot: Shot, cloth: Cloth, camera: Camera, settle: float,
             seconds: float) -> LongRun | None:
    """
    Play a shot from its beginning; return the LongRun of its last `seconds`, None if it diverges.

    settle: what is left out first [s].
    """
    skipped, count = shot.frames(settle), shot.frames(settle + seconds) - shot.frames(settle)
    frames = []
    for done, _ in enumerate(shot.timed(cloth, 0, skipped + count)):
        if done >= skipped:
            positions = cloth.positions
            frames.append((on_screen(resample(positions, *SEEN), camera)[0],
                           kinetic_energy(cloth.model, cloth.velocities),
                           resample(positions, 3, 2)[:, 1, 1],
                           wrinkles(positions), pole_load(cloth, positions)))
    if len(frames) < count:
        return None
    return LongRun(shot.dt, *(np.array(column) for column in zip(*frames)))


def wrinkles(positions: np.ndarray) -> np.ndarray:
    """
    Return the mean square height [m2] of the waves along the rows of positions (rows, columns, 3).

    For 1 .. SHORTEST half-waves along a row, over all rows [m]: the sine series of what a row
    differs from the straight line between its ends; a wave of amplitude a counts as a^2 / 2.
    """
    rows = resample(positions, positions.shape[0], ALONG + 1)
    part = np.linspace(0.0, 1.0, ALONG + 1)[:, None]
    bent = rows - (1.0 - part) * rows[:, :1] - part * rows[:, -1:]
    number = np.arange(1, SHORTEST + 1)
    series = np.sin(np.pi * number[:, None] * part[:, 0]) * 2.0 / ALONG
    return 0.5 * np.sum((series @ bent)**2, axis=-1).mean(axis=0)


def pole_load(cloth: Cloth, positions: np.ndarray) -> float:
    """Return the size [N] of the springs' force on the hoist, at positions (rows, columns, 3)."""
    across, _, diagonal = cloth.model.spring_k
    rest, _, rest_diagonal = cloth.model.spring_rest
    weights = cloth.mesh.grid(cloth.model.mesh.weights.across)[:, 0]
    p, total = positions, np.zeros(3)
    for k, length, weight, ends in (
            (across, rest, weights[:, None], p[:, 1] - p[:, 0]),
            (diagonal, rest_diagonal, 1.0, p[1:, 1] - p[:-1, 0]),
            (diagonal, rest_diagonal, 1.0, p[:-1, 1] - p[1:, 0])):
        long = np.linalg.norm(ends, axis=-1, keepdims=True)
        total += np.sum(weight * k * (long - length) * ends / long, axis=0)
    return float(np.linalg.norm(total))
