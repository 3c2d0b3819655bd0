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

"""Boxes of a scene as parameters: flat lists, as those of keys, one box after another."""
from collections.abc import Mapping
import dataclasses

from flag_sim.drawing import Box
from flag_sim.drawing.dimensions import FARTHEST, LONGEST_EDGE, MOST_BOXES, SHORTEST_EDGE
from flag_sim.parameters.declaration import Declaration, TURN

PREFIX = 'objects.'
SIZES = Declaration(
    PREFIX + 'sizes', [], 'boxes of the scene: x, y and z of the first, of the second and so on',
    'm', SHORTEST_EDGE, LONGEST_EDGE)
POSITIONS = Declaration(PREFIX + 'positions', [], 'x, y and z of the centre of each lower face',
                        'm', -FARTHEST, FARTHEST)
YAWS = Declaration(PREFIX + 'yaws', [], 'turn of each about the upright; empty: none is turned',
                   'rad', -TURN, TURN)
COLORS = Declaration(PREFIX + 'colors', [], 'red, green and blue of each; empty: grey', '', 0.0,
                     255.0)
OBJECTS = (SIZES, POSITIONS, YAWS, COLORS)


def is_object(name: str) -> bool:
    """Return whether a parameter is one of the lists of boxes, of which each needs the others."""
    return name.startswith(PREFIX)


def boxes_of(values: Mapping) -> tuple[Box, ...]:
    """Return the boxes; raises ValueError for lists that do not go together."""
    sizes, positions = _threes(values, SIZES), _threes(values, POSITIONS)
    yaws, colors = values[YAWS.name], _threes(values, COLORS)
    count = len(sizes)
    if count > MOST_BOXES:
        raise ValueError(f'{SIZES.name} must be those of at most {MOST_BOXES} boxes, not {count}')
    for declaration, own, may_lack in (
            (POSITIONS, positions, False), (YAWS, yaws, True), (COLORS, colors, True)):
        if len(own) != count and (own or not may_lack):
            boxes = 'the one box' if count == 1 else f'the {count} boxes'
            raise ValueError(f'{declaration.name} must be those of {boxes} that {SIZES.name} '
                             f'has, not of {len(own)}')
    surfaces = [dataclasses.replace(Box.surface, color=color) for color in colors]
    return tuple(map(Box, sizes, positions, yaws or [0.0] * count,
                     surfaces or [Box.surface] * count))


def _threes(values, declaration):
    """Return a flat list as one of threes; raise ValueError where it is none."""
    numbers = list(values[declaration.name])
    if len(numbers) % 3:
        raise ValueError(f'{declaration.name} must hold 3 numbers for each box, not '
                         f'{len(numbers)}')
    return [tuple(numbers[at:at + 3]) for at in range(0, len(numbers), 3)]
