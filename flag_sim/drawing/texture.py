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
from flag_sim.jit.kernels import late_inner_kernel
from flag_sim.parameters import checks

import numpy as np

# Along a side: what is larger is to be scaled down first. A flag of 61 x 41 nodes has 45 by then
# between two nodes, and four floats of as many texels take 90 MB with their mipmaps.
LARGEST = 2048
# Floats of a texel: red, green, blue and one that makes it a vector.
TEXEL = 4


def _decoded(encoded):
    """Return linear light from 0 to 1 of sRGB values from 0 to 1."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _encoded(linear):
    """Return sRGB values from 0 to 1 of linear light from 0 to 1."""
    return np.where(linear <= 0.0031308, 12.92 * linear,
                    1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)


# Of ENCODE; from one to the next it is less than 0.09 of a level.
ENTRIES = 4096


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

    __slots__ = ('size', 'texels', 'levels', '__weakref__')

    def __init__(self, image: np.ndarray):
        """Make the mipmaps down to a single texel."""
        image = np.asarray(image)
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
        padded = [np.pad(mipmap, ((1, 1), (1, 1), (0, TEXEL - 3)), mode='edge')
                  for mipmap in mipmaps]
        starts = np.cumsum([0] + [one.shape[0] * one.shape[1] for one in padded])
        self.levels = np.array([(start, one.shape[1] - 2, one.shape[0] - 2)
                                for start, one in zip(starts, padded)])
        self.texels = np.concatenate([one.reshape(-1) for one in padded])
        self.texels.flags.writeable = self.levels.flags.writeable = False


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
def trilinear(texels, levels, mipmaps, place, linear, i):
    """
    Write red, green and blue in linear light of a texture.

    mipmaps: the first of its among `levels`, and how many it has; place: x and y [texel of the
    largest mipmap], where anything is allowed, and the mipmap, between two of them; linear: flat,
    written from i on.
    """
    first, count = mipmaps
    x, y, lod = place
    width, height = np.float32(levels[first, 1]), np.float32(levels[first, 2])
    # Of what is no number, the comparisons make 0.
    x = min(x, width) if x > np.float32(0.0) else np.float32(0.0)
    y = min(y, height) if y > np.float32(0.0) else np.float32(0.0)
    if not lod > np.float32(0.0) or count == 1:
        share = np.float32(1.0)
        p, stride, shares = _beside(levels, first, x, y, share)
        red, green, blue, more = _mixed(texels, p, stride, shares)
        _store(linear, i, red, green, blue, more)
        return
    lod = min(lod, np.float32(count - 1))
    level = min(np.int64(lod), count - 2)
    share = lod - np.float32(level)
    level += first
    x, y = x / width, y / height
    p, stride, shares = _beside(levels, level, x * np.float32(levels[level, 1]),
                                y * np.float32(levels[level, 2]), np.float32(1.0) - share)
    level += 1
    q, next_stride, next_shares = _beside(levels, level, x * np.float32(levels[level, 1]),
                                          y * np.float32(levels[level, 2]), share)
    red, green, blue, more = _mixed(texels, p, stride, shares)
    next_red, next_green, next_blue, next_more = _mixed(texels, q, next_stride, next_shares)
    _store(linear, i, red + next_red, green + next_green, blue + next_blue, more + next_more)


@late_inner_kernel
def _beside(levels, level, x, y, share):
    """
    Return where in `texels` the texel above and left of a place in a mipmap is.

    Also how far it is to the row below, and the shares of this texel, the one to its right, and
    those below the two; their sum is `share`.
    """
    # Texels' centres are at halves, and the first texel is beside the edge.
    x, y = x + np.float32(0.5), y + np.float32(0.5)
    column, row = np.int64(x), np.int64(y)
    right, down = x - np.float32(column), y - np.float32(row)
    stride = TEXEL * (levels[level, 1] + 2)
    p = TEXEL * (levels[level, 0] + column) + row * stride
    lower = share * down
    upper = share - lower
    return np.uint64(p), np.uint64(stride), (
        upper - upper * right, upper * right, lower - lower * right, lower * right)


@late_inner_kernel
def _mixed(texels, p, stride, shares):
    """
    Return the channels of the texel at p, the one to its right, and those below, in these shares.

    All four, the one without a meaning too: so they are one vector.
    """
    q = p + stride
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    return (_channel(texels, p, q, shares), _channel(texels, p + one, q + one, shares),
            _channel(texels, p + two, q + two, shares),
            _channel(texels, p + three, q + three, shares))


@late_inner_kernel
def _channel(texels, p, q, shares):
    return (shares[0] * texels[p] + shares[1] * texels[p + np.uint64(TEXEL)]
            + shares[2] * texels[q] + shares[3] * texels[q + np.uint64(TEXEL)])


@late_inner_kernel
def _store(linear, i, red, green, blue, more):
    linear[i], linear[i + np.uint64(1)] = red, green
    linear[i + np.uint64(2)], linear[i + np.uint64(3)] = blue, more


@late_inner_kernel
def log2(value):
    """Return the logarithm of a float32 above 1, to 0.0002: by its exponent and a polynomial."""
    bits = np.float32(value).view(np.int32)
    exponent = np.float32((bits >> 23) - 127)
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
    return table[np.uint64(root * np.float32(ENTRIES - 1) + np.float32(0.5))]
