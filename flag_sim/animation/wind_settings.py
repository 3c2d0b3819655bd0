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

"""The wind as its user sets it: speed, direction and gusts."""
from dataclasses import dataclass
import math

from flag_sim.parameters.declaration import TURN
from flag_sim.parameters.declared import Declared, declared


@dataclass(frozen=True)
class WindSettings(Declared):
    """
    A steady wind and its gusts; see wind_vector and Gusts.

    speed: [m/s]; azimuth, elevation: of where it blows to [rad]; gust_intensity: the standard
    deviation of the turbulence in parts of the speed; gust_length: [m]; gust_seed: another seed,
    another series. Raises ValueError for a value out of its range.
    """

    speed: float = declared(6.0, 'wind speed', 'm/s', 0.0, 200.0)
    azimuth: float = declared(0.35, 'where the wind blows to, from +x towards +y', 'rad',
                              -TURN, TURN)
    elevation: float = declared(0.0, 'where the wind blows to, above the ground', 'rad',
                                -math.pi / 2.0, math.pi / 2.0)
    gust_intensity: float = declared(
        0.0, 'turbulence as a part of the speed (Dryden); 0: steady wind', '', 0.0, 2.0,
        name='gust.intensity')
    gust_length: float = declared(5.0, 'size of the eddies', 'm', 0.01, 10000.0,
                                  name='gust.length')
    gust_seed: int = declared(0, 'another seed, another series', '', 0, 2**31 - 1,
                              name='gust.seed')
