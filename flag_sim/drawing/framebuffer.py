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

"""The frame that is the result, and how a band's pixels get there."""
import dataclasses
from typing import Mapping, NamedTuple

from flag_sim.drawing.lanes import CHANNELS
from flag_sim.kernels import kernel

import numpy as np


@dataclasses.dataclass(frozen=True, eq=False)
class Frame:
    """
    What a camera saw.

    colour: (height, width, 3) uint8, C-contiguous; depth: (height, width) float32, along the
    optical axis at the pixels' centres [m], +inf where nothing is, or None if it was not asked
    for; channels: by the names of the attributes that were asked for, (height, width, channels)
    float32. All are read-only, and the picture that drew them draws its next frame into the same
    memory: `copy()` what must stay.
    """

    colour: np.ndarray
    depth: np.ndarray = None
    channels: Mapping[str, np.ndarray] = dataclasses.field(default_factory=dict)

    def copy(self) -> 'Frame':
        """Return the same in memory of its own."""
        return Frame(self.colour.copy(), None if self.depth is None else self.depth.copy(),
                     {name: image.copy() for name, image in self.channels.items()})


class Images(NamedTuple):
    """
    The memory of a frame, for the kernels.

    rgb, rgb_words: flat, as bytes and as uint32; depth: (height, width) float32, and
    channels: (groups - 1, height, width, CHANNELS) float32, both of size 0 if they are not
    wanted; drawn: (2, bands) int32, first column and end of what the last frame drew in each
    band, so that only that is emptied.
    """

    rgb: np.ndarray
    rgb_words: np.ndarray
    depth: np.ndarray
    channels: np.ndarray
    drawn: np.ndarray


class Framebuffer:
    """Images of one size and background, which are kept from frame to frame."""

    def __init__(self, width, height, bands, clear_colour):
        """Make an image that is to be written as a whole by the next frame."""
        self.shape = height, width
        self.clear_colour = clear_colour
        pixels = width * height
        # Colours are turned into bytes four at a time.
        self._words = np.empty(-(-pixels // 4) * 3, np.uint32)
        self._bytes = self._words.view(np.uint8)
        self._depth, self._channels = np.empty((0, 0), np.float32), _no_channels(0, (0, 0))
        self._nothing = np.empty(0, np.float32)
        self._drawn = np.tile(np.array([[0], [width]], np.int32), bands)

    def images(self, with_depth, nothing):
        """
        Return the Images for a frame.

        nothing: (groups CHANNELS,) float32, what pixels show where nothing is, of all groups.
        What the last frame was not drawn into is made anew.
        """
        if not with_depth:
            self._depth = np.empty((0, 0), np.float32)
        elif not self._depth.size:
            self._depth = np.full(self.shape, np.inf, np.float32)
        if not np.array_equal(nothing, self._nothing, equal_nan=True):
            self._nothing = nothing.copy()
            self._channels = _no_channels(nothing.size // CHANNELS - 1, self.shape)
            self._channels[:] = nothing.reshape(-1, 1, 1, CHANNELS)[1:]
        return Images(self._bytes, self._words, self._depth, self._channels, self._drawn)

    def frame(self, names):
        """Return the Frame; names: {name: (first group, channels)} of the attributes."""
        height, width = self.shape
        images = {name: _joined(self._channels[first - 1:], channels)
                  for name, (first, channels) in names.items()}
        colour = self._bytes[:3 * height * width].reshape(height, width, 3)
        depth = self._depth.view() if self._depth.size else None
        for image in (colour, depth, *images.values()):
            if image is not None:
                image.flags.writeable = False
        return Frame(colour, depth, images)


def _no_channels(groups, shape):
    return np.empty((groups, *shape, CHANNELS), np.float32)


def _joined(groups, channels):
    """Return the first channels of groups of three as one image: (height, width, channels)."""
    three = CHANNELS - 1
    if channels <= three:
        return groups[0][..., :channels]
    return np.concatenate([group[..., :three] for group in groups[:-(-channels // three)]],
                          axis=-1)[..., :channels]


@kernel
def write_depth(depths, area, is_perspective, image):
    """Write an Area's depths into an image (height, width) of metres."""
    top, begin, rows, left, right, stride = area
    for row in range(begin, begin + rows):
        source, target = np.uint64(row * stride), np.uint64(top + row)
        if is_perspective:
            for i in range(np.uint64(left), np.uint64(right)):
                image[target, i] = np.float32(1.0) / depths[source + i]
        else:
            for i in range(np.uint64(left), np.uint64(right)):
                image[target, i] = -depths[source + i]


@kernel
def write_rgb(words, area, width, rgb, rgb_words):
    """
    Turn an Area's colours into red, green, blue bytes of an image.

    words: colours, red lowest; rgb: bytes of the image, `width` pixels a row, rgb_words: the same
    memory as uint32. Four pixels that begin at a multiple of four fill three words: three times
    faster than byte by byte. The bytes are in order where the lowest byte of a word stands
    first, as on all machines that ROS 2 supports.
    """
    top, begin_row, rows, left, right, stride = area
    for row in range(begin_row, begin_row + rows):
        # Pixel p of the image stands at p - offset.
        offset = (top + row) * width - row * stride
        begin, end = (top + row) * width + left, (top + row) * width + right
        first, last = (begin + 3) // 4 * 4, end // 4 * 4
        if first >= last:
            first = last = end
        _write_bytes(words, begin, first, offset, rgb)
        source, target = np.uint64(first - offset), np.uint64(first // 4 * 3)
        for k in range(np.uint64((last - first) // 4)):
            p, q = source + np.uint64(4) * k, target + np.uint64(3) * k
            a, b = words[p], words[p + np.uint64(1)]
            c, d = words[p + np.uint64(2)], words[p + np.uint64(3)]
            rgb_words[q] = a | (b << np.uint32(24))
            rgb_words[q + np.uint64(1)] = (b >> np.uint32(8)) | (c << np.uint32(16))
            rgb_words[q + np.uint64(2)] = (c >> np.uint32(16)) | (d << np.uint32(8))
        _write_bytes(words, last, end, offset, rgb)


@kernel
def _write_bytes(words, begin, end, offset, out):
    for p in range(begin, end):
        word = words[p - offset]
        for channel in range(3):
            out[3 * p + channel] = np.uint8(word >> np.uint32(8 * channel) & np.uint32(255))
