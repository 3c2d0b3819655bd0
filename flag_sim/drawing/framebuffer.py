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
from typing import NamedTuple

from flag_sim.drawing.channels import needs_faces, renewed, RESOLVED
from flag_sim.drawing.visibility import Visibility
from flag_sim.jit.kernels import late_kernel

import numpy as np


@dataclasses.dataclass(frozen=True, eq=False)
class Frame:
    """
    What a camera saw.

    colour: (height, width, 3) uint8, C-contiguous, red, green and blue; depth: (height, width)
    float32, along the optical axis [m], +inf where nothing is; normals: (height, width, 3)
    float32, of unit length in the optical frame, out of the side that is seen, 0 where nothing is;
    labels: (height, width) uint8, of the objects, 0 where nothing is; texture_coordinates:
    (height, width, 2) float32, nan where there are none; flow: (height, width, 2) float32, where
    this point of the surface was in the frame before, minus where it is [pixel], nan where nothing
    is or that is not known; visibility: which triangle each pixel sees, from which any attribute
    can be interpolated. All but colour are of the pixels' centres, and None unless their channels
    were asked for. The arrays are read-only, and the picture that drew them draws its next frame
    into the same memory: `copy()` what must stay.
    """

    colour: np.ndarray
    depth: np.ndarray | None = None
    normals: np.ndarray | None = None
    labels: np.ndarray | None = None
    texture_coordinates: np.ndarray | None = None
    flow: np.ndarray | None = None
    visibility: Visibility | None = None

    def copy(self) -> 'Frame':
        """Return the same in memory of its own."""
        return Frame(**{field.name: _copy(getattr(self, field.name))
                        for field in dataclasses.fields(self)})


def _copy(one):
    """Return an array, a Visibility or None in memory of its own."""
    return Visibility(*map(np.copy, one)) if isinstance(one, Visibility) else (
        None if one is None else one.copy())


class Images(NamedTuple):
    """
    The memory of a frame, for the kernels.

    rgb, rgb_words: flat, the same memory as bytes and as uint32; depth: (height, width) float32;
    faces: (height, width) uint32, see visibility; these two are of size 0 if they are not wanted;
    dirty: (2, bands) int32, the first column and the end of what the last frame drew in each band,
    so that only that is cleared.
    """

    rgb: np.ndarray
    rgb_words: np.ndarray
    depth: np.ndarray
    faces: np.ndarray
    dirty: np.ndarray


class Framebuffer:
    """Images of one size and background, which are kept from frame to frame."""

    def __init__(self, width, height, bands, clear_colour):
        """Make an image that is to be written as a whole by the next frame."""
        self.key = width, height, clear_colour
        self._shape = height, width
        # Colours are turned into bytes four at a time.
        self._words = np.empty(-(-width * height // 4) * 3, np.uint32)
        self._bytes = self._words.view(np.uint8)
        self._rgb = self._bytes[:3 * height * width].reshape(height, width, 3)
        self._rgb.flags.writeable = False
        self._depth, self._faces = np.empty((0, 0), np.float32), np.empty((0, 0), np.uint32)
        self._visibility = _nothing_visible(0, 0)
        self._resolved = renewed(None, (), height, width)
        self._dirty = np.tile(np.array([[0], [width]], np.int32), bands)
        self._seen = np.zeros((2, height), np.int32)
        self._channels = ()

    def images(self, channels) -> Images:
        """Return the Images for a frame; those that the last one did not draw are made anew."""
        self._channels = channels
        has_faces = needs_faces(channels)
        if not (has_faces or 'depth' in channels):
            self._depth = self._depth[:0]
        elif not self._depth.size:
            self._depth = np.full(self._shape, np.inf, np.float32)
        if has_faces != bool(self._faces.size):
            self._faces = np.zeros(self._shape if has_faces else (0, 0), np.uint32)
        has_visibility = 'visibility' in channels
        if has_visibility != bool(self._visibility[0].size):
            self._visibility = _nothing_visible(*(self._shape if has_visibility else (0, 0)))
        self._resolved = renewed(self._resolved, channels, *self._shape)
        return Images(self._bytes, self._words, self._depth, self._faces, self._dirty)

    def to_resolve(self) -> tuple:
        """Return dirty, seen, pixels, images and visibility for channel_pass.resolve."""
        return (self._dirty, self._seen, (self._faces, self._depth), self._resolved,
                self._visibility)

    def frame(self, scene) -> Frame:
        """Return the Frame of what was drawn of SceneBuffers."""
        images = {name: _read_only(image) for name, image in
                  (('depth', self._depth), *zip(RESOLVED, self._resolved))
                  if name in self._channels}
        if 'labels' in images:
            images['labels'] = images['labels'][..., 0]
        if 'visibility' in self._channels:
            images['visibility'] = Visibility(
                *map(_read_only, self._visibility), scene.triangles,
                scene.projected.view_space[:, 2].copy())
        return Frame(self._rgb, **images)


def _nothing_visible(height, width):
    """Return triangles, is_back and weights of pixels that see nothing."""
    return (np.full((height, width), -1, np.int32), np.zeros((height, width), np.bool_),
            np.zeros((height, width, 2), np.float32))


def _read_only(array):
    view = array.view()
    view.flags.writeable = False
    return view


@late_kernel
def write_rgb(colour, region, width, rgb, rgb_words):
    """
    Turn the colours of a Region into red, green, blue bytes of an image.

    colour: a band's colour buffer; rgb: bytes of the image, `width` pixels a row; rgb_words: the
    same memory as uint32. Four pixels that begin at a multiple of four fill three words: three
    times faster than byte by byte. The bytes are in order where the lowest byte of a word stands
    first, as on all machines that ROS 2 supports.
    """
    for row in range(region.first, region.first + region.rows):
        # Pixel p of the image stands at p - offset.
        offset = (region.top + row) * width - row * region.stride
        begin = (region.top + row) * width + region.left
        end = (region.top + row) * width + region.right
        first, last = (begin + 3) // 4 * 4, end // 4 * 4
        if first >= last:
            first = last = end
        _write_bytes(colour, begin, first, offset, rgb)
        source, target = np.uint64(first - offset), np.uint64(first // 4 * 3)
        for k in range(np.uint64((last - first) // 4)):
            p, q = source + np.uint64(4) * k, target + np.uint64(3) * k
            a, b = colour[p], colour[p + np.uint64(1)]
            c, d = colour[p + np.uint64(2)], colour[p + np.uint64(3)]
            rgb_words[q] = a | (b << np.uint32(24))
            rgb_words[q + np.uint64(1)] = (b >> np.uint32(8)) | (c << np.uint32(16))
            rgb_words[q + np.uint64(2)] = (c >> np.uint32(16)) | (d << np.uint32(8))
        _write_bytes(colour, last, end, offset, rgb)


@late_kernel
def _write_bytes(colour, begin, end, offset, rgb):
    for p in range(begin, end):
        packed = colour[p - offset]
        for channel in range(3):
            rgb[3 * p + channel] = np.uint8(packed >> np.uint32(8 * channel) & np.uint32(255))
