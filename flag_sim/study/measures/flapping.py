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
"""How a flag flies in a steady wind, in the numbers that experiments give of real ones."""
import math
from typing import NamedTuple

from flag_sim.cloth import Diverged
from flag_sim.cloth.pole_load import pole_load
from flag_sim.declarations.factories import cloth_of
from flag_sim.study.measures.settings import changed, rendered, Settings
import numpy as np

SAMPLED = 120.0  # frames a second, at least: the finest flapping is of some 10 Hz
WINDOW = 8.0  # of which spectra are taken [s]: frequencies are told apart by its inverse
SLOWEST = 0.2  # frequency that is flapping and no drift of the whole flag [Hz]
BEHIND, AHEAD = 0.5, 0.85  # of the length: between them waves are timed
ONE_SWING = 1.5  # speed of "waves", by the wind's, from which on the flag swings as a whole
LOADED = 4  # frames from one pole load that is taken to the next
PICTURE = 220  # width of a picture of the flag [pixels]
SMALLEST = 0.02  # swing of the free edge, by the length, from which on a flag flaps


class Trial(NamedTuple):
    """How long a flag is watched, after how long a beginning [s]."""

    settle: float = 7.0
    seconds: float = 25.0


def sampled(settings: Settings) -> Settings:
    """
    Return settings with frames short enough to see the finest flapping.

    Each frame has become several; numbers of steps in a frame are divided by as many.
    """
    parts = math.ceil(SAMPLED / settings['rate'])
    return changed(settings, {'rate': parts * settings['rate'], **{
        name: -(-settings[name] // parts) for name in ('substeps', 'substeps_limit')}})


def flapping(settings: Settings, speed: float, trial: Trial) -> dict:
    """
    Fly the flag of settings in a steady wind of a speed [m/s] along +x, in which it starts.

    So it starts exactly along the wind, flat but for its start noise. Returns a row:
    frequency_hz: where the spectrum of the free edge's middle across the wind has its peak; None
    if it stays still;
    crossings_hz: how often a second that point comes back to its mean from one side;
    swing: how far it goes from one side to the other, by the length, but for the farthest
    fortieth of the time on each side;
    wave_speed: of what travels down the middle row, by the wind's; None where the flag swings as
    a whole; drag: of the pole load, by rho U^2 L H / 2; lift: by the weight; sag_deg: angle of the
    line from the hoist's middle to the cloth's. All None where the run diverged.
    """
    settings = sampled(settings)
    cloth, dt = cloth_of(settings), 1.0 / settings['rate']
    wind, seen, loads = (speed, 0.0, 0.0), [], []
    try:
        for frame in range(round((trial.settle + trial.seconds) / dt)):
            cloth.advance(dt, wind)
            if frame * dt >= trial.settle:
                seen.append(_seen(cloth))
                if len(seen) % LOADED == 1:
                    loads.append(pole_load(cloth, wind).force)
    except Diverged:
        return dict.fromkeys(COLUMNS)
    drag, _, upwards = np.mean(loads, axis=0)
    weight = float(cloth.model.mass.sum()) * cloth.gravity
    pressure = 0.5 * cloth.air.density * speed**2 * cloth.mesh.length * cloth.mesh.width
    return dict(zip(COLUMNS, (
        *_motion(cloth, speed, dt, np.array(seen)), float(drag) / pressure,
        float(upwards) / weight + 1.0 if weight else None)))


def pictures(settings: Settings, speed: float, settle: float, apart: float,
             count: int) -> list[np.ndarray]:
    """
    Return what the camera of settings sees of a flag flown as by flapping, after settle [s].

    count pictures, `apart` [s] from one to the next, each (height, PICTURE, 3) uint8; none where
    the run diverged.
    """
    cloth, dt, shown = cloth_of(sampled(settings)), 1.0 / sampled(settings)['rate'], []
    times = {round((settle + k * apart) / dt) for k in range(count)}
    look = changed(settings, {
        'width': PICTURE, 'height': round(PICTURE * settings['height'] / settings['width']),
        'samples': 16})
    try:
        for frame in range(max(times) + 1):
            cloth.advance(dt, (speed, 0.0, 0.0))
            if frame in times:
                shown.append(rendered(look, cloth.positions))
    except Diverged:
        return []
    return shown


COLUMNS = ('frequency_hz', 'crossings_hz', 'swing', 'wave_speed', 'sag_deg', 'drag', 'lift')
"""The columns that flapping adds to a row."""


def _seen(cloth):
    """Return y at BEHIND, AHEAD and the edge, and x and z of the cloth's centre of mass [m]."""
    positions = cloth.positions
    rows, columns = positions.shape[:2]
    middle = positions[(rows - 1) // 2: rows // 2 + 1, :, 1].mean(axis=0)
    y = np.interp([BEHIND, AHEAD, 1.0], np.linspace(0.0, 1.0, columns), middle)
    centre = np.average(positions.reshape(-1, 3), axis=0,
                        weights=cloth.mesh.grid(cloth.mesh.mass_share).ravel())
    return (*y, centre[0], centre[2])


def _motion(cloth, speed, dt, seen):
    """Return the values of COLUMNS up to sag_deg from what was _seen in each frame (frames, 5)."""
    mesh, (behind, ahead, edge) = cloth.mesh, seen[:, :3].T
    x, z = seen[:, 3:].mean(axis=0) - [cloth.hoist_top[0], cloth.hoist_top[2] - 0.5 * mesh.width]
    frequency = peak(edge, dt)
    travelled = lag(behind, ahead, dt, 0.5 / frequency) if frequency else None
    wave = (AHEAD - BEHIND) * mesh.length / travelled / speed if travelled else math.inf
    left, right = np.quantile(edge, [0.025, 0.975])
    return (frequency, crossings(edge, dt), float(right - left) / mesh.length,
            wave if wave < ONE_SWING else None, math.degrees(math.atan2(-z, x)))


def peak(values: np.ndarray, dt: float) -> float | None:
    """
    Return the frequency [Hz] at which values, one every dt [s], swing most; None if they do not.

    The mean spectrum of half-overlapping windows (Welch), with the peak between its samples.
    """
    count = min(len(values), round(WINDOW / dt))
    starts = range(0, len(values) - count + 1, max(1, count // 2))
    parts = np.stack([values[start:start + count] for start in starts])
    parts = (parts - parts.mean(axis=1, keepdims=True)) * np.hanning(count)
    power = (np.abs(np.fft.rfft(parts))**2).mean(axis=0)
    frequencies = np.fft.rfftfreq(count, dt)
    power[frequencies < SLOWEST] = 0.0
    if power.max() == 0.0:
        return None
    return float((np.argmax(power) + vertex(power)) * frequencies[1])


def vertex(values: np.ndarray) -> float:
    """Return how far from the greatest of values the parabola through it has its top."""
    top = int(np.argmax(values))
    if not 0 < top < len(values) - 1:
        return 0.0
    left, middle, right = values[top - 1:top + 2]
    bend = left - 2.0 * middle + right
    return float(0.5 * (left - right) / bend) if bend < 0.0 else 0.0


def crossings(values: np.ndarray, dt: float) -> float:
    """Return how many times a second [Hz] values, one every dt [s], rise through their mean."""
    above = values > values.mean()
    return float(np.count_nonzero(above[1:] & ~above[:-1])) / (len(values) * dt)


def lag(first: np.ndarray, second: np.ndarray, dt: float, longest: float) -> float | None:
    """
    Return by which time [s] the second of two series follows the first; None if it does not.

    Where their correlation is greatest, up to the longest time [s].
    """
    first, second = first - first.mean(), second - second.mean()
    shifts = range(min(len(first) - 1, math.ceil(longest / dt)) + 1)
    alike = np.array([first[:len(first) - shift] @ second[shift:] for shift in shifts])
    found = (int(np.argmax(alike)) + vertex(alike)) * dt
    return found if found > 0.0 else None
