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

"""The buffers of an image, and the passes over whole rectangles of them."""
from flag_sim.drawing.bands import next_row
from flag_sim.drawing.tiles import marks_for
from flag_sim.kernels import kernel

import numpy as np


class Canvas:
    """
    Colours and nearness of one size and background.

    words: packed colours uint32, red lowest, and nearness float32: flat for the kernels; rgb:
    (height, width, 3) uint8, read-only; nearness_image: (height, width), a view.
    """

    def __init__(self, width, height, word, farthest):
        """Make buffers; they are filled by the first clear()."""
        pixels = width * height
        # Colours are turned into bytes four at a time.
        padded = -(-pixels // 4) * 4
        self.kind = width, height, word, farthest
        self.words = np.zeros(padded, np.uint32)
        self.nearness = np.empty(padded, np.float32)
        self.nearness_image = self.nearness[:pixels].reshape(height, width)
        self._bytes = np.empty(padded // 4 * 3, np.uint32)
        self.rgb = self._bytes.view(np.uint8)[:3 * pixels].reshape(height, width, 3)
        self.rgb.flags.writeable = False

    def clear(self, rectangles, band, bands):
        """Empty rectangles (top, bottom, left, right), those rows of them that are in bands."""
        width, _, word, farthest = self.kind
        for rectangle in rectangles:
            _clear(self.words, self.nearness, word, np.float32(farthest), width, *rectangle,
                   band, bands)

    def to_bytes(self, rectangles, band, bands):
        """Bring rectangles of rgb up to date, those rows of them that are in the bands."""
        for rectangle in rectangles:
            _unpack(self.words, self._bytes, self.kind[0], *rectangle, band, bands)


class SampleBuffers:
    """What the samples of one pixel position after another are drawn into, and their sums."""

    def __init__(self, width, height):
        """Make buffers; only marked tiles of them are ever used."""
        self.size = width, height
        self.words = np.empty(width * height, np.uint32)
        self.nearness = np.empty(width * height, np.float32)
        self.sums = np.empty((2, width * height), np.uint32)
        self.marks = marks_for(width, height)


@kernel
def _clear(words, nearness, word, farthest, width, top, bottom, left, right, band, bands):
    row = next_row(top, band, bands)
    while row < bottom:
        words[row * width + left:row * width + right] = word
        nearness[row * width + left:row * width + right] = farthest
        row = next_row(row + 1, band, bands)


@kernel
def _unpack(words, out, width, top, bottom, left, right, band, bands):
    """
    Turn a rectangle's words of colour into red, green, blue bytes.

    words: (4 n,), out: (3 n,) uint32: four pixels fill three words. Rows top .. bottom - 1 and
    columns left .. right - 1 of an image of that width are written, those of some bands, and up
    to three pixels more at both ends of a row, so that whole groups of four are. The
    bytes are in order where the lowest byte of a word stands first, as on all machines that
    ROS 2 supports.
    """
    row = next_row(top, band, bands)
    while row < bottom:
        begin = np.uint64((row * width + left) // 4)
        end = np.uint64((row * width + right + 3) // 4)
        for k in range(begin, end):
            p, q = np.uint64(4) * k, np.uint64(3) * k
            a, b = words[p], words[p + np.uint64(1)]
            c, d = words[p + np.uint64(2)], words[p + np.uint64(3)]
            out[q] = a | (b << np.uint32(24))
            out[q + np.uint64(1)] = (b >> np.uint32(8)) | (c << np.uint32(16))
            out[q + np.uint64(2)] = (c >> np.uint32(16)) | (d << np.uint32(8))
        row = next_row(row + 1, band, bands)
