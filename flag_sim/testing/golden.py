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

"""Golden frames: images that are stored beside a test, and compared with what it sees."""
import contextlib
import os
from pathlib import Path

from flag_sim.parameters import checks
import numpy as np
from PIL import Image

LONGEST_NAME = 255 - len('.difference.png')
"""Bytes of a name: file systems take 255 of a file's."""
STRONGER = 8
"""By how much a picture of the difference shows each level."""


class Golden:
    """
    Compares images with the PNG files of a folder; is_update: stores them instead.

    Where one differs, the image and a picture of the difference are left beside the stored one, as
    NAME.actual.png and NAME.difference.png: black where nothing differs.
    """

    def __init__(self, folder: Path, is_update: bool = False):
        self.folder = Path(folder)
        self._is_update = is_update

    def __call__(self, name: str, rgb: np.ndarray, levels: int = 0) -> None:
        """
        Raise AssertionError unless an image is the stored one.

        rgb: (height, width, 3) uint8; levels: by which a pixel's colour may differ. Raises
        ValueError for other arrays and levels, for one without pixels, and for a name that no file
        can have or with a folder in it.
        """
        checks.require(getattr(rgb, 'dtype', None) == np.uint8 and rgb.ndim == 3
                       and rgb.shape[2] == 3 and rgb.size, 'rgb',
                       'of shape (height, width, 3), neither of them 0, and uint8',
                       f'{getattr(rgb, "shape", None)} {getattr(rgb, "dtype", None)}')
        checks.require(isinstance(name, str) and name and Path(name).name == name, 'name',
                       'of a file, without folders', name)
        checks.require('\0' not in name and len(os.fsencode(name)) <= LONGEST_NAME, 'name',
                       f'of a file, of at most {LONGEST_NAME} bytes', name)
        rgb, levels = np.asarray(rgb), checks.whole('levels', levels, 0, 255)
        stored, actual, difference = (self.folder / f'{name}{ending}.png'
                                      for ending in ('', '.actual', '.difference'))
        if self._is_update:
            self.folder.mkdir(parents=True, exist_ok=True)
            Image.fromarray(rgb).save(stored, optimize=True)
            said, left = '', []
        else:
            said, left = self._compare(rgb, levels, stored)
        for path in (actual, difference):
            with contextlib.suppress(OSError):  # sources may be mounted to be read only
                path.unlink(missing_ok=True)
        for path, pixels in zip((actual, difference), left):
            with contextlib.suppress(OSError):
                self.folder.mkdir(parents=True, exist_ok=True)
                Image.fromarray(pixels).save(path, optimize=True)
                said += f'; see {path}'
        if said:
            raise AssertionError(said)

    @staticmethod
    def _compare(rgb, levels, stored):
        """Return in words what is not as it is stored, or '', and the pictures that show it."""
        if not stored.exists():
            return f'there is no {stored}: store what is seen by pytest --golden-update', [rgb]
        try:
            with Image.open(stored) as image:
                expected = np.asarray(image.convert('RGB'))
        except (OSError, SyntaxError) as error:  # which Pillow raises of a broken file
            return (f'{stored} cannot be read: {error}; store it anew by pytest '
                    '--golden-update'), [rgb]
        if expected.shape != rgb.shape:
            return (f'{stored} is {expected.shape[1]} x {expected.shape[0]} pixels, and what was '
                    f'seen {rgb.shape[1]} x {rgb.shape[0]}'), [rgb]
        off = np.abs(rgb.astype(int) - expected)
        if off.max(initial=0) <= levels:
            return '', []
        return (f'{np.any(off > levels, axis=2).sum()} pixels differ from {stored} by more than '
                f'{levels} levels, by up to {off.max()}'), [
                    rgb, np.uint8(np.minimum(STRONGER * off, 255))]
