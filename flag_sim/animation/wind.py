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

"""The wind as a vector from its speed and direction."""
import numpy as np


def wind_vector(speed, azimuth, elevation):
    """
    Return the wind's velocity (3,) [m/s]: where it blows to.

    speed [m/s]; azimuth [rad] from +x towards +y; elevation [rad] above the ground.
    """
    return speed * np.array([np.cos(elevation) * np.cos(azimuth),
                             np.cos(elevation) * np.sin(azimuth),
                             np.sin(elevation)])
