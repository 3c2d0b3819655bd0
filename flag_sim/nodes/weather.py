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

"""The weather: the wind at any time, from the wind node's dials and what is keyed of them."""
from flag_sim.animation.gusts import Gusts
from flag_sim.animation.wind import Passage, wind_vector
from flag_sim.nodes.keys import WIND_KEYED
import numpy as np


class Weather:
    """
    The wind of the dials `values` {name: value} and a Timeline, from a moment on.

    start: that moment [s]; passed: how far the wind had gone by then [m], so that a dial that is
    turned while the wind blows changes no gust that is already in the air.
    """

    def __init__(self, values, timeline, start=0.0, passed=0.0):
        self._values = dict(values)
        self._timeline = timeline
        self._gusts = Gusts(values['gust.length'], values['gust.seed'])
        self._passage = Passage(lambda time: self._value('speed', time), start, passed)

    def passed(self, time):
        """Return how far the wind has gone at `time` [s]: [m]."""
        return self._passage.at(time)

    def at(self, time):
        """Return the wind's velocity (3,) [m/s] at `time` [s]."""
        speed, azimuth, elevation, intensity = (self._value(name, time) for name in WIND_KEYED)
        gust = intensity * self._gusts.at(self.passed(time)) if intensity > 0.0 else np.zeros(3)
        return wind_vector(speed, azimuth, elevation, gust)

    def _value(self, name, time):
        track = f'wind.{name}'
        if track in self._timeline.tracks:
            return self._timeline.value(track, time)
        return self._values[name]
