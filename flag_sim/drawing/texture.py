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
Textures: pictures on surfaces, filtered trilinearly (Williams, 1983).

A pixel shows the average of the texels under it, or something between texels where these are
larger than pixels. Averages of light are right only where numbers are proportional to light,
which bytes of sRGB are not: of black and white in equal parts they make 188, not 128. So texels
are decoded once (IEC 61966-2-1), mipmaps and what lies between texels are computed in linear
light, and the result is encoded again. It then stands where the colour of a plain surface stands:
light is multiplied to encoded values, as it is to `Surface.color`, so that a texture of one
colour looks like a surface of that colour.
"""
import functools

from flag_sim.drawing import ranges
from flag_sim.drawing.flat_tiles import flat_tiles
from flag_sim.drawing.pixels import POSITIVE
from flag_sim.jit.kernels import late_inner_kernel
from flag_sim.parameters import checks

import numpy as np

# Along a side: what is larger is to be scaled down first. A flag of 61 x 41 nodes has 45 by then
# between two nodes, and as many texels take 45 MB with their mipmaps.
LARGEST = 2048


def _decoded(encoded):
    """Return linear light from 0 to 1 of sRGB values from 0 to 1."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _encoded(linear):
    """Return sRGB values from 0 to 1 of linear light from 0 to 1."""
    return np.where(linear <= 0.0031308, 12.92 * linear,
                    1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)


# Of ENCODE; from one to the next it is less than 0.09 of a level.
ENTRIES = 4096
# A texel is two words of 32 bits: red and green, then its blue and that of the texel to its right,
# 16 bits each. They are roots of linear light in so many steps, a whole number to an entry.
STEPS = 16 * (ENTRIES - 1)
LOW, HIGH = np.uint32(0xffff), np.uint32(16)
# What bilinear() returns for light of 1, upside down.
SCALE = 1.0 / STEPS ** 2


def _tables():
    """Return DECODE and ENCODE, by which each of the 256 levels becomes itself."""
    levels = np.arange(256)
    entries = np.rint((ENTRIES - 1) * np.sqrt(_decoded(levels / 255.0))).astype(int)
    encode = 255.0 * _encoded((np.arange(ENTRIES) / (ENTRIES - 1)) ** 2)
    encode[entries] = levels
    return ((entries / (ENTRIES - 1)) ** 2).astype(np.float32), encode.astype(np.float32)


DECODE, ENCODE = _tables()
"""
Linear light of the 256 levels, and the level of linear light by the nearest entry to its root.

The square root is nearly what sRGB is. Both tables are off by at most 0.05 of a level.
"""


class Texture:
    """
    A picture for a surface, with its mipmaps.

    image: (height, width, 3) uint8, red, green and blue, sRGB; the first row is at v = 0, the
    first column at u = 0. Beyond its edges it goes on as there. Raises ValueError for other
    shapes and types, and for more than LARGEST pixels along a side.
    """

    __slots__ = ('size', 'texels', 'levels', 'flats', '__weakref__')

    def __init__(self, image: np.ndarray):
        """Make the mipmaps down to a single texel."""
        image = ranges.numbers('image', image)
        checks.require(image.ndim == 3 and image.shape[2] == 3 and image.dtype == np.uint8,
                       'image', '(height, width, 3) of uint8', f'{image.dtype} {image.shape}')
        checks.require(0 < min(image.shape[:2]) and max(image.shape[:2]) <= LARGEST, 'image',
                       f'of 1 to {LARGEST} pixels along a side', image.shape[:2])
        self._make(DECODE[image])

    @classmethod
    def of_light(cls, linear: np.ndarray) -> 'Texture':
        """
        Return one of an image in linear light, (height, width, 3) from 0 to 1.

        What is beyond is cut off, for ENCODE knows nothing else; what is no number is 0.
        """
        texture = cls.__new__(cls)
        texture._make(np.clip(np.nan_to_num(linear), 0.0, 1.0).astype(np.float32))
        return texture

    def _make(self, linear):
        self.size = linear.shape[1], linear.shape[0]
        mipmaps = [linear]
        while max(mipmaps[-1].shape[:2]) > 1:
            mipmaps.append(halved(halved(mipmaps[-1], 0), 1))
        # One texel more on each side, so that those beside a place are always there.
        padded = [_packed(np.pad(mipmap, ((1, 1), (1, 1), (0, 0)), mode='edge'))
                  for mipmap in mipmaps]
        starts = np.cumsum([0] + [one.shape[0] * one.shape[1] for one in padded])
        self.levels = np.array([(start, one.shape[1] - 2, one.shape[0] - 2)
                                for start, one in zip(starts, padded)])
        self.texels = np.concatenate([one.reshape(-1) for one in padded])
        self.flats = flat_tiles(padded, _levels_of_roots())
        for array in (self.texels, self.levels, self.flats):
            array.flags.writeable = False

    def mipmap(self, level: int) -> np.ndarray:
        """Return a mipmap in linear light: (height, width, 3)."""
        start, width, height = self.levels[level]
        texels = self.texels[2 * start:2 * (start + (width + 2) * (height + 2))]
        inner = texels.reshape(height + 2, width + 2, 2)[1:-1, 1:-1]
        roots = np.stack([inner[..., 0] & LOW, inner[..., 0] >> HIGH, inner[..., 1] & LOW], axis=2)
        return ((roots / STEPS) ** 2).astype(np.float32)


@functools.lru_cache(maxsize=1)
def _levels_of_roots():
    """Return the level that each of the STEPS + 1 roots of linear light is, -1 if it is none."""
    levels = np.full(STEPS + 1, -1)
    is_whole = ENCODE == np.rint(ENCODE)
    levels[::STEPS // (ENTRIES - 1)][is_whole] = np.rint(ENCODE[is_whole])
    return levels


def _packed(linear):
    """Return an image in linear light (height, width, 3) as texels (height, width, 2)."""
    red, green, blue = np.rint(np.sqrt(np.moveaxis(linear, 2, 0)) * STEPS).astype(np.uint32)
    right = np.concatenate([blue[:, 1:], blue[:, -1:]], axis=1)
    return np.stack([red | green << HIGH, blue | right << HIGH], axis=2)


def halved(linear: np.ndarray, axis: int) -> np.ndarray:
    """
    Return an image (height, width, 3) with half as many pixels along an axis, rounded down.

    Each is the average of the area under it: of two pixels, or, where their number is 2 n + 1, of
    2 + 1 / n.
    """
    values = np.moveaxis(linear, axis, 0)
    count, half = len(values), len(values) // 2
    if count == 1:
        return linear
    if count % 2 == 0:
        smaller = 0.5 * (values[0::2] + values[1::2])
    else:
        k = np.arange(half, dtype=np.float32)[:, None, None]
        smaller = ((half - k) * values[0:-1:2] + half * values[1::2]
                   + (k + 1.0) * values[2::2]) / np.float32(count)
    return np.moveaxis(smaller, 0, axis)


@late_inner_kernel
def bilinear(texels, start, size, place):
    """
    Return red, green and blue between four texels of a mipmap, in steps of linear light.

    start: of the mipmap in texels; size: its width and height; place: x and y from 0 to 1.
    """
    # Texels' centres are at halves, and the first texel is beside the edge.
    half, one = np.float32(0.5), np.float32(1.0)
    x, y = place[0] * np.float32(size[0]) + half, place[1] * np.float32(size[1]) + half
    column, row = np.int32(x), np.int32(y)
    right, down = x - np.float32(column), y - np.float32(row)
    stride = np.int32(size[0] + np.int32(2))
    here = np.int32(np.int32(start + np.int32(row * stride)) + column)
    below = np.int32(here + stride)
    left, up = one - right, one - down
    shares = up * left, up * right, down * left, down * right
    words = (_word(texels, here, 0), _word(texels, here, 2), _word(texels, below, 0),
             _word(texels, below, 2))
    blues = _word(texels, here, 1), _word(texels, below, 1)
    return (_mixed(shares, words[0] & LOW, words[1] & LOW, words[2] & LOW, words[3] & LOW),
            _mixed(shares, words[0] >> HIGH, words[1] >> HIGH, words[2] >> HIGH,
                   words[3] >> HIGH),
            _mixed(shares, blues[0] & LOW, blues[0] >> HIGH, blues[1] & LOW, blues[1] >> HIGH))


@late_inner_kernel
def _word(texels, texel, k):
    """Return word k of a texel and those after it."""
    return texels[np.uint32(np.int32(np.int32(2) * texel) + np.int32(k)) & POSITIVE]


@late_inner_kernel
def _mixed(shares, here, beside, below, across):
    """Return the light of four texels' roots in these shares."""
    return (_light(shares[0], here) + _light(shares[1], beside) + _light(shares[2], below)
            + _light(shares[3], across))


@late_inner_kernel
def _light(share, root):
    # In this order: LLVM would multiply the root with itself as whole numbers, slowly.
    root = np.float32(np.int32(root))
    return share * root * root


@late_inner_kernel
def half_to_the(level):
    """Return 2^-level as a float32, of a level that is an int32: by its exponent."""
    return np.int32(np.int32(np.int32(127) - level) << 23).view(np.float32)


@late_inner_kernel
def log2(value):
    """Return the logarithm of a float32 above 1, to 0.0002: by its exponent and a polynomial."""
    bits = np.float32(value).view(np.int32)
    exponent = np.float32(np.int32(np.int32(bits >> 23) - np.int32(127)))
    # From 1 to 2, least squares of log2 that are 0 and 1 at the ends.
    m = np.int32((bits & 0x7fffff) | 0x3f800000).view(np.float32) - np.float32(1.0)
    return exponent + m * (LOG2[0] + m * (LOG2[1] + m * (LOG2[2] + m * LOG2[3])))


def _log2_polynomial():
    x = np.linspace(0.0, 1.0, 1001)
    # p(1) = 1 leaves three free coefficients of four.
    powers = np.stack([x ** k - x for k in (2, 3, 4)], axis=1)
    free = np.linalg.lstsq(powers, np.log2(1.0 + x) - x, rcond=None)[0]
    return tuple(np.float32(c) for c in (1.0 - free.sum(), *free))


LOG2 = _log2_polynomial()


@late_inner_kernel
def encode(linear, table):
    """Return the level from 0 to 255 of linear light from 0 to 1; table: ENCODE."""
    root = np.sqrt(min(linear, np.float32(1.0)))
    place = np.int32(root * np.float32(ENTRIES - 1) + np.float32(0.5))
    return table[np.uint32(place) & POSITIVE]
