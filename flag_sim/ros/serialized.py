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
Messages as the bytes in which they travel, made from what rclpy has serialised once.

A node sends hundreds of messages a second that differ in their stamps and arrays alone. To make
each of them field by field, and let rclpy read it field by field, takes longer than to send it,
and an image is copied once more on that way.
"""
import functools
import struct

from flag_sim.ros import messages
from flag_sim.ros.padding import padding
import numpy as np
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image, PointCloud2
from std_msgs.msg import Header

STAMP = slice(4, 12)
"""Where the stamp stands in a message that begins with a Time or a Header, after the encoding."""
# rclpy serialises in the byte order of the machine.
TIME, LENGTH = struct.Struct('=iI'), struct.Struct('=I')


def without_padding(message: object) -> bytes:
    """
    Return a message, serialised; bytes that mean nothing are 0.

    rclpy leaves in what it pads with whatever was in the memory before, and a bag would not be the
    same twice.
    """
    data = bytearray(serialize_message(message))
    for gap in padding(message, len(data)):
        data[gap] = bytes(gap.stop - gap.start)
    return bytes(data)


class Stamped:
    """A message of which only the stamp changes; it begins with a Time or a Header."""

    def __init__(self, message: object):
        data = without_padding(message)
        self._before, self._after = data[:STAMP.start], data[STAMP.stop:]

    def at(self, stamp: int) -> bytes:
        """Return it with `stamp` [ns]."""
        return self._before + TIME.pack(*divmod(stamp, 10**9)) + self._after


class WithData:
    """
    A message of which only the stamp and the bytes of its field `data` change.

    message: with a Header and empty data; after: how many bytes follow them when serialised.
    """

    def __init__(self, message: Image | PointCloud2, after: int):
        data = without_padding(message)
        end = len(data) - after
        self._before = data[:STAMP.start]
        self._between, self._after = data[STAMP.stop:end - LENGTH.size], data[end:]

    def at(self, stamp: int, values: np.ndarray) -> bytes:
        """Return it with `stamp` [ns] and an array as its data."""
        values = np.ascontiguousarray(values)
        return b''.join((self._before, TIME.pack(*divmod(stamp, 10**9)), self._between,
                         LENGTH.pack(values.nbytes), values.data, self._after))


@functools.lru_cache(maxsize=8)
def header(frame_id: str) -> Stamped:
    """Return a Header with this frame_id."""
    return Stamped(Header(frame_id=frame_id))


@functools.lru_cache(maxsize=8)
def camera_info(camera, frame_id: str = messages.OPTICAL) -> Stamped:
    """Return the CameraInfo of a Camera."""
    return Stamped(messages.camera_info_message(0, camera, frame_id))


def image(pixels: np.ndarray, frame_id: str = messages.OPTICAL) -> WithData:
    """Return an Image for pixels of a shape and type, whose data they are."""
    return _image(pixels.shape, pixels.dtype, frame_id)


@functools.lru_cache(maxsize=16)
def _image(shape, kind, frame_id):
    message = messages.image_message(0, np.empty((0, *shape[1:]), kind), frame_id)
    message.height = shape[0]
    return WithData(message, 0)


@functools.lru_cache(maxsize=8)
def cloud(rows: int, columns: int) -> WithData:
    """Return the flag's PointCloud2, whose data are (rows, columns, 6) float32."""
    nothing = np.empty((0, columns, 3))
    message = messages.cloud_message(0, nothing, nothing)
    message.height = rows
    return WithData(message, 1)
