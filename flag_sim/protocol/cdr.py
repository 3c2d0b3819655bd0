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

"""CDR, the wire format of messages: reading what is wanted without decoding all of a message."""
import itertools
import struct


def serialized_stamp(data: bytes) -> int:
    """
    Return the stamp [ns] of a serialised message that begins with a Time or a Header.

    Four bytes that say the byte order, then the seconds and the nanoseconds (OMG DDSI-RTPS 2.5,
    section 10). Raises ValueError for a message that is too short for them.
    """
    if len(data) < 12:
        raise ValueError(f'its {len(data)} bytes are too few for a stamp')
    seconds, nanoseconds = struct.unpack_from('<iI' if data[1] & 1 else '>iI', data, 4)
    return seconds * 10**9 + nanoseconds


def serialized_header(data: bytes) -> tuple[int, str]:
    """Return (stamp [ns], frame_id) of a serialised Header; raise ValueError for what is none."""
    stamp = serialized_stamp(data)
    order = '<' if data[1] & 1 else '>'
    length = struct.unpack_from(f'{order}I', data, 12)[0] if len(data) >= 16 else 0
    if not 0 < length <= len(data) - 16:
        raise ValueError(f'its {len(data)} bytes are no Header')
    return stamp, data[16:15 + length].decode()


class EventLayout:
    """
    Where the numbers stand in a serialised rcl_interfaces/ParameterEvent.

    data: one in little-endian order, which all is laid out as. Of its changed parameters those
    that hold an integer, a double or doubles may be others in the next message; all else, but for
    what it is padded with, must be the same. Raises ValueError where the layout is not known.
    """

    # How a ParameterValue begins (its type, its bool) and which of its fields is kept, by type.
    INTEGER, DOUBLE, DOUBLES = 2, 3, 8

    def __init__(self, data: bytes):
        self._data, self._at = data, 4
        self._parts = [(0, '4s')]  # (place, format) of what is read or padding
        self._counts = []  # how many numbers each parameter has, or None
        try:
            self._walk()
        except struct.error:
            raise ValueError('it ends too early') from None
        if self._at > len(data) or data[1] != 1:
            raise ValueError('it is laid out in another way')
        # rclpy's serialize_message leaves some bytes behind the last.
        self._parts.append((self._at, f'{len(data) - self._at}x'))
        self._struct = struct.Struct('<' + self._formats())
        found = self._struct.unpack(data)
        self._is_number = [not isinstance(one, bytes) for one in found]
        self._is_fixed = [isinstance(one, bytes) for one in found]
        self._fixed = [*itertools.compress(found, self._is_fixed)]
        del self._data

    def numbers(self, data: bytes) -> list | None:
        """
        Return [seconds, nanoseconds, number or list of numbers or None of each parameter].

        None for the parameters of other types; None for a message of another layout.
        """
        if len(data) != self._struct.size:
            return None
        found = self._struct.unpack(data)
        if [*itertools.compress(found, self._is_fixed)] != self._fixed:
            return None
        numbers = itertools.compress(found, self._is_number)
        stamp = [next(numbers), next(numbers)]
        return stamp + [None if count is None else next(numbers) if count == 0 else
                        [*itertools.islice(numbers, count)] for count in self._counts]

    def _formats(self):
        """Return the format of all, in which what lies between the parts is fixed."""
        formats, at = [], 0
        for place, code in self._parts:
            formats.append(f'{place - at}s' * (place > at) + code)
            at = place + struct.calcsize('<' + code)
        return ''.join(formats)

    def _walk(self):
        self._keep('i')
        self._keep('I')
        self._text()  # the node
        if self._number('I'):
            raise ValueError('it has new parameters')
        for _ in range(self._number('I')):
            self._text()
            self._value()
        if self._number('I'):
            raise ValueError('it has deleted parameters')

    def _value(self):
        kind, _ = self._number('B'), self._number('B')
        (self._keep if kind == self.INTEGER else self._number)('q')
        (self._keep if kind == self.DOUBLE else self._number)('d')
        self._text()
        count = None if kind not in (self.INTEGER, self.DOUBLE) else 0
        for code in 'BBqd':  # bytes, bools, integers, doubles
            length = self._number('I')
            if code == 'd' and kind == self.DOUBLES and length:
                count = length
                self._keep(f'{length}d')
            elif length:
                self._number(f'{length}{code}')
        for _ in range(self._number('I')):
            self._text()
        self._counts.append(count)

    def _keep(self, code):
        self._align(code)
        self._parts.append((self._at, code))
        self._number(code)

    def _number(self, code):
        self._align(code)
        value, = struct.unpack_from('<' + code[-1], self._data, self._at)
        self._at += struct.calcsize('<' + code)
        return value

    def _text(self):
        length = self._number('I')
        self._at += length

    def _align(self, code):
        gap = -(self._at - 4) % struct.calcsize('<' + code[-1])
        if gap:
            self._parts.append((self._at, f'{gap}x'))
            self._at += gap
