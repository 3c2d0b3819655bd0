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

"""Messages into an MCAP file without copies of them on the way."""
import collections
from io import BytesIO
import struct

LARGEST_CHUNK = 2**20
"""A chunk with more than this is closed at once [bytes], as rosbags does it."""
# Records, by the format's specification (https://mcap.dev/spec): how each begins.
MESSAGE = struct.Struct('<BQHIQQ')       # 0x05, length, channel, sequence, two times
CHUNK = struct.Struct('<BQQQQI')         # 0x06, length, two times, bytes inside, CRC
MESSAGE_INDEX = struct.Struct('<BQHI')   # 0x07, length, channel, bytes that follow
CHUNK_INDEX = struct.Struct('<QQQQI')    # two times, start, length, bytes that follow
HEAD = struct.Struct('<BQ').size         # a record's kind and its length, which it does not count
ENTRY, OFFSET = struct.Struct('<QQ'), struct.Struct('<HQ')


def _text(text):
    return struct.pack(f'<I{len(text)}s', len(text), text.encode())


class ChunkWriter:
    """
    In front of the McapWriter of rosbags, whose chunks it writes, equal to the byte.

    rosbags copies a message five times, and a picture of 640 x 480 has nearly a megabyte. Here
    the messages of a chunk are kept as they came until it is closed, and then go to the file.
    Whatever else is asked of it, storage does.
    """

    def __init__(self, storage: object):
        self._storage = storage
        self._begin()

    def __getattr__(self, name: str) -> object:
        """Return what is not ours from the McapWriter."""
        return getattr(self._storage, name)

    def _begin(self):
        self._parts, self._size = [], 0
        self._messages = collections.defaultdict(list)  # (time, place in the chunk) by channel
        self._first, self._last = 2**63 - 1, 0  # times in the chunk [ns]

    def write(self, connection: object, timestamp: int, data: bytes) -> None:
        """Take a serialised message at a time [ns]; raise OSError if the disk is full."""
        storage = self._storage
        if storage.chunk.bio.tell():  # schemas and channels that were added meanwhile
            self._keep(storage.chunk.bio.getvalue())
            storage.chunk.bio = BytesIO()
        storage.message_start_time = min(timestamp, storage.message_start_time)
        storage.message_end_time = max(timestamp, storage.message_end_time)
        storage.channel_stats[connection.id] += 1
        self._first, self._last = min(timestamp, self._first), max(timestamp, self._last)
        self._messages[connection.id].append((timestamp, self._size))
        self._keep(MESSAGE.pack(0x05, MESSAGE.size - HEAD + len(data), connection.id, 0,
                                timestamp, timestamp), data)
        if self._size > LARGEST_CHUNK:
            self._close_chunk()

    def _keep(self, *parts):
        self._parts += parts
        self._size += sum(map(len, parts))

    def flush(self) -> int:
        """Hand all to the system, and return how long the file is then [bytes]."""
        if self._parts or self._storage.chunk.bio.tell():
            self._close_chunk()
        self._storage.bio.flush()
        return self._storage.bio.tell()

    def _close_chunk(self):
        storage, file = self._storage, self._storage.bio
        if not self._parts:  # schemas and channels alone
            storage.close_chunk()
            return
        parts, size = self._parts, self._size
        if storage.compression:
            parts = [storage.compressor(b''.join(parts))]
        length = sum(map(len, parts))
        compression = _text(storage.compression)
        start = file.tell()
        file.write(CHUNK.pack(0x06, CHUNK.size - HEAD + len(compression) + 8 + length,
                              self._first, self._last, size, 0))
        file.write(compression + struct.pack('<Q', length))
        for part in parts:
            file.write(part)
        end, offsets = file.tell(), []
        for channel, messages in self._messages.items():
            offsets.append(OFFSET.pack(channel, file.tell()))
            entries = b''.join(ENTRY.pack(*message) for message in messages)
            file.write(MESSAGE_INDEX.pack(0x07, MESSAGE_INDEX.size - HEAD + len(entries), channel,
                                          len(entries)) + entries)
        index = BytesIO()
        index.write(CHUNK_INDEX.pack(self._first, self._last, start, end - start,
                                     len(offsets) * OFFSET.size) + b''.join(offsets)
                    + struct.pack('<Q', file.tell() - end) + compression
                    + struct.pack('<QQ', length, size))
        storage.chunks.append(index)
        self._begin()
