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

"""CDR, the wire format of messages: reading a stamp without decoding the whole message."""
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
