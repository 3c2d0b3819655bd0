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

"""The cloth: a grid of masses and springs in the wind, stepped through time."""
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.simulation import Cloth, Diverged
from flag_sim.cloth.stability import Plan
from flag_sim.cloth.stepping import Stepping

__all__ = ['Air', 'Cloth', 'Diverged', 'Material', 'Plan', 'Stepping']
