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

"""The look of a picture: materials of the things in it, and the style that they are drawn in."""
import dataclasses

from flag_sim.drawing.attributes import INTERPOLATIONS
from flag_sim.drawing.multisample import PATTERNS
from flag_sim.drawing.shading import refuse_unit_colour, Surface
from flag_sim.drawing.texture import Texture
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.declared import Declared, declared

import numpy as np

SHADINGS = ('gouraud', 'flat')
HIDDEN_SURFACES = ('zbuffer', 'painter')
SAMPLES = tuple(PATTERNS)

THREADS = Declaration(
    'threads', 1, 'threads that draw; 0: as many as the first frames show to be worth it', '',
    0, 64, fixed=True)


@dataclasses.dataclass(frozen=True)
class Materials:
    """
    What the things of the scene are made of; raises ValueError for other classes.

    flag_image: a picture on the flag, which takes the place of its colour, or None.
    """

    flag: Surface = Surface((205.0, 35.0, 40.0), transmission=0.3)
    pole: Surface = Surface((200.0, 200.0, 205.0))
    platform: Surface = Surface((150.0, 145.0, 135.0))
    ground: Surface = Surface((125.0, 140.0, 95.0))
    flag_image: Texture | None = None

    def __post_init__(self):
        """Refuse what is no Surface or Texture."""
        for name in ('flag', 'pole', 'platform', 'ground'):
            checks.instance(name, getattr(self, name), Surface)
        if self.flag_image is not None:
            checks.instance('flag_image', self.flag_image, Texture)


@dataclasses.dataclass(frozen=True)
class Style(Declared):
    """
    How the picture is made.

    background: (3,) colour where nothing is, 0 to 255; sky_gradient: whether it is that of the
    horizon, and the sky above goes to sky_zenith (3,), that of the zenith (see sky); shading:
    'gouraud' interpolates the vertices' colours, 'flat' gives each triangle one; interpolation: of
    colours, 'screen' is linear from pixel to pixel as in 1.14, 'perspective' linear in space;
    samples: 1 shows the colour at a pixel's centre, 4, 8 or 16 average it with so many more where
    there is an edge; hidden_surface: 'zbuffer' compares the depths of each pixel, 'painter' draws
    whole triangles from far to near, wrong where they overlap in turn or cut one another; outline:
    draw the triangles' edges, darker; shadows: whether what the sun does not see has only ambient
    light.
    Raises ValueError for a colour out of range, another word or another number.
    """

    background: tuple = declared((180.0, 240.0, 240.0),
                                 'colour where nothing is: red, green, blue', '', 0.0, 255.0)
    sky_gradient: bool = declared(
        False, 'the sky goes from background at the horizon to sky.zenith', name='sky.gradient')
    sky_zenith: tuple = declared((70.0, 120.0, 190.0), 'colour of the sky above us', '', 0.0,
                                 255.0, name='sky.zenith')
    samples: int = declared(1, '1: at pixel centres alone; 4, 8 or 16 more where edges are',
                            choices=SAMPLES)
    shading: str = declared('gouraud', 'light at vertices and between, or one per triangle',
                            choices=SHADINGS)
    interpolation: str = declared(
        'screen', 'of light between vertices: linear on the screen or in space',
        choices=INTERPOLATIONS)
    hidden_surface: str = declared(
        'zbuffer', 'nearest of every pixel, or triangles from far to near',
        choices=HIDDEN_SURFACES)
    outline: bool = declared(False, 'draw the edges of the triangles, darker')
    shadows: bool = declared(False, 'shadows of everything on everything')

    def __post_init__(self):
        """Refuse unknown words and colours."""
        super().__post_init__()
        refuse_unit_colour('background', self.background)
        refuse_unit_colour('sky_zenith', self.sky_zenith)

    @property
    def clear_colour(self) -> np.uint32:
        """Return the background as the rasterizer packs it (see pack_rgb): red lowest."""
        red, green, blue = (int(channel + 0.5) for channel in self.background)
        return np.uint32(red | green << 8 | blue << 16)
