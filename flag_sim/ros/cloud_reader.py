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
from flag_sim.ros import messages
from flag_sim.ros.messages import CLOUD_FIELDS
from flag_sim.ros.serialized import LENGTH, STAMP, TIME
import numpy as np
from rclpy.serialization import deserialize_message, serialize_message
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
        self._around = b'', b'', b''  # the bytes before the stamp, before the points, behind them

    def read(self, data: bytes) -> tuple[int, tuple[np.ndarray, np.ndarray | None]]:
        """
        Return (stamp [ns], what messages.read_cloud does).

        Raises ValueError for bytes that are no cloud, or none that can be drawn.
        """
        if self._shape is not None:
            before, between, after = self._around
            first, end = STAMP.stop + len(between), len(data) - len(after)
            if (end - first == 24 * self._shape[0] * self._shape[1]
                    and data.startswith(before) and data.startswith(between, STAMP.stop)
                    and data.endswith(after)):
                points = np.frombuffer(data, '<f4', (end - first) // 4, first).reshape(
                    *self._shape, 6)
                seconds, nanoseconds = TIME.unpack(data[STAMP])
                stamp = seconds * 10**9 + nanoseconds
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
        first = len(data) - 1 - len(points)  # they are followed by is_dense alone
        fields = [(one.name, one.offset, one.datatype, one.count) for one in message.fields]
        if (fields == AS_OURS and not message.is_bigendian
                and (message.point_step, message.row_step) == (24, 24 * message.width)
                and len(points) == message.height * message.row_step
                and data.startswith(LENGTH.pack(len(points)) + points, first - LENGTH.size)
                and data[:STAMP.start] == serialize_message(message)[:STAMP.start]):
            self._shape = message.height, message.width
            self._around = data[:STAMP.start], data[STAMP.stop:first], data[-1:]
