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

"""Factories: the library's objects from values {parameter: value}, as in a params file."""
from collections.abc import Mapping
import dataclasses
import functools
from typing import NamedTuple

from flag_sim.cloth import Cloth
from flag_sim.declarations.images import picture_of
from flag_sim.declarations.objects import boxes_of
from flag_sim.declarations.physics import AIR, GRID, MATERIAL, OPTIONS, STEPPING
from flag_sim.declarations.renderer import CAMERA, IMAGE, LIGHT, RENDERER, STYLE, SURFACES
from flag_sim.declarations.scene import DIMENSIONS, PLACE
from flag_sim.drawing import Camera, Dimensions, Light, Materials, Style
from flag_sim.drawing.dimensions import Place
from flag_sim.drawing.transforms import apply
import numpy as np

Values = Mapping[str, object]

# Each raises ValueError for values that the object cannot have.
material_of = MATERIAL.make
air_of = AIR.make
stepping_of = STEPPING.make


def hang_of(values: Values) -> tuple[tuple[float, float, float], float, float]:
    """
    Return (hoist_top, length, width) [m] of the flag (sec. 1.2).

    Unless given, the width is a sixth of the pole and the length one and a half times the width.
    The upper corner is on the pole's surface, one diameter below its top; where the pole is, is
    said by pose_of.
    """
    width = values['flag.width'] or values['pole.height'] / 6.0
    length = values['flag.length'] or 1.5 * width
    top = values['pole.height'] - values['pole.diameter']
    return (0.5 * values['pole.diameter'], 0.0, top), length, width


def pole_of(values: Values) -> tuple[float, float, float] | None:
    """Return the cylinder (x, y, radius) [m] that the cloth stays out of, or None."""
    return (0.0, 0.0, 0.5 * values['pole.diameter']) if values['pole_collision'] else None


def pose_of(values: Values) -> np.ndarray:
    """Return where the pole is: the map (4, 4) from a pole at the origin to the world."""
    position, yaw, tilt = (values[declaration.name] for declaration in PLACE)
    return _pose(Place(tuple(position), yaw, tilt))


@functools.lru_cache(maxsize=8)
def _pose(place):
    pose = place.pose
    pose.flags.writeable = False
    return pose


def hoist_of(values: Values) -> np.ndarray:
    """Return where the upper corner of the hoist is in the world (3,) [m]."""
    return apply(pose_of(values), hang_of(values)[0])


def cloth_of(values: Values) -> Cloth:
    """Return the Cloth, at rest; raises ValueError for values that it cannot have."""
    hoist_top, length, width = hang_of(values)
    cloth = Cloth(length=length, width=width, hoist_top=hoist_top, pole=pole_of(values),
                  material=material_of(values), air=air_of(values), stepping=stepping_of(values),
                  **GRID.arguments(values), **OPTIONS.arguments(values))
    cloth.pose = pose_of(values)
    return cloth


class Look(NamedTuple):
    """All that a frame's picture depends on beside the cloth: arguments of Picture.draw."""

    camera: Camera
    light: Light
    materials: Materials
    dimensions: Dimensions
    style: Style


COLOURS = tuple(declaration.name for declaration in RENDERER
                if declaration.length and (declaration.low, declaration.high) == (0.0, 255.0))


def look_of(values: Values) -> Look:
    """
    Return the Look; raises ValueError for what it cannot have, as an image that cannot be read.

    Between black and another colour, keys pass through what Surface and Style refuse, for people
    who give it count colours from 0 to 1: that is black here.
    """
    values = {name: (0.0, 0.0, 0.0) if name in COLOURS and 0.0 < max(value) <= 1.0 else value
              for name, value in values.items()}
    picture = picture_of(values[IMAGE.name])
    return Look(
        CAMERA.make(values), LIGHT.make(values),
        Materials(**{thing: group.make(values) for thing, group in SURFACES.items()},
                  flag_image=picture and picture.texture),
        dataclasses.replace(DIMENSIONS.make(values), boxes=boxes_of(values)), STYLE.make(values))
