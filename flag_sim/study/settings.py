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

"""The settings of a study: the defaults of all three nodes' dials in one, and changes of them."""
import inspect

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.drawing import Camera, Light, Materials, Picture, Scene, Style
from flag_sim.settings import (
    AIR, CAMERA, CLOTH, LIGHT, MATERIAL, SCENE, STEPPING, STYLE, SURFACES)

WEATHER = {'speed': 6.0, 'azimuth': 0.35, 'elevation': 0.0, 'gust.intensity': 0.0,
           'gust.length': 5.0, 'gust.seed': 0, 'rate': 30.0}
"""The wind node's dials that a frame depends on."""


def _defaults(record, names):
    """Return {dial: default} of an object's fields, given {dial: field}."""
    return {dial: getattr(record, field) for dial, field in names.items()}


def _cloth_defaults():
    arguments = inspect.signature(Cloth).parameters
    return {dial: arguments[name].default for dial, name in CLOTH.items()}


def _surface_defaults():
    materials = Materials()
    return {dial: default for thing, names in SURFACES.items()
            for dial, default in _defaults(getattr(materials, thing), names).items()}


DEFAULTS = {
    'wind': dict(WEATHER),
    # A size of zero follows from the pole's height.
    'physics': {**_cloth_defaults(), 'flag.length': 0.0, 'flag.width': 0.0,
                **_defaults(Material(), MATERIAL), **_defaults(Air(), AIR),
                **_defaults(Stepping(), STEPPING), 'pole_collision': False},
    'renderer': {**_defaults(Camera(), CAMERA), **_defaults(Light(), LIGHT),
                 **_defaults(Scene(), SCENE), **_defaults(Style(), STYLE), **_surface_defaults(),
                 'drawing.threads': 1},
}
"""
{node: {dial: default}}: all that a frame depends on.

Both physics and renderer have `threads`: the renderer's is `drawing.threads` here.
"""


def defaults(**changes):
    """Return new settings: the defaults of all dials, changed; `__` in a name stands for a dot."""
    changes = {name.replace('__', '.'): value for name, value in changes.items()}
    return changed({name: value for dials in DEFAULTS.values() for name, value in dials.items()},
                   changes)


def changed(settings, changes):
    """Return settings with changes {dial: value}; raise ValueError for an unknown dial."""
    unknown = sorted(set(changes) - set(settings))
    if unknown:
        raise ValueError(f'there is no dial {", ".join(unknown)}')
    return {**settings, **changes}


def picture_of(settings):
    """Return a Picture that draws with the settings' threads."""
    return Picture(settings['drawing.threads'])
