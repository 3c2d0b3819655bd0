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
Settings: {parameter name: value}, as in a params file of the nodes, and what they make.

Which there are follows from the library's own dataclasses: Light.azimuth is sun.azimuth.
"""
import dataclasses
from typing import NamedTuple

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.drawing import Camera, Dimensions, Light, Materials, Style, Surface

CLOTH = {'grid.rows': 'rows', 'grid.columns': 'columns', **{name: name for name in (
    'gravity', 'solver', 'stretch_limit', 'precision', 'start_noise', 'start_seed', 'threads')}}
"""The parameters of Cloth that it takes as they are, and the names of its arguments."""


def _names(record, prefix='', but=()):
    """Return {parameter: field} of a dataclass whose fields are parameters under a prefix."""
    return {prefix + field.name: field.name for field in dataclasses.fields(record)
            if field.name not in but}


MATERIAL = _names(Material)
AIR = _names(Air, 'air.')
STEPPING = _names(Stepping)
CAMERA = {('' if name in ('width', 'height') else 'camera.') + name: name
          for name in _names(Camera)}
LIGHT = {**_names(Light, 'sun.', but=['ambient']), 'ambient': 'ambient'}
# pole_height is pole.height
SCENE = {name.replace('_', '.', 1): name for name in _names(Dimensions)}
STYLE = _names(Style)
SURFACES = {
    'flag': _names(Surface, 'flag.'),  # only the flag is thin enough to let light through
    'pole': _names(Surface, 'pole.', but=['transmission']),
    'platform': _names(Surface, 'platform.', but=['transmission']),
}
COLOURS = ('background', *(f'{thing}.color' for thing in SURFACES))


def _make(record, names, settings):
    return record(**{field: settings[name] for name, field in names.items()})


def material_of(settings):
    """Return the cloth's Material; raises ValueError, as all of these, where there is none."""
    return _make(Material, MATERIAL, settings)


def air_of(settings):
    """Return the Air around the cloth."""
    return _make(Air, AIR, settings)


def stepping_of(settings):
    """Return the Stepping."""
    return _make(Stepping, STEPPING, settings)


def hang_of(settings):
    """
    Return (hoist_top, length, width) [m] of the flag (1.2).

    Unless given, the width is a sixth of the pole and the length one and a half times the width.
    The upper corner is on the pole's surface, one diameter below its top.
    """
    width = settings['flag.width'] or settings['pole.height'] / 6.0
    length = settings['flag.length'] or 1.5 * width
    top = settings['pole.height'] - settings['pole.diameter']
    return (0.5 * settings['pole.diameter'], 0.0, top), length, width


def pole_of(settings):
    """Return the cylinder (x, y, radius) [m] that the cloth stays out of, or None."""
    return (0.0, 0.0, 0.5 * settings['pole.diameter']) if settings['pole_collision'] else None


def cloth_of(settings):
    """Return the Cloth, at rest."""
    hoist_top, length, width = hang_of(settings)
    return Cloth(length=length, width=width, hoist_top=hoist_top, pole=pole_of(settings),
                 material=material_of(settings), air=air_of(settings),
                 stepping=stepping_of(settings),
                 **{argument: settings[name] for name, argument in CLOTH.items()})


class Look(NamedTuple):
    """Everything that a frame's picture depends on, but the cloth: arguments of Picture.draw."""

    camera: Camera
    light: Light
    materials: Materials
    dimensions: Dimensions
    style: Style


def look_of(settings):
    """
    Return the Look.

    Between black and another colour, keys pass through what Surface and Style refuse, for people
    who give it count colours from 0 to 1: that is black here.
    """
    settings = {name: (0.0, 0.0, 0.0) if name in COLOURS and 0.0 < max(value) <= 1.0 else value
                for name, value in settings.items()}
    return Look(
        _make(Camera, CAMERA, settings), _make(Light, LIGHT, settings),
        Materials(**{thing: _make(Surface, names, settings) for thing, names in SURFACES.items()}),
        _make(Dimensions, SCENE, settings), _make(Style, STYLE, settings))
