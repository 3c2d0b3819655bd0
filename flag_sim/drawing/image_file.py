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

"""Textures from files: a picture of any common format, at most as large as one is useful for."""
import os
from pathlib import Path
from typing import NamedTuple
import warnings

from flag_sim.drawing.texture import DECODE, LARGEST, Texture
from flag_sim.parameters.plain_file import opened

import numpy as np

LARGEST_FILE = 256 << 20
"""Bytes of a file."""
MOST_PIXELS = 2 ** 26
"""Of a picture, as 8192 x 8192: a small file can hold a picture that no memory holds."""
FORMATS = ('PNG', 'JPEG', 'WEBP', 'GIF', 'BMP', 'TIFF', 'PPM')
"""Those that Pillow reads by itself: for others it runs other programs, or reads other files."""

ORIENTATION = 0x0112
"""EXIF's tag of how a picture is to be turned."""
TURNS = {2: 'FLIP_LEFT_RIGHT', 3: 'ROTATE_180', 4: 'FLIP_TOP_BOTTOM', 5: 'TRANSPOSE',
         6: 'ROTATE_270', 7: 'TRANSVERSE', 8: 'ROTATE_90'}
"""{orientation: what makes it upright, by Pillow's name}."""
BITS, SENSE, WHITE_IS_ZERO = 258, 262, 0
"""TIFF's tags of the bits of a channel, and of whether 0 is white."""
DEEP = ('PNG', 'PPM')
"""Formats whose numbers of mode I go to 65535."""


class Picture(NamedTuple):
    """A texture, and the size of the picture that it was made from: (width, height) [pixel]."""

    texture: Texture
    size: tuple


def read_picture(path: str | os.PathLike) -> Picture:
    """
    Return the picture in a file as a texture.

    It is turned as its EXIF orientation says. What is larger than a Texture may be is scaled down,
    in linear light. What is transparent is seen before white. Colour profiles are not read: all is
    taken for sRGB. Raises ValueError, with path and reason, for a file that is missing or that
    cannot be read.
    """
    path = Path(path)
    try:
        from PIL import Image, UnidentifiedImageError  # which the library does without
    except ImportError:
        raise ValueError(f'{path} cannot be read: Pillow is not installed') from None
    try:
        with opened(path, LARGEST_FILE) as file, warnings.catch_warnings():
            warnings.simplefilter('ignore')  # of Pillow's about pictures that are large or odd
            with Image.open(file, formats=FORMATS) as image:
                size = image.size
                if size[0] * size[1] > MOST_PIXELS:
                    raise ValueError(f'{size[0]} x {size[1]} are more than {MOST_PIXELS} pixels')
                opaque = _opaque(Image, image)
                return Picture(_texture(opaque), opaque.size)
    except UnidentifiedImageError:
        reason = f'it is not one of {", ".join(FORMATS)}'
    except OSError as error:
        reason = error.strerror or _sentence(error)
    except Exception as error:  # noqa: B902 (what a damaged file ends in is any of Pillow's)
        reason = _sentence(error)
    raise ValueError(f'{path} is no picture that can be read: {reason}')


def _sentence(error):
    return ' '.join(str(error).split())[:200] or type(error).__name__


def _opaque(pillow, image):
    """Return an image of Pillow's upright, in red, green and blue; raises ValueError."""
    image.load()
    upright = _upright(pillow, image)
    if image.mode.startswith(('I', 'F')):
        return _of_grey(pillow, image, np.asarray(upright))
    if image.mode not in ('RGBA', 'LA', 'PA') and 'transparency' not in image.info:
        return upright.convert('RGB')
    white = pillow.new('RGBA', upright.size, 'white')
    return pillow.alpha_composite(white, upright.convert('RGBA')).convert('RGB')


def _upright(pillow, image):
    """Return an image turned as its EXIF orientation says."""
    try:
        turn = TURNS.get(image.getexif().get(ORIENTATION))
    except Exception:  # noqa: B902 (a damaged EXIF block, without which the picture is whole)
        turn = None
    return image.transpose(pillow.Transpose[turn]) if turn else image


def _of_grey(pillow, image, values):
    """
    Return an image of one channel that has more than 8 bits as 8 bits of three.

    values: of its pixels. Raises ValueError unless they are whole numbers of which 65535 is white:
    of others no file says how bright white is.
    """
    bits, sense = (getattr(image, 'tag_v2', {}).get(tag) for tag in (BITS, SENSE))
    # Before 10.3 Pillow reads a PNG of 16 bits as I, and all do so with a PPM of more than 8.
    if not (image.mode.startswith('I;16') or (image.mode == 'I' and image.format in DEEP)) or (
            bits not in (None, (16,)) or sense == WHITE_IS_ZERO):
        raise ValueError(f'its pixels are numbers of mode {image.mode}, with '
                         f'{bits[0] if bits else 32} bits, of which it does not say how bright '
                         'white is; save it with 8 or 16 bits a channel')
    grey = (values >> 8).astype(np.uint8)
    grey[values == image.info.get('transparency', -1)] = 255
    return pillow.fromarray(grey).convert('RGB')


def _texture(image):
    """Return the Texture of an image of Pillow's, scaled down if it is too large."""
    width, height = image.size
    scale = min(1.0, LARGEST / max(width, height))
    if scale == 1.0:
        return Texture(np.asarray(image))
    rows, columns = (np.unique(np.linspace(0, side, max(1, round(side * scale)) + 1).astype(int))
                     for side in (height, width))
    linear = np.empty((len(rows) - 1, len(columns) - 1, 3), np.float32)
    widths = np.diff(columns)[:, None]
    # A row at a time: the whole in linear light is four times as large as its bytes.
    for k, (first, end) in enumerate(zip(rows, rows[1:])):
        strip = DECODE[np.asarray(image.crop((0, int(first), width, int(end))))].mean(axis=0)
        linear[k] = np.add.reduceat(strip, columns[:-1], axis=0) / widths
    return Texture.of_light(linear)
