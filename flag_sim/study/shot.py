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

"""A shot to measure on: the wind of every frame, and the cloth that moves in it."""
from flag_sim.animation.gusts import Gusts
from flag_sim.animation.wind import wind_vector

LEAST_HZ, MOST_HZ = 0.01, 1000.0
"""Rates that the wind node takes; a test holds them to its dial, which a study may not import."""
MAX_GAP = 1.0
"""Longest frame that the physics node simulates by default [s]; held by the same test."""


class Shot:
    """
    The wind of settings (see settings.WEATHER), frame by frame.

    Within a frame the wind is steady, as it is for the physics node.
    """

    def __init__(self, settings):
        self.dt = 1.0 / settings['rate']
        self._speed = settings['speed']
        self._direction = settings['azimuth'], settings['elevation']
        self._intensity = settings['gust.intensity']
        self._gusts = Gusts(settings['gust.length'], settings['gust.seed'])

    def wind(self, frame):
        """Return what blows, (3,) [m/s], in the frame of that number."""
        gust = self._intensity * self._gusts.at(self._speed * frame * self.dt)
        return wind_vector(self._speed, *self._direction, gust)

    def play(self, cloth, first, last):
        """Move a cloth through the frames first + 1 .. last."""
        for frame in range(first + 1, last + 1):
            cloth.advance(self.dt, self.wind(frame))
