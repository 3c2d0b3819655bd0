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

"""Light and matter: Lambert's law at vertices, for Gouraud's shading (1.12 to 1.14)."""
import dataclasses
import functools
import math

from flag_sim.drawing import checks
from flag_sim.kernels import kernel

import numpy as np


@dataclasses.dataclass(frozen=True)
class Light:
    """
    The sun, which is a direction, and the light that comes from everywhere.

    azimuth: [rad] from x towards y, and elevation: [rad] above the horizon, of the place where
    the sun stands; intensity: of its light; ambient: of the other. A surface of diffuse 1 that
    faces the sun shows its own colour where intensity + ambient = 1. A sun below the ground does
    not shine: what is left is the ambient light. Raises ValueError for what is not finite, and
    for intensities below 0.
    """

    azimuth: float = -1.0
    elevation: float = 0.7
    intensity: float = 0.8
    ambient: float = 0.35

    def __post_init__(self):
        """Refuse what cannot shine; keep plain numbers."""
        keep = functools.partial(object.__setattr__, self)
        for name in ('azimuth', 'elevation'):
            keep(name, checks.finite(name, getattr(self, name)))
        for name in ('intensity', 'ambient'):
            keep(name, checks.not_negative(name, getattr(self, name)))

    @property
    def direction(self):
        """Give the unit vector towards the sun: (x, y, z)."""
        across = math.cos(self.elevation)
        return (across * math.cos(self.azimuth), across * math.sin(self.azimuth),
                math.sin(self.elevation))

    @property
    def is_up(self):
        """Whether the sun stands above the ground or on its rim."""
        return math.sin(self.elevation) >= 0.0


@dataclasses.dataclass(frozen=True)
class Material:
    """
    What a surface returns of the light.

    color: (3,) red, green, blue, each 0 to 255; diffuse: Lambert's coefficient, 0 switches the
    sun off. Raises ValueError for colours out of range and for a negative or infinite diffuse.
    """

    color: tuple = (255.0, 255.0, 255.0)
    diffuse: float = 1.0

    def __post_init__(self):
        """Refuse what no surface can be; keep plain numbers."""
        object.__setattr__(self, 'color', checks.color('color', self.color))
        object.__setattr__(self, 'diffuse', checks.not_negative('diffuse', self.diffuse))


def shade(normals, material, light):
    """
    Light both sides of a surface whose normals are `normals` (n, 3), of any length.

    Returns colours (2, n, 3), 0 to 255: [0] of the side that the normal points from, [1] of the
    other side, whose normal is the opposite one. Which side the eye meets is the triangle's
    matter, so a side that turns its back to the sun stays dark (|n . l| of 1.14 would light it).
    A normal that is zero or not finite gets the ambient light alone.
    """
    colours = np.empty((2, len(normals), 3))
    sunlight = light.intensity * material.diffuse if light.is_up else 0.0
    _lambert(normals, *light.direction, *material.color, light.ambient, sunlight, colours)
    return colours


@kernel
def _lambert(normals, lx, ly, lz, red, green, blue, ambient, sunlight, colours):
    """Colour = matter (ambient + sunlight max(0, +-n . l)), held in 0..255."""
    for i in range(normals.shape[0]):
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        cosine = 0.0
        if 0.0 < length < math.inf:
            cosine = (nx * lx + ny * ly + nz * lz) / length
        for side in range(2):
            facing = cosine if side == 0 else -cosine
            level = ambient + sunlight * max(facing, 0.0)
            colours[side, i, 0] = min(red * level, 255.0)
            colours[side, i, 1] = min(green * level, 255.0)
            colours[side, i, 2] = min(blue * level, 255.0)
