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
from flag_sim.cloth.mesh import SHORTEST_SIDE
from flag_sim.drawing import Dimensions
from flag_sim.drawing.dimensions import check_hole
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.declared import Group


DIMENSIONS = Group(Dimensions())
POLE_FIELDS = ('pole_height', 'pole_diameter')
PLACE_FIELDS = ('pole_position', 'pole_yaw', 'pole_tilt')
PLATFORM_FIELDS = ('platform_side', 'platform_height')

LENGTH = Declaration(
    'flag.length', 0.0,
    f'hoist to fly, {SHORTEST_SIDE:g} at least; 0: one and a half times the width', 'm',
    0.0, 100.0)
WIDTH = Declaration(
    'flag.width', 0.0, f'upper to lower edge, {SHORTEST_SIDE:g} at least; 0: a sixth of the pole',
    'm', 0.0, 100.0)

PLACE = DIMENSIONS.pick(*PLACE_FIELDS)
SCENE = (*DIMENSIONS.pick(*POLE_FIELDS), *PLACE, LENGTH, WIDTH,
         *DIMENSIONS.pick(*PLATFORM_FIELDS))
"""PLACE among them is where the pole is, which moves in both nodes or in none."""


def check_scene(values: dict) -> None:
    """
    Raise ValueError if values {name: value}, each a right one, make no scene together.

    A side of the flag that is neither 0 nor long enough is refused here and not by its
    declaration, for a key may lead from 0 to a length.
    """
    for side in (LENGTH, WIDTH):
        if 0.0 < values[side.name] < SHORTEST_SIDE:
            raise ValueError(f'{side.name} must be 0 or a number from {SHORTEST_SIDE:g} to '
                             f'{side.high:g} [m], not {checks.text(values[side.name])}')
    diameter, height = values['pole.diameter'], values['pole.height']
    if diameter >= height:
        raise ValueError(f'pole.diameter {checks.text(diameter)} m must be less than pole.height '
                         f'{checks.text(height)} m')
    check_hole(values['platform.side'], diameter, ('platform.side', 'pole.diameter'))
