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

"""
Settings: {dial name: value}, as in a params file of the nodes, and what they make.

Names and defaults follow from the library's own dataclasses, so that they are written once.
"""
import dataclasses
import inspect
from typing import NamedTuple

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.drawing import Camera, Light, Materials, Picture, Scene, Style
from flag_sim.drawing import Material as Surface

CLOTH = {'grid.rows': 'rows', 'grid.columns': 'columns', 'flag.length': 'length',
         'flag.width': 'width', **{name: name for name in (
             'gravity', 'solver', 'stretch_limit', 'precision', 'threads')}}
"""The dials of Cloth that it takes as they are, and the names of its arguments."""


def _names(record, prefix='', but=()):
    """Return {dial: field} of a dataclass whose fields are dials under a prefix."""
    return {prefix + field.name: field.name for field in dataclasses.fields(record)
            if field.name not in but}


def _scene_names():
    """Return {dial: field} of Scene: pole_height is pole.height."""
    return {name.replace('_', '.', 1): name for name in _names(Scene)}


PHYSICS = {
    Material: _names(Material),
    Air: _names(Air, 'air.'),
    Stepping: _names(Stepping),
}
RENDERER = {
    Camera: {('' if name in ('width', 'height') else 'camera.') + name: name
             for name in _names(Camera)},
    Light: {**_names(Light, 'sun.', but=['ambient']), 'ambient': 'ambient'},
    Scene: _scene_names(),
    Style: _names(Style),
}
SURFACES = ('flag', 'pole', 'platform')
WEATHER = {'speed': 6.0, 'azimuth': 0.35, 'elevation': 0.0, 'gust.intensity': 0.0,
           'gust.length': 5.0, 'gust.seed': 0, 'rate': 30.0}
"""The wind node's dials that a frame depends on."""


def _defaults(groups):
    """Return {dial: default} of groups {dataclass: {dial: field}}."""
    return {dial: getattr(record(), field) for record, names in groups.items()
            for dial, field in names.items()}


def _cloth_defaults():
    arguments = inspect.signature(Cloth).parameters
    found = {dial: arguments[name].default for dial, name in CLOTH.items()}
    # Zero: they follow from the pole's height.
    return {**found, 'flag.length': 0.0, 'flag.width': 0.0}


def _surface_defaults():
    materials = Materials()
    return {dial: getattr(getattr(materials, thing), field) for thing in SURFACES
            for dial, field in _surface_names(thing).items()}


def _surface_names(thing):
    """Return {dial: field} of what a thing is made of; only the flag is thin enough to glow."""
    return _names(Surface, f'{thing}.', but=[] if thing == 'flag' else ['transmission'])


DEFAULTS = {
    'wind': dict(WEATHER),
    'physics': {**_cloth_defaults(), **_defaults(PHYSICS), 'pole_collision': False},
    'renderer': {**_defaults(RENDERER), **_surface_defaults(), 'drawing.threads': 1},
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


def _make(record, names, settings):
    return record(**{field: settings[dial] for dial, field in names.items()})


def hang_of(settings):
    """Return (hoist_top, length, width) [m] of the flag (1.2), as the physics node hangs it."""
    width = settings['flag.width'] or settings['pole.height'] / 6.0
    length = settings['flag.length'] or 1.5 * width
    top = settings['pole.height'] - settings['pole.diameter']
    return (0.5 * settings['pole.diameter'], 0.0, top), length, width


def cloth_of(settings):
    """Return the Cloth of settings, at rest; raises ValueError where there is none."""
    hoist_top, length, width = hang_of(settings)
    arguments = {name: settings[dial] for dial, name in CLOTH.items()}
    arguments.update(length=length, width=width, hoist_top=hoist_top)
    if settings['pole_collision']:
        arguments['pole'] = (0.0, 0.0, 0.5 * settings['pole.diameter'])
    material, air, stepping = (_make(record, names, settings)
                               for record, names in PHYSICS.items())
    return Cloth(**arguments, material=material, air=air, stepping=stepping)


class Look(NamedTuple):
    """Everything that a frame's picture depends on, but the cloth: arguments of Picture.draw."""

    camera: Camera
    light: Light
    materials: Materials
    scene: Scene
    style: Style


def look_of(settings):
    """Return the Look of settings; raises ValueError where there is none."""
    camera, light, scene, style = (_make(record, names, settings)
                                   for record, names in RENDERER.items())
    surfaces = Materials(**{thing: _make(Surface, _surface_names(thing), settings)
                            for thing in SURFACES})
    return Look(camera, light, surfaces, scene, style)


def picture_of(settings):
    """Return a Picture that draws with the settings' threads."""
    return Picture(settings['drawing.threads'])
