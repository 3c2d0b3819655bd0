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

"""The settings of a run: {parameter: value} of all three nodes in one, and changes of them."""
from flag_sim.declarations.factories import look_of
from flag_sim.declarations.physics import PHYSICS
from flag_sim.declarations.renderer import RENDERER
from flag_sim.declarations.scene import SCENE
from flag_sim.declarations.wind import WIND
from flag_sim.drawing import Picture
import numpy as np

Settings = dict[str, object]
"""{parameter: value}, of every parameter that a frame depends on."""

CLOTH_SIZES = ('flag.length', 'flag.width')  # the parameters of the scene that are the cloth's


def _defaults(declarations, exclude=()) -> Settings:
    """Return {parameter: default}, lists as tuples, which cannot be changed by mistake."""
    return {declaration.name: (tuple(declaration.default) if declaration.is_list
                               else declaration.default)
            for declaration in declarations if declaration.name not in exclude}


WIND_DEFAULTS = {name: default for name, default in _defaults(WIND).items()
                 if name in ('rate', 'speed', 'azimuth', 'elevation') or name.startswith('gust.')}
"""The wind node's parameters that a frame depends on."""

DEFAULTS = {
    'wind': WIND_DEFAULTS,
    'physics': _defaults(PHYSICS, exclude=['max_gap', 'preroll', *_defaults(SCENE, CLOTH_SIZES)]),
    'renderer': {**_defaults(RENDERER, exclude=['threads', *CLOTH_SIZES]), 'drawing.threads': 1},
}
"""
{node: {parameter: default}}: all that a frame depends on.

Both physics and renderer have `threads`: the renderer's is `drawing.threads` here.
"""

RANGES = {declaration.name: (declaration.low, declaration.high)
          for declaration in WIND + PHYSICS if declaration.low is not None}
"""{parameter: (least, greatest)} of the numbers of wind and physics."""
MAX_GAP = _defaults(PHYSICS)['max_gap']
"""Longest frame that the physics node simulates by default [s]."""


def defaults(**changes) -> Settings:
    """Return new settings: the defaults, changed; `__` in a name stands for a dot."""
    return changed({name: value for own in DEFAULTS.values() for name, value in own.items()},
                   {name.replace('__', '.'): value for name, value in changes.items()})


def changed(settings: Settings, changes: Settings) -> Settings:
    """Return settings with changes; raise ValueError for an unknown parameter."""
    unknown = sorted(set(changes) - set(settings))
    if unknown:
        raise ValueError(f'there is no parameter {", ".join(unknown)}')
    return {**settings, **changes}


def rendered(settings: Settings, positions: np.ndarray) -> np.ndarray:
    """Return the picture of a cloth, (rows, columns, 3) [m]: (height, width, 3) uint8."""
    return Picture(settings['drawing.threads']).draw(
        positions, None, *look_of(settings)).colour
