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

"""Vertices from the bytes of their messages."""
from flag_sim.protocol.cdr import serialized_stamp
from flag_sim.ros import messages
from flag_sim.ros.messages import CLOUD_FIELDS
from flag_sim.ros.serialized import LENGTH, STAMP
import numpy as np
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2, PointField

AS_OURS = [(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate(CLOUD_FIELDS)]


class CloudReader:
    """
    Reads one PointCloud2 after another from its bytes.

    Those of one sender differ in stamps and points alone. Where the points of the last one stood
    is remembered, if they were laid out as physics does it, and taken from there.
    """

    def __init__(self):
        self._shape = None  # rows and columns, where the layout is known
        self._before = self._between = b''  # the bytes before the stamp, and before the points
        self._length = 0  # of the message; DDS may have put some bytes behind it

    def read(self, data: bytes) -> tuple[int, tuple[np.ndarray, np.ndarray | None]]:
        """
        Return (stamp [ns], what messages.read_cloud does).

        Raises ValueError for bytes that are no cloud, or none that can be drawn.
        """
        if (self._shape is not None and len(data) == self._length
                and data.startswith(self._before)
                and data.startswith(self._between, STAMP.stop)):
            rows, columns = self._shape
            points = np.frombuffer(data, '<f4', rows * columns * 6,
                                   STAMP.stop + len(self._between)).reshape(rows, columns, 6)
            stamp = serialized_stamp(data)
            # What is refused is read once more, to say why.
            if stamp <= messages.LATEST and np.isfinite(points).all():
                return stamp, (points[..., :3].astype(np.float64),
                               points[..., 3:].astype(np.float64))
        try:
            message = deserialize_message(data, PointCloud2)
        except RuntimeError:  # of the middleware; it names a line in its source
            raise ValueError(f'its {len(data)} bytes are no PointCloud2') from None
        stamp, cloud = messages.checked_stamp(message.header.stamp), messages.read_cloud(message)
        self._learn(data, message)
        return stamp, cloud

    def _learn(self, data, message):
        """Remember where the points of a message stand that has just been read."""
        self._shape = None
        points = message.data.tobytes()
        first = data.find(LENGTH.pack(len(points)) + points, STAMP.stop) + LENGTH.size
        fields = [(one.name, one.offset, one.datatype, one.count) for one in message.fields]
        if (fields == AS_OURS and not message.is_bigendian
                and (message.point_step, message.row_step) == (24, 24 * message.width)
                and len(points) == message.height * message.row_step
                and first > STAMP.stop):
            self._shape = message.height, message.width
            self._before, self._between = data[:STAMP.start], data[STAMP.stop:first]
            self._length = len(data)
