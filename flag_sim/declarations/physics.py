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

"""Parameters of the physics node."""
from collections.abc import Mapping

from flag_sim.cloth import Air, Material, Stepping
from flag_sim.cloth.mesh import Grid
from flag_sim.cloth.options import Options
from flag_sim.cloth.simulation import MAX_FRAME
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.declarations.scene import SCENE
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.declared import Group

MATERIAL = Group(Material())
AIR = Group(Air(), 'air.')
STEPPING = Group(Stepping())
GRID = Group(Grid())
OPTIONS = Group(Options())

PHYSICS = (
    *SCENE,
    *GRID.without('precision'),
    *MATERIAL,
    *OPTIONS.pick('gravity'),
    *AIR,
    *OPTIONS.pick('solver'),
    *STEPPING,
    *OPTIONS.pick('stretch_limit'),
    *GRID.pick('precision'),
    Declaration('pole_collision', True, 'keep the cloth out of the pole'),
    *OPTIONS.without('gravity', 'solver', 'stretch_limit', 'threads'),
    Declaration(
        'preroll', 0.0,
        "time that a cloth which begins anew has moved in its first frame's wind, unseen", 's',
        0.0, 60.0),
    Declaration('max_gap', 1.0, 'longest time between frames that is simulated', 's',
                0.0, MAX_FRAME),
    *OPTIONS.pick('threads'),
)


def check_method(values: Mapping) -> None:
    """Raise ValueError if the solver of values {name: value} cannot step in their air."""
    SOLVERS[values['solver']].require(AIR.make(values))
