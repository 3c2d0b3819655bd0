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

"""The image that a frame ends in, and how a band's pixels get there."""
from flag_sim.kernels import kernel

import numpy as np


class Canvas:
    """
    Bytes of one size and background, and reversed Z where it is wanted.

    rgb: (height, width, 3) uint8, read-only; byte_array and word_array: the same memory, flat, as
    bytes and as uint32, for the kernels; drawn: (2, bands) int32, first column and end of what
    the last frame drew in each band, so that only that is emptied.
    """

    def __init__(self, width, height, bands, clear_colour, clear_depth):
        """Make an image that is to be written as a whole by the next frame."""
        pixels = width * height
        self.kind = width, height, clear_colour, clear_depth
        # Colours are turned into bytes four at a time.
        self.word_array = np.empty(-(-pixels // 4) * 3, np.uint32)
        self.byte_array = self.word_array.view(np.uint8)
        self.rgb = self.byte_array[:3 * pixels].reshape(height, width, 3)
        self.rgb.flags.writeable = False
        self.drawn = np.tile(np.array([[0], [width]], np.int32), bands)
        self._reversed_z = np.empty(0, np.float32)

    def reversed_z(self, is_wanted):
        """Return (height width,) float32, all clear_depth at first; an empty array if unwanted."""
        if not is_wanted:
            self._reversed_z = self._reversed_z[:0]
        elif not self._reversed_z.size:
            width, height, _, clear_depth = self.kind
            self._reversed_z = np.full(width * height, clear_depth, np.float32)
        return self._reversed_z


@kernel
def write_reversed_z(depths, top, rows, left, right, width, stride, image):
    """Copy columns left .. right - 1 of a band's rows to rows from `top` on of the image."""
    for row in range(rows):
        source, target = np.uint64(row * stride), np.uint64((top + row) * width)
        for i in range(np.uint64(left), np.uint64(right)):
            image[target + i] = depths[source + i]


@kernel
def write_rgb(words, top, rows, left, right, width, stride, out, out_words):
    """
    Turn columns left .. right - 1 of a band's rows into red, green, blue bytes.

    words: colours, red lowest, `stride` a row; out: bytes of the image, `width` pixels a row, of
    which rows from `top` on are written, out_words: the same memory as uint32. Four pixels that
    begin at a multiple of four fill three words: three times faster than byte by byte.
    The bytes are in order where the lowest byte of a word stands first, as on all machines that
    ROS 2 supports.
    """
    for row in range(rows):
        # Pixel p of the image stands at p - offset.
        offset = (top + row) * width - row * stride
        begin, end = (top + row) * width + left, (top + row) * width + right
        first, last = (begin + 3) // 4 * 4, end // 4 * 4
        if first >= last:
            first = last = end
        _write_bytes(words, begin, first, offset, out)
        source, target = np.uint64(first - offset), np.uint64(first // 4 * 3)
        for k in range(np.uint64((last - first) // 4)):
            p, q = source + np.uint64(4) * k, target + np.uint64(3) * k
            a, b = words[p], words[p + np.uint64(1)]
            c, d = words[p + np.uint64(2)], words[p + np.uint64(3)]
            out_words[q] = a | (b << np.uint32(24))
            out_words[q + np.uint64(1)] = (b >> np.uint32(8)) | (c << np.uint32(16))
            out_words[q + np.uint64(2)] = (c >> np.uint32(16)) | (d << np.uint32(8))
        _write_bytes(words, last, end, offset, out)


@kernel
def _write_bytes(words, begin, end, offset, out):
    for p in range(begin, end):
        word = words[p - offset]
        for channel in range(3):
            out[3 * p + channel] = np.uint8(word >> np.uint32(8 * channel) & np.uint32(255))
