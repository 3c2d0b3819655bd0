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

"""How a frame is divided into steps, as far as that is the user's choice; see stability.plan."""
from dataclasses import dataclass

from flag_sim.parameters.declared import Declared, declared


@dataclass(frozen=True)
class Stepping(Declared):
    """
    How a frame is divided into steps.

    substeps: steps per frame; 0 leaves it to stability. Fewer than are stable are refined; more
    than the precision resolves are not taken (see stability.SHORTEST_STEP).
    step_safety: the part of the largest stable step that is used.
    substeps_limit: the most steps that a frame may cost; beyond it the cloth is softened.
    Raises ValueError for a value out of its range.
    """

    substeps: int = declared(0, 'steps per frame at least; 0: as many as stability asks',
                             '', 0, 100000)
    step_safety: float = declared(0.9, 'step as a share of the largest stable one', '', 0.01, 1.0)
    substeps_limit: int = declared(
        1000, 'steps per frame at most; beyond, the cloth is made softer', '', 1, 100000)
