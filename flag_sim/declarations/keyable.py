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

"""Which parameters of the nodes tracks may animate."""
from flag_sim.animation.targets import Targets
from flag_sim.animation.wind_source import WIND_KEYED
from flag_sim.declarations.nodes import NODES, scene, SHARED
from flag_sim.declarations.scene import PLACE

TARGETS = Targets(
    {**NODES, SHARED: scene()},
    {'wind': WIND_KEYED, 'physics': None, 'renderer': None, SHARED: None},
    {f'{node}.{one.name}': f'{SHARED}.{one.name}'
     for node in ('physics', 'renderer') for one in PLACE})
"""
Of the wind node the wind alone, not the clock that plays it; of physics and renderer all.

What both share can be keyed for both, and where the pole is only so: else the flag would leave it.
"""
