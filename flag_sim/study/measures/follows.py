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
*Follows*: how far a flag is from where it should be, as long as that can be told.

The motion is chaotic. From one state two runs go together for a while and then part, however exact
they are: that is the horizon. Until then settings are measured as weather forecasts are, by the
error that grows with time from a common state; beyond it only by statistics (see behaves).
"""
from flag_sim.cloth import Cloth, Diverged
from flag_sim.cloth.mesh import resample
from flag_sim.drawing import Camera
from flag_sim.study.measures.errors import pixel_distances
from flag_sim.study.measures.reference import Shot
from flag_sim.study.measures.summary import rms
import numpy as np

HORIZONS = (1.0 / 30.0, 0.1, 0.2, 0.3)
"""After how long the error of a forecast is told [s]."""
FAR = 0.1
"""Part of what unrelated states are apart by at which two runs have parted."""


def after(shot: Shot, seconds: tuple = HORIZONS) -> list[int]:
    """Return after how many frames of a shot, at least one, so many seconds are over."""
    return [max(1, shot.frames(one)) for one in seconds]


def ends(shot: Shot, cloth: Cloth, start: int, frames: list[int]) -> list[np.ndarray | None]:
    """
    Play a shot with a cloth from frame `start`; return its positions after each of `frames`.

    frames: in ascending order. None where the run has diverged.
    """
    found, done = [], 0
    for count in frames:
        try:
            shot.play(cloth, start + done, start + count)
        except Diverged:
            return found + [None] * (len(frames) - len(found))
        done = count
        found.append(cloth.positions)
    return found


def shared(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """
    Return positions (rows, columns, 3) of two grids at the nodes of the coarser of them.

    Exactly as they are where the nodes of the coarser are nodes of the finer; else the finer is
    interpolated, which is the smaller error.
    """
    grid = [min(pair) for pair in zip(one.shape[:2], other.shape[:2])]
    return resample(one, *grid), resample(other, *grid)


def errors_px(found: list[np.ndarray | None], right: list[np.ndarray | None],
              camera: Camera) -> list[float | None]:
    """Return the RMS distance [pixel] of each of `ends` from the right ones; None where None."""
    return [None if end is None or exact is None else rms(pixel_distances(
        *shared(end, exact), camera)) for end, exact in zip(found, right)]


def horizon(times: list[float], apart: list[float], unrelated: float) -> float | None:
    """
    Return when two runs from one state have parted [s], None if they do not.

    apart: their distance at each of `times`, in the unit of `unrelated`, that of two states which
    have nothing to do with each other. They have parted at FAR of it.
    """
    return next((time for time, value in zip(times, apart) if value > FAR * unrelated), None)
