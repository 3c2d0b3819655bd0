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

"""A serialised sensor_msgs/Image, read without a copy of its pixels."""
import struct
from typing import NamedTuple

from flag_sim.protocol.cdr import serialized_stamp


class ImageBytes(NamedTuple):
    """
    What a sensor_msgs/Image says, and its pixels.

    stamp [ns]; step: bytes of a row; pixels: a view of the message, height times step bytes.
    """

    stamp: int
    height: int
    width: int
    encoding: str
    is_bigendian: bool
    step: int
    pixels: memoryview


def read_image(data: bytes) -> ImageBytes:
    """Return the image that `data` is; raise ValueError for bytes that are no whole image."""
    stamp = serialized_stamp(data)
    order = '<' if data[1] & 1 else '>'
    try:
        _, at = _text(data, 12, order)
        height, width, at = *struct.unpack_from(f'{order}II', data, at), at + 8
        encoding, at = _text(data, at, order, aligned=False)
        is_bigendian, at = data[at], at + 1
        at = _aligned(at)
        step, length = struct.unpack_from(f'{order}II', data, at)
    except (struct.error, IndexError, UnicodeDecodeError):
        raise ValueError(f'its {len(data)} bytes are no Image') from None
    pixels = memoryview(data)[at + 8:at + 8 + length]
    if len(pixels) != length or length != height * step:
        raise ValueError(f'an image of {height} rows of {step} bytes has {length} bytes')
    return ImageBytes(stamp, height, width, encoding, bool(is_bigendian), step, pixels)


def _aligned(at):
    """Return the next place of a number of four bytes: counted from after the encoding."""
    return at + -at % 4


def _text(data, at, order, aligned=True):
    """Return a text that stands at a place, and the place after it."""
    (length,) = struct.unpack_from(f'{order}I', data, at)
    text = data[at + 4:at + 4 + length]
    if not length or len(text) != length:
        raise IndexError
    at += 4 + length
    return bytes(text[:-1]).decode(), _aligned(at) if aligned else at
