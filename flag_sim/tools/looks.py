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
Sheets of how a flag can look: `python3 -m flag_sim.tools.looks FOLDER`.

looks.png has the package's pictures on a flag, shadows.png a scene without and with shadows,
scene.png ground and sky.
"""
from collections.abc import Iterator, Sequence
from pathlib import Path
import sys

from flag_sim.cloth import Cloth
from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style
from flag_sim.drawing.image_file import read_picture
from flag_sim.parameters.config import config_path
from flag_sim.tools.images import IMAGES
import numpy as np
from PIL import Image

SIZE = {'width': 426, 'height': 320, 'target': (0.9, 0.2, 8.1), 'distance': 4.6}
FRONT, BACK = Camera(**SIZE, azimuth=-1.3), Camera(**SIZE, azimuth=1.5)
TOP = Camera(**{**SIZE, 'target': (0.6, 0.0, 8.5), 'distance': 3.0}, azimuth=-1.9)
FOOT = Camera(**{**SIZE, 'target': (0.0, 0.0, 0.25), 'distance': 3.2}, azimuth=-1.2, elevation=0.4)
WHOLE = Camera(426, 480, target=(-0.6, 0.0, 4.3), distance=18.0, azimuth=-1.3, elevation=0.1)
SIDEWAYS, MORNING = Light(azimuth=-2.2, elevation=0.8), Light(azimuth=-0.8, elevation=0.55)
RATE, FRAMES = 30.0, 100  # frames a second, and how many
STYLE, SHADOWS = Style(samples=8), Style(samples=8, shadows=True)


def blown() -> Cloth:
    """Return a cloth that has been in the wind for a while."""
    cloth = Cloth(31, 46, pole=(0.0, 0.0, 0.05))
    for _ in range(FRAMES):
        cloth.advance(1.0 / RATE, wind=(8.0, 3.0, 0.0))
    return cloth


def pictures(cloth: Cloth) -> Iterator[np.ndarray]:
    """Yield images (height, width, 3) of a flag with each of the package's, from both sides."""
    picture = Picture()
    for name, camera in zip(IMAGES, (FRONT, BACK, FRONT)):
        image = read_picture(config_path(f'{name}.png')).texture
        yield picture.draw(cloth.positions, cloth.normals(), camera, style=STYLE,
                           materials=Materials(flag_image=image)).colour.copy()


def shadows(cloth: Cloth) -> Iterator[np.ndarray]:
    """Yield images of the pole's top and of the platform, each without and with shadows."""
    picture = Picture()
    for camera, light in ((TOP, SIDEWAYS), (FOOT, MORNING)):
        for style in (STYLE, SHADOWS):
            yield picture.draw(cloth.positions, cloth.normals(), camera, light,
                               style=style).colour.copy()


def scenes(cloth: Cloth) -> Iterator[np.ndarray]:
    """Yield images of the whole scene: as by default, with ground and sky, with all there is."""
    picture, dimensions = Picture(), Dimensions(ground_visible=True)
    image = read_picture(config_path('cross.png')).texture
    yield picture.draw(cloth.positions, cloth.normals(), WHOLE, style=STYLE).colour.copy()
    for shadows, materials in ((False, Materials()), (True, Materials(flag_image=image))):
        style = Style(samples=8, sky_gradient=True, shadows=shadows)
        yield picture.draw(cloth.positions, cloth.normals(), WHOLE, MORNING, materials,
                           dimensions, style).colour.copy()


def main(args: Sequence[str] | None = None) -> int:
    """Write the sheets into the folder that is named; return the exit status."""
    given = sys.argv[1:] if args is None else args
    if len(given) != 1:
        print('usage: python3 -m flag_sim.tools.looks FOLDER', file=sys.stderr)
        return 2
    cloth = blown()
    for name, drawn in (('looks', pictures), ('shadows', shadows), ('scene', scenes)):
        sheet = Image.fromarray(np.hstack(list(drawn(cloth))))
        sheet.save(Path(given[0]) / f'{name}.png', optimize=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
