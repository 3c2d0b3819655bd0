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
The pictures for flags that come with the package: `python3 -m flag_sim.tools.images [FOLDER]`.

They are nobody's flags, and free like the rest of the package.
"""
from collections.abc import Sequence
from pathlib import Path
import sys

import numpy as np
from PIL import Image

WIDTH, HEIGHT = 768, 512  # as the flag's sides are
TEAL, SAND, CORAL = (0, 110, 115), (250, 240, 215), (225, 85, 60)
VIOLET, YELLOW = (70, 40, 120), (250, 200, 60)
FIELDS = 6  # of the checker, from upper to lower edge


def tricolour() -> np.ndarray:
    """Return three bars side by side: (HEIGHT, WIDTH, 3) uint8."""
    bars = np.array([CORAL, SAND, TEAL], np.uint8)
    return np.broadcast_to(bars[np.arange(WIDTH) * 3 // WIDTH], (HEIGHT, WIDTH, 3))


def cross() -> np.ndarray:
    """Return a cross that lies, as in the north: its upright is nearer to the hoist."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    across = np.minimum(np.abs(u + 0.5 - 0.36 * WIDTH), np.abs(v + 0.5 - 0.5 * HEIGHT))
    image = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    image[:] = VIOLET
    image[across < 0.11 * HEIGHT] = SAND
    image[across < 0.06 * HEIGHT] = YELLOW
    return image


def checker() -> np.ndarray:
    """Return squares in black and white, with which one sees how the cloth is stretched."""
    v, u = np.mgrid[:HEIGHT, :WIDTH] * FIELDS // HEIGHT
    return np.repeat(np.uint8(np.where((u + v) % 2, 20, 240))[..., None], 3, axis=2)


IMAGES = {'tricolour': tricolour, 'cross': cross, 'checker': checker}


def main(args: Sequence[str] | None = None) -> int:
    """Write the pictures into the folder that is named, or else config/; return the status."""
    given = sys.argv[1:] if args is None else args
    folder = Path(given[0]) if given else Path(__file__).resolve().parents[2] / 'config'
    for name, draw in IMAGES.items():
        Image.fromarray(draw()).quantize(4).save(folder / f'{name}.png', optimize=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
