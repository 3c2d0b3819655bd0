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

"""The wind source: the wind at any time, from the wind node's parameters and their tracks."""
from collections.abc import Mapping
import functools

from flag_sim.animation.gusts import Gusts
from flag_sim.animation.timeline import Timeline
from flag_sim.animation.wind_settings import WindSettings
from flag_sim.animation.wind_vector import Passage, wind_vector
from flag_sim.parameters.declared import Group
import numpy as np

WIND_KEYED = ('speed', 'azimuth', 'elevation', 'gust.intensity')
"""The parameters of the wind that may be keyed."""
PARAMETERS = tuple(declaration.name for declaration in Group(WindSettings()))
"""The wind node's parameters that the wind depends on."""


class WindSource:
    """
    The wind of the parameters `values` {name: value} and a Timeline, from a moment on.

    start: that moment [s]; passed: how far the wind had carried its gusts by then [m]. Where gusts
    are off from end to end nothing is carried, and the distance stays what it was.
    """

    def __init__(self, values: Mapping, timeline: Timeline, start: float = 0.0,
                 passed: float = 0.0):
        self._values = {name: values[name] for name in PARAMETERS}
        self._timeline = timeline
        self._gusts = Gusts(values['gust.length'], values['gust.seed'])
        self._start_passed = passed
        # Not by `self`: in a circle it would be freed late, and with it a million keys.
        self._passage = Passage(
            functools.partial(_value, self._values, timeline, 'speed'), start, passed)
        track = timeline.tracks.get('wind.gust.intensity')
        # No law leads beyond its keys.
        self._has_gusts = any(track.values) if track else values['gust.intensity'] > 0.0

    def continued(self, values: Mapping, timeline: Timeline, now: float) -> 'WindSource':
        """
        Return the wind source of other values and keys from `now` [s] on; self if they are equal.

        The gusts that are in the air stay where they are.
        """
        if timeline is self._timeline and all(values[n] == self._values[n] for n in PARAMETERS):
            return self
        return WindSource(values, timeline, now, self._passed(now))

    def _passed(self, time):
        """Return how far the wind has carried its gusts at `time` [s]: [m]."""
        return self._passage.at(time) if self._has_gusts else self._start_passed

    def at(self, time: float) -> np.ndarray:
        """Return the wind's velocity (3,) [m/s] at `time` [s]."""
        speed, azimuth, elevation, intensity = (
            _value(self._values, self._timeline, name, time) for name in WIND_KEYED)
        # Also while a keyed intensity is 0, lest the first gust has a long way to catch up.
        passed = self._passed(time)
        gust = intensity * self._gusts.at(passed) if intensity > 0.0 else np.zeros(3)
        return wind_vector(speed, azimuth, elevation, gust)


def _value(values, timeline, name, time):
    """Return the value of a parameter of the wind at `time` [s]: its track's, or as it is set."""
    track = f'wind.{name}'
    return timeline.value(track, time) if track in timeline.tracks else values[name]
