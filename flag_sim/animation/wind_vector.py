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

"""The wind as a vector, from its speed, its direction and its gusts."""
from collections.abc import Callable, Sequence

from flag_sim.parameters import checks
from flag_sim.parameters.closed import constant
import numpy as np


def wind_vector(speed: float, azimuth: float, elevation: float,
                gust: Sequence[float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    """
    Return the wind's velocity (3,) [m/s]: where it blows to.

    speed [m/s]; azimuth [rad] from +x towards +y; elevation [rad] above the ground.
    gust: turbulence as fractions of the speed: along the wind, across it to the left, upwards.
    Raises ValueError unless all are numbers, three of them in gust, of at most checks.LARGEST.
    """
    most = checks.LARGEST
    speed, azimuth, elevation = (checks.finite(name, value, -most, most) for name, value in (
        ('speed', speed), ('azimuth', azimuth), ('elevation', elevation)))
    gust = checks.vector('gust', gust, most)
    ahead, up = np.cos(elevation), np.sin(elevation)
    x, y = np.cos(azimuth), np.sin(azimuth)
    axes = np.array([[ahead * x, ahead * y, up],      # along the wind
                     [-y, x, 0.0],                    # across it
                     [-up * x, -up * y, ahead]])      # upwards: along x across
    return speed * np.array([1.0 + gust[0], gust[1], gust[2]]) @ axes


@constant
class Passage:
    """
    How far a wind of changing speed has gone: the integral of the speed over time.

    speed_at(time [s]) returns the speed [m/s]; distance [m] is what had passed at `start` [s].
    The trapezoids stand on a lattice of their own, so the distance at a time is the same
    whatever the times that were asked for before, and so whatever the frame rate.

    Kept is the last lattice point alone: a time after it costs the lattice points up to there,
    an earlier one all of them from `start` on. Raises ValueError for a time before `start`, for
    one more than LONGEST_SPAN beyond the point from which it is reached, and for a speed that is
    no number of at most checks.LARGEST.
    """

    STEP = 1.0 / 64.0  # of the lattice [s]: gusts shorter than a frame of 60 Hz are not seen
    LONGEST_SPAN = 7 * 24 * 3600  # reached at once [s]: it takes some ten seconds

    def __init__(self, speed_at: Callable[[float], float], start: float = 0.0,
                 distance: float = 0.0):
        checks.require(callable(speed_at), 'speed_at', 'a function of the time', speed_at)
        self._speed_of = speed_at
        self._start = checks.moment('start', start)
        self._distance = checks.finite('distance', distance, -checks.LARGEST, checks.LARGEST)
        self._begin()

    def _speed_at(self, time):
        """Return the speed [m/s] that a time [s] has; raise ValueError if it is no number."""
        speed = self._speed_of(time)
        if type(speed) is float and -checks.LARGEST <= speed <= checks.LARGEST:
            return speed
        return checks.finite(f'speed_at({checks.text(time)})', speed, -checks.LARGEST,
                             checks.LARGEST)

    def _begin(self):
        """Stand at the lattice's first point, `start`."""
        self._point = 0
        self._passed = self._distance  # there [m]
        self._speed = self._speed_at(self._start)  # there [m/s]

    def at(self, time: float) -> float:
        """Return the distance [m] passed at `time` [s], which is not before `start`."""
        time = checks.finite('time', time, low=self._start)
        known = self._start + self._point * self.STEP
        most = (known if time >= known else self._start) + self.LONGEST_SPAN
        checks.require(time <= most, 'time', f'at most {most:.12g}, {self.LONGEST_SPAN} s after '
                       'what is known', time)
        point = int((time - self._start) / self.STEP)
        if point < self._point:
            self._begin()
        for k in range(self._point + 1, point + 1):
            speed = self._speed_at(self._start + k * self.STEP)
            self._passed += 0.5 * (self._speed + speed) * self.STEP
            self._speed = speed
        self._point = point
        rest = time - (self._start + point * self.STEP)
        return self._passed + 0.5 * rest * (self._speed + self._speed_at(time))
