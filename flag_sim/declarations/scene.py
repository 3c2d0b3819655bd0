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

"""Parameters of the scene, which physics and renderer share."""
from dataclasses import dataclass

from flag_sim.cloth.mesh import SHORTEST_SIDE
from flag_sim.drawing import Scene
from flag_sim.drawing.shapes import check_hole
from flag_sim.parameters import checks
from flag_sim.parameters.declared import Declared, declared, Group


@dataclass(frozen=True)
class FlagSize(Declared):
    """The size of the flag [m]; 0 follows from the pole and the other side (1.2)."""

    length: float = declared(0.0, 'hoist to fly; 0: one and a half times the width', 'm',
                             0.0, 100.0, least=SHORTEST_SIDE)
    width: float = declared(0.0, 'upper to lower edge; 0: a sixth of the pole', 'm',
                            0.0, 100.0, least=SHORTEST_SIDE)


DIMENSIONS = Group(Scene())
POLE_FIELDS = ('pole_height', 'pole_diameter')
PLATFORM_FIELDS = ('platform_side', 'platform_height')

SCENE = (*DIMENSIONS.only(*POLE_FIELDS), *Group(FlagSize(), 'flag.'),
         *DIMENSIONS.only(*PLATFORM_FIELDS))


def check_scene(values: dict) -> None:
    """Raise ValueError if values {name: value}, each a right one, make no scene together."""
    diameter, height = values['pole.diameter'], values['pole.height']
    if diameter >= height:
        raise ValueError(f'pole.diameter {checks.text(diameter)} m must be less than pole.height '
                         f'{checks.text(height)} m')
    check_hole(values['platform.side'], diameter, ('platform.side', 'pole.diameter'))
