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
Files of TFRecord with tf.train.Example in them, written without TensorFlow.

A record is its length, a checksum of that, its bytes, and a checksum of these; an Example is a
message of Protocol Buffers that maps names to lists of bytes.
"""
from collections.abc import Mapping
import struct

from flag_sim.jit.kernels import kernel
import numpy as np

POLYNOMIAL = 0x82F63B78
"""Of CRC-32C (Castagnoli), with its bits reversed."""
MASK = 0xA282EAD8
LENGTH, CHECKSUM = struct.Struct('<Q'), struct.Struct('<I')


def _crc_table():
    table = np.arange(256, dtype=np.uint32)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint32(POLYNOMIAL), table >> 1)
    return table.astype(np.uint32)


TABLE = _crc_table()


@kernel
def _crc32c(data, table):
    crc = np.uint32(0xFFFFFFFF)
    for byte in data:
        crc = table[(crc ^ byte) & np.uint32(255)] ^ (crc >> np.uint32(8))
    return crc ^ np.uint32(0xFFFFFFFF)


def masked_checksum(data: bytes) -> int:
    """Return the CRC-32C of bytes, turned and shifted as TFRecord has it."""
    crc = int(_crc32c(np.frombuffer(data, np.uint8), TABLE))
    return ((crc >> 15 | crc << 17) + MASK) & 0xFFFFFFFF


def _varint(number):
    parts = bytearray()
    while number > 127:
        parts.append(number & 127 | 128)
        number >>= 7
    return bytes([*parts, number])


def _field(number, data):
    """Return a field that holds bytes or a message."""
    return bytes([number << 3 | 2]) + _varint(len(data)) + data


def example(features: Mapping[str, bytes]) -> bytes:
    """Return a tf.train.Example, serialised: of each name a list of one value, bytes."""
    return _field(1, b''.join(
        _field(1, _field(1, name.encode()) + _field(2, _field(1, _field(1, value))))
        for name, value in sorted(features.items())))


def record(data: bytes) -> bytes:
    """Return bytes as a record of TFRecord."""
    length = LENGTH.pack(len(data))
    return b''.join((length, CHECKSUM.pack(masked_checksum(length)), data,
                     CHECKSUM.pack(masked_checksum(data))))
