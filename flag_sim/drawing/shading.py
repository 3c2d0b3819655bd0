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

"""Shading: the colours of vertices under a light, for Gouraud shading (eqs. 1.13, 1.14)."""
import dataclasses
import math
from typing import NamedTuple

from flag_sim.jit.kernels import late_kernel
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import TURN
from flag_sim.parameters.declared import Declared, declared

import numpy as np


# The sun is dimmed where it stands lower than this above the horizon [rad].
DIM_BELOW = 0.1


def refuse_unit_colour(name: str, colour: tuple) -> None:
    """
    Raise ValueError for a colour, 0 to 255, whose channels all are from 0 to 1, but for black.

    Nobody wants to see that, and other programs count colours from 0 to 1.
    """
    checks.require(not 0.0 < max(colour) <= 1.0, name,
                   'red, green and blue from 0 to 255, one of them above 1 unless all are 0',
                   colour)


@dataclasses.dataclass(frozen=True)
class Light(Declared):
    """
    The sun, which is a direction, and the light that comes from everywhere.

    azimuth: [rad] from x towards y, and elevation: [rad] above the horizon, of the place where
    the sun stands; intensity: of its light; ambient: of the other. A surface of diffuse 1 that
    faces the sun shows its own colour where intensity + ambient = 1. A sun lower than DIM_BELOW is
    dimmed; below the ground it does not shine: what is left is the ambient light. Raises
    ValueError for a value out of its range.
    """

    azimuth: float = declared(-1.0, 'where the sun stands, from +x towards +y', 'rad',
                              -TURN, TURN)
    elevation: float = declared(0.7, 'where the sun stands, above the horizon', 'rad',
                                -math.pi / 2.0, math.pi / 2.0)
    intensity: float = declared(0.8, 'light of the sun', '', 0.0, 10.0)
    ambient: float = declared(0.35, 'light from everywhere', '', 0.0, 10.0, name='ambient')

    @property
    def direction(self) -> tuple:
        """Return the unit vector towards the sun: (x, y, z)."""
        across = math.cos(self.elevation)
        return (across * math.cos(self.azimuth), across * math.sin(self.azimuth),
                math.sin(self.elevation))

    @property
    def sunlight(self) -> float:
        """
        Return how much light of the sun arrives: less near the horizon, and none below it.

        The way through the air is ever longer there, and dims the sun until it is gone: without a
        step when it rises. The curve is a smoothstep, not one of measured air.
        """
        risen = min(max(self.elevation / DIM_BELOW, 0.0), 1.0)
        return self.intensity * risen * risen * (3.0 - 2.0 * risen)


@dataclasses.dataclass(frozen=True)
class Surface(Declared):
    """
    What a surface returns of the light.

    color: (3,) red, green, blue, each 0 to 255; diffuse: Lambert's coefficient, 0 switches the
    sun off; specular: of the sun's reflection, which is white, and shininess: the exponent that
    makes it small (Blinn, 1977); transmission: what a thin cloth lets through of the light on
    its other side, in its own colour. A coefficient of 0 switches its term off.
    Raises ValueError for a value out of its range, and for a colour from 0 to 1 (see
    refuse_unit_colour).
    """

    color: tuple = declared((255.0, 255.0, 255.0), 'colour of the {thing}: red, green, blue', '',
                            0.0, 255.0)
    diffuse: float = declared(1.0, 'share of the sun that the {thing} returns', '', 0.0, 10.0)
    specular: float = declared(0.0, 'strength of the sun mirrored by the {thing}; 0: off', '',
                               0.0, 10.0)
    shininess: float = declared(30.0, 'exponent of the mirrored sun: more is smaller', '',
                                1.0, 1000.0)
    transmission: float = declared(
        0.0, 'share of the sun that shines through the {thing}; 0: off', '', 0.0, 1.0)

    def __post_init__(self):
        """Refuse what no surface can be."""
        super().__post_init__()
        refuse_unit_colour('color', self.color)


class Lighting(NamedTuple):
    """
    A light on one surface, for the kernels.

    sun: (3,) unit vector towards the sun; of a surface of colour 1: ambient, and what the sun
    adds where it stands in the direction of the normal: diffuse, transmitted to the other side,
    and specular [level] with its exponent shininess.
    """

    sun: tuple
    ambient: float
    diffuse: float
    transmitted: float
    specular: float
    shininess: float


def shade(points: np.ndarray, normals: np.ndarray, viewpoint: np.ndarray, surface: Surface,
          light: Light, colours: np.ndarray) -> None:
    """
    Light both sides of a surface with normals (n, 3), of any length, at points (n, 3) [m].

    viewpoint: (4,) of Camera. Writes colours (n, 2, 3), 0 to 255: [:, 0] of the side that the
    normal points from, [:, 1] of the other side, whose normal is the opposite one. Which side the
    eye meets is the triangle's matter, so a side that turns its back to the sun gets only what
    shines through (|n . l| of 1.14 would light it). Brighter than 255 is 255, channel by channel.
    A normal that is zero or not finite gets the ambient light alone; points are only read where
    the surface is specular.
    """
    lighting = _lighting(surface, light)
    _shade_diffuse(normals, lighting, surface.color, colours)
    if lighting.specular > 0.0:
        _add_specular(points, normals, viewpoint, lighting, colours)


def light_levels(points: np.ndarray, normals: np.ndarray, viewpoint: np.ndarray,
                 surface: Surface, light: Light, levels: tuple) -> None:
    """
    Write the light of the sun alone, for surfaces whose pixels are shaded one by one.

    The others: see shade. levels: two arrays (n, 2, 3), of which [..., 0] is set: of light that
    is multiplied to a colour, and of the mirrored sun, from 0 to 255, that is added.
    """
    sun, mirrored = levels
    lighting = _lighting(surface, light)._replace(ambient=0.0)
    _shade_diffuse(normals, lighting, (1.0, 0.0, 0.0), sun)
    mirrored[:] = 0.0
    if lighting.specular > 0.0:
        _add_specular(points, normals, viewpoint, lighting, mirrored)


def _lighting(surface, light):
    sun = light.sunlight
    return Lighting(light.direction, light.ambient, sun * surface.diffuse,
                    sun * surface.transmission, 255.0 * sun * surface.specular,
                    surface.shininess)


@late_kernel
def _shade_diffuse(normals, lighting, color, colours):
    """Write color (ambient + diffuse max(0, +-n . l) + transmitted max(0, -+n . l))."""
    lx, ly, lz = lighting.sun
    ambient, diffuse, transmitted = lighting.ambient, lighting.diffuse, lighting.transmitted
    red, green, blue = color
    # Places that are constants apart let LLVM vectorise the loop.
    flat, out = normals.reshape(-1), colours.reshape(-1)
    for i in range(np.uint64(normals.shape[0])):
        p, q = np.uint64(3) * i, np.uint64(6) * i
        nx, ny, nz = flat[p], flat[p + np.uint64(1)], flat[p + np.uint64(2)]
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        is_known = (0.0 < length) & (length < math.inf)
        cosine = (nx * lx + ny * ly + nz * lz) / length if is_known else 0.0
        toward, away = max(cosine, 0.0), max(-cosine, 0.0)
        level = ambient + diffuse * toward + transmitted * away
        out[q] = min(red * level, 255.0)
        out[q + np.uint64(1)] = min(green * level, 255.0)
        out[q + np.uint64(2)] = min(blue * level, 255.0)
        level = ambient + diffuse * away + transmitted * toward
        out[q + np.uint64(3)] = min(red * level, 255.0)
        out[q + np.uint64(4)] = min(green * level, 255.0)
        out[q + np.uint64(5)] = min(blue * level, 255.0)


@late_kernel
def _add_specular(points, normals, viewpoint, lighting, colours):
    """Add specular (n . h)^shininess, h halfway between sun and eye, on the side of the sun."""
    lx, ly, lz = lighting.sun
    for i in range(normals.shape[0]):
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        ex = viewpoint[0] - viewpoint[3] * points[i, 0]
        ey = viewpoint[1] - viewpoint[3] * points[i, 1]
        ez = viewpoint[2] - viewpoint[3] * points[i, 2]
        to_eye = math.sqrt(ex * ex + ey * ey + ez * ez)
        hx, hy, hz = lx * to_eye + ex, ly * to_eye + ey, lz * to_eye + ez
        lengths = math.sqrt((nx * nx + ny * ny + nz * nz) * (hx * hx + hy * hy + hz * hz))
        if not 0.0 < lengths < math.inf:
            continue
        toward_sun = nx * lx + ny * ly + nz * lz
        side = 0 if toward_sun > 0.0 else 1
        cosine = abs(nx * hx + ny * hy + nz * hz) / lengths
        # The eye must be on the same side as the sun.
        if toward_sun * (nx * ex + ny * ey + nz * ez) > 0.0:
            highlight = lighting.specular * min(cosine, 1.0) ** lighting.shininess
            for channel in range(3):
                colours[i, side, channel] = min(colours[i, side, channel] + highlight, 255.0)
