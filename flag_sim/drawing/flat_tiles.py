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
Flat tiles: where a texture has one colour all around, as most pictures on flags have.

What is between texels of one colour is that colour, in one mipmap and in the next one: there
nothing has to be looked up but the colour of a tile. It is the same to the bit.
"""
import numpy as np

# Texels along a side of a tile, as a shift; where fewer tiles are flat, none is asked for.
SHIFT, WORTH_ASKING = 2, 0.25
SIDE = 2 ** SHIFT
# What a tile holds that is not flat; flat ones hold their colour as pack_rgb packs it.
NOT_FLAT = np.uint32(0xffffffff)


def flat_tiles(mipmaps: list, levels_of_roots: np.ndarray) -> np.ndarray:
    """
    Return the tiles of all mipmaps one after another, flat; of size 0 where it is no use to ask.

    mipmaps: (height + 2, width + 2, 2) uint32, texels of Texture with one more on each side;
    levels_of_roots: the level from 0 to 255 of each root of linear light, -1 where it is none. A
    mipmap has ceil((height + 2) / SIDE) rows of ceil((width + 2) / SIDE) tiles. A tile is of all
    places whose upper left texel, of the four about them, is among its SIDE x SIDE texels.
    """
    tiles, texels = [], [_whole(mipmap) for mipmap in mipmaps]
    for number, mipmap in enumerate(texels):
        following = texels[min(number + 1, len(texels) - 1)]
        least, most = _extremes(mipmap, mipmap.shape)
        next_least, next_most = _extremes(following, mipmap.shape)
        levels = [levels_of_roots[(least >> np.uint64(16 * k)).astype(np.int64) & 0xffff]
                  for k in range(3)]
        is_flat = ((least == most) & (next_least == least) & (next_most == least)
                   & (np.minimum.reduce(levels) >= 0))
        packed = (levels[0] | levels[1] << 8 | levels[2] << 16).astype(np.uint32)
        if number == 0 and np.mean(is_flat) < WORTH_ASKING:
            return np.empty(0, np.uint32)
        tiles.append(np.where(is_flat, packed, NOT_FLAT).reshape(-1))
    return np.concatenate(tiles)


def starts_of_tiles(levels: np.ndarray) -> np.ndarray:
    """Return where the tiles of each of a texture's levels begin, see Texture: (levels,) int32."""
    counts = np.prod((levels[:, 1:] + (2 + SIDE - 1)) // SIDE, axis=1)
    return np.cumsum([0, *counts[:-1]]).astype(np.int32)


def _whole(texels):
    """Return red, green and blue of texels in one number: equal ones are of one colour."""
    words = texels.astype(np.uint64)
    return words[..., 0] | (words[..., 1] & np.uint64(0xffff)) << np.uint64(32)


def _extremes(mipmap, shape):
    """
    Return the least and the greatest texel that a place in each tile is between.

    shape: of the mipmap that the tiles are of, with a texel more on each side: this one or the
    one before.
    """
    least = most = mipmap
    for axis in range(2):
        count, before = mipmap.shape[axis] - 2, shape[axis] - 2
        tile = np.arange(-(-shape[axis] // SIDE))
        # A place x from 0 to 1 has x count + 1/2 texels to its left, one of them beyond the edge.
        first = (SIDE * tile - 0.5) * (count / before) + 0.5
        end = (SIDE * (tile + 1) - 0.5) * (count / before) + 0.5
        margin = 1e-3  # more than all rounding
        first = np.clip(np.floor(first - margin).astype(int), 0, count + 1)
        last = np.clip(np.floor(end + margin).astype(int) + 1, 0, count + 1)
        places = [np.minimum(first + k, last) for k in range(int((last - first).max()) + 1)]
        some_least = [np.take(least, place, axis) for place in places]
        some_most = some_least if most is least else [np.take(most, place, axis)
                                                      for place in places]
        least, most = np.minimum.reduce(some_least), np.maximum.reduce(some_most)
    return least, most
