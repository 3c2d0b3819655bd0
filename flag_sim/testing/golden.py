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
from pathlib import Path

import numpy as np
from PIL import Image

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

        rgb: (height, width, 3) uint8; levels: by which a pixel's colour may differ.
        """
        stored, actual, difference = (self.folder / f'{name}{ending}.png'
                                      for ending in ('', '.actual', '.difference'))
        for left in (actual, difference):
            left.unlink(missing_ok=True)
        self.folder.mkdir(parents=True, exist_ok=True)
        if self._is_update:
            Image.fromarray(rgb).save(stored, optimize=True)
            return
        if not stored.exists():
            Image.fromarray(rgb).save(actual, optimize=True)
            raise AssertionError(f'there is no {stored}; {actual} is what was seen: keep it, or '
                                 'store all by pytest --golden-update')
        with Image.open(stored) as image:
            expected = np.asarray(image.convert('RGB'))
        if expected.shape != rgb.shape:
            Image.fromarray(rgb).save(actual, optimize=True)
            raise AssertionError(f'{stored} is {expected.shape[1]} x {expected.shape[0]} pixels, '
                                 f'and what was seen {rgb.shape[1]} x {rgb.shape[0]}: {actual}')
        off = np.abs(rgb.astype(int) - expected)
        if off.max(initial=0) > levels:
            Image.fromarray(rgb).save(actual, optimize=True)
            Image.fromarray(np.uint8(np.minimum(STRONGER * off, 255))).save(difference)
            raise AssertionError(
                f'{np.any(off > levels, axis=2).sum()} pixels differ from {stored} by more than '
                f'{levels} levels, by up to {off.max()}: see {actual} and {difference}')
