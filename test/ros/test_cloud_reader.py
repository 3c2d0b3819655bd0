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

"""Vertices are read from bytes as they are from messages."""
from flag_sim.protocol.cdr import serialized_header
from flag_sim.ros import cloud_reader, messages
from flag_sim.ros.cloud_reader import CloudReader
from hypothesis import given
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
from support.fuzz import CHANGES


def cloud(stamp, rows=3, columns=5):
    """Return a PointCloud2 as physics sends it."""
    return messages.cloud_message(stamp, *np.random.default_rng(stamp).random(
        (2, rows, columns, 3)))


def read_alike(reader, data):
    """Return whether a reader makes of bytes what rclpy does; both may refuse them."""
    try:
        message = deserialize_message(data, PointCloud2)
        stamp, arrays = (messages.checked_stamp(message.header.stamp),
                         messages.read_cloud(message))
    except (RuntimeError, ValueError) as refused:
        with pytest.raises(ValueError) as said:
            reader.read(data)
        return isinstance(refused, RuntimeError) or str(said.value) == str(refused)
    found, ours = reader.read(data)
    return found == stamp and all(
        mine is theirs or (mine.dtype == theirs.dtype and mine.flags.c_contiguous
                           and np.array_equal(mine, theirs))
        for mine, theirs in zip(ours, arrays))


def test_clouds_of_several_senders_are_read_alike():
    """Of one size and another, of another layout, too late a stamp, and with a NaN."""
    other = cloud(4)
    other.fields = [PointField(name=name, offset=4 * i, datatype=PointField.FLOAT32, count=1)
                    for i, name in enumerate('zyx')]
    spoilt = cloud(5)
    spoilt.data[-1] = spoilt.data[-2] = 255
    late = cloud(0)
    late.header.stamp.nanosec = 2**32 - 1
    late.header.stamp.sec = 2**31 - 1
    reader = CloudReader()
    for message in (cloud(1), cloud(2), cloud(3, 2, 2), cloud(6, 2, 2), other, other, cloud(7),
                    spoilt, cloud(8), late, cloud(9)):
        assert read_alike(reader, serialize_message(message))


@pytest.mark.parametrize('padding', [b'', b'\0x'])
def test_points_are_found_without_reading_the_whole_message(monkeypatch, padding):
    """All but the first of a sender, whatever DDS puts behind a message."""
    data = bytearray(serialize_message(cloud(1)) + padding)
    reader = CloudReader()
    reader.read(bytes(data))
    monkeypatch.setattr(cloud_reader, 'deserialize_message', None)
    data[8] = 2
    assert reader.read(bytes(data))[0] == 2


@given(changes=CHANGES)
def test_mutilated_clouds_are_read_as_rclpy_reads_them(changes):
    """Before and after a good one of the same length."""
    good = serialize_message(cloud(1, 2, 2))
    bad = bytearray(good)
    for part, byte in changes:
        bad[4 + int(part * (len(bad) - 4))] = byte
    reader = CloudReader()
    for data in (bytes(bad), good, bytes(bad), good, good[:len(good) // 2]):
        assert read_alike(reader, data)


def test_headers_are_read_from_bytes():
    """What is cut off or lies about its length is refused."""
    data = serialize_message(Header(frame_id='renderer', stamp=messages.to_time(1_500_000_001)))
    assert serialized_header(data) == (1_500_000_001, 'renderer')
    assert serialized_header(serialize_message(Header())) == (0, '')
    for bad in (b'', data[:15], data[:16], data[:-1], data[:12] + b'\xff' * 4 + data[16:],
                data[:12] + bytes(4), data[:16] + b'\xff' * 9):
        with pytest.raises(ValueError):
            serialized_header(bad)
