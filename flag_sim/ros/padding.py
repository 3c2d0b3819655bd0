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

"""Where a serialised message is padded: bytes that mean nothing, in CDR (OMG DDSI-RTPS 2.5)."""
from collections.abc import Iterator

from rosidl_parser.definition import (
    AbstractGenericString, AbstractSequence, Array, BasicType, NamespacedType)

FIRST = 4
"""Bytes before a message's first: they say how it is laid out. Places are counted from here."""
LENGTH = 4  # bytes of the length of a string or sequence
SIZES = {
    'boolean': 1, 'octet': 1, 'char': 1, 'int8': 1, 'uint8': 1, 'int16': 2, 'uint16': 2,
    'int32': 4, 'uint32': 4, 'float': 4, 'int64': 8, 'uint64': 8, 'double': 8,
}


def padding(message: object, length: int) -> Iterator[slice]:
    """
    Yield where a message of `length` serialised bytes is padded.

    Every number begins at a multiple of its size, and rclpy leaves some bytes behind the last.
    """
    end = FIRST
    for start, size in _items(message):
        if start > end:
            yield slice(end, start)
        end = start + size
    if length > end:
        yield slice(end, length)


def _items(message):
    """Yield (where it begins, bytes) of each string and run of numbers in a message."""
    at = FIRST
    for size, count in _fields(message):
        if count:
            at += -(at - FIRST) % size
            yield at, size * count
            at += size * count


def _fields(message):
    """Yield (bytes of one, how many) of all strings and numbers that a message consists of."""
    for name, kind in zip(message.__slots__, type(message).SLOT_TYPES):
        yield from _parts(getattr(message, name), kind)


def _parts(value, kind):
    if isinstance(kind, BasicType):
        yield SIZES[kind.typename], 1
    elif isinstance(kind, NamespacedType):
        yield from _fields(value)
    elif isinstance(kind, AbstractGenericString):
        yield LENGTH, 1
        yield 1, len(value.encode()) + 1
    else:
        if isinstance(kind, AbstractSequence):
            yield LENGTH, 1
        elif not isinstance(kind, Array):
            raise TypeError(f'{kind} is not known')
        if isinstance(kind.value_type, BasicType):
            yield SIZES[kind.value_type.typename], len(value)
        else:
            for one in value:
                yield from _parts(one, kind.value_type)
