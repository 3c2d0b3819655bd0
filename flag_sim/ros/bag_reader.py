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
Reading bags: finished ones, and what is whole of those whose recorder was killed.

The classes derived from are rosbags'; what they lack here is reading without the index that is
written last, and limits to what a damaged file can ask for.
"""
from collections.abc import Collection, Iterator
import contextlib
from pathlib import Path
import sqlite3
import struct

from flag_sim.parameters.plain_file import opened
from rosbags.rosbag2 import Reader, ReaderError, storage_mcap
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import ChunkInfo, McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
import yaml

LARGEST = 1 << 29
"""Bytes of a chunk or of a message, whatever is said of them in a file."""
LARGEST_METADATA = 1 << 24
"""Bytes of a metadata.yaml."""
SCHEMA, CHANNEL, CHUNK = 3, 4, 6  # kinds of records in MCAP
LAST_KIND = 0x0E                  # of those that may come before the data's end
JOURNAL_MAGIC = bytes.fromhex('d9d505f920a163d7')
"""First bytes of a journal of SQLite; the last ones too where it names a super-journal."""


def _of_zstd(data, size=LARGEST):
    """Return what zstd has compressed, at most a byte more than `size`."""
    return storage_mcap.zstd.ZstdDecompressor().decompress(data, max_length=_bounded(size) + 1)


def _of_lz4(data, size):
    """Return what LZ4 has compressed, at most a byte more than `size`."""
    from lz4.frame import LZ4FrameDecompressor
    return LZ4FrameDecompressor().decompress(data, max_length=_bounded(size) + 1)


def _bounded(size):
    if size > LARGEST:
        raise ReaderError(f'A chunk of {size} bytes is too large.')
    return size


# The library's own take as much memory as the compressed data say.
storage_mcap.DECOMPRESSORS.update(zstd=_of_zstd, lz4=_of_lz4)


class _Mcap(McapReader):
    """A file of MCAP; one without its end is read as far as its records are whole."""

    is_cut = False

    def open(self):  # noqa: A003
        opened(self.path).close()
        super().open()

    def _open(self):
        try:
            super()._open()
        except Exception:  # whatever it finds at the end of the file
            if not self.data_start:
                raise  # nor is its beginning what it should be
            self.is_cut = True
            self.connections = []
            for found in (self.schemas, self.channels, self.chunks):
                found.clear()
            self._scan()

    def _scan(self):
        """Find chunks, topics and counts without the index, up to what is not whole."""
        begin = end = position = self.data_start
        size = self.bio.seek(0, 2)
        counts = {}
        while position + 9 <= size:
            self.bio.seek(position)
            kind, length = struct.unpack('<BQ', self.bio.read(9))
            self.data_start, self.data_end = position, position + 9 + length
            if not 1 < kind <= LAST_KIND or self.data_end > size:
                break
            try:
                self._take(kind, length, counts)
            except Exception:  # of a record that is damaged: what comes before it is whole
                break
            position = end = self.data_end
        self.data_start, self.data_end = begin, end
        self.connections = [connection._replace(msgcount=counts.get(connection.id, 0))
                            for connection in self.connections]

    def _take(self, kind, length, counts):
        """Take in the record from `data_start` to `data_end`."""
        if kind not in (SCHEMA, CHANNEL, CHUNK):
            return
        self.meta_scan()  # of this record alone
        for channel, number in self.statistics.channel_message_counts.items():
            counts[channel] = counts.get(channel, 0) + number
        if kind == CHUNK:
            self.bio.seek(self.data_start + 9)
            first, last, size, _, characters = struct.unpack('<QQQII', self.bio.read(32))
            compression = self.bio.read(characters).decode()
            (packed,) = struct.unpack('<Q', self.bio.read(8))
            self.chunks.append(ChunkInfo(
                first, last, self.data_start, 9 + length, {}, 0, compression, packed, size,
                dict(self.statistics.channel_message_counts)))


class _Sqlite(Sqlite3Reader):
    """A file of sqlite3; what was being written as its recorder was killed is rolled back."""

    is_cut = False

    def open(self):  # noqa: A003
        check_sqlite_path(self.path)
        opened(self.path).close()
        for ending in ('-journal', '-wal', '-shm'):
            left = Path(f'{self.path}{ending}')
            if left.is_symlink():
                raise ReaderError(f'{left} is a link.')
            if left.exists() and left.stat().st_size and ending != '-shm':
                self._recover(left)
        with contextlib.closing(sqlite3.connect(f'file:{self.path}?immutable=1',
                                                uri=True)) as file:
            _check_objects(file)
        super().open()

    def _recover(self, left):
        """Have SQLite take back, or finish, what was being written."""
        with opened(left) as journal:
            journal.seek(max(left.stat().st_size - len(JOURNAL_MAGIC), 0))
            if not left.name.endswith('-wal') and journal.read() == JOURNAL_MAGIC:
                # No recorder writes one, and SQLite would delete whatever file it names.
                raise ReaderError(f'{left} names another file.')
        self.is_cut = True
        with contextlib.closing(sqlite3.connect(self.path)) as file:
            file.execute('PRAGMA wal_checkpoint(TRUNCATE)').fetchall()
            file.execute('SELECT count(*) FROM sqlite_master').fetchone()

    def messages(self, connections, start=None, stop=None):
        for connection, at, data in super().messages(connections, start, stop):
            if not isinstance(at, int) or not isinstance(data, bytes):
                raise ReaderError(f'A message is {type(data).__name__} at {type(at).__name__}.')
            yield connection, at, data


def check_sqlite_path(path: Path) -> None:
    """Raise ReaderError for a path that rosbags, which quotes nothing, takes for another one."""
    if set('?%#') & set(str(path)):
        raise ReaderError('A path of sqlite3 has no ?, % or #.')


def _check_objects(file):
    """Raise ReaderError unless a file holds tables alone, and these nothing but what is stored."""
    for kind, name in file.execute('SELECT type, name FROM sqlite_master').fetchall():
        if kind not in ('table', 'index'):
            raise ReaderError(f'{name!r} is a {kind}.')
        quoted = name.replace('"', '""')
        if any(column[-1] for column in file.execute(f'PRAGMA table_xinfo("{quoted}")')):
            raise ReaderError(f'{name!r} has columns that are computed.')


class _Folder(DirectoryReader):
    """A bag with its metadata."""

    STORAGE_PLUGINS = {'mcap': _Mcap, 'sqlite3': _Sqlite}

    def open(self):  # noqa: A003
        with opened(self.path / 'metadata.yaml', LARGEST_METADATA) as file:
            for event in yaml.parse(file, getattr(yaml, 'CSafeLoader', yaml.SafeLoader)):
                if isinstance(event, yaml.AliasEvent):  # a few of them make much of little
                    raise ReaderError('The metadata have an alias.')
        super().open()
        self._is_packed = self.metadata.compression_mode == 'message'
        self.metadata = self.metadata._replace(compression_mode=None)

    @property
    def is_cut(self):
        return any(storage.is_cut for storage in self.storages)

    def messages(self, connections, start=None, stop=None):
        for connection, at, data in super().messages(connections, start, stop):
            data = _of_zstd(data) if self._is_packed else data
            if len(data) > LARGEST:
                raise ReaderError('A message is too large.')
            yield connection, at, data


class _Bag(Reader):
    STORAGE_PLUGINS = {'dir': _Folder, '.mcap': _Mcap, '.db3': _Sqlite}


class BagReader:
    """
    The messages of a bag, or of the files of one that has no metadata.

    types: {topic: type, None where it has several}. count: of its messages, as its metadata or its
    index have it. is_unfinished: whether its recorder has not
    come to its end, so that something may be missing. Raises whatever the libraries do.
    """

    def __init__(self, path: Path):
        files = [path]
        if path.is_dir() and not (path / 'metadata.yaml').exists():
            files = [file for ending in ('mcap', 'db3') for file in sorted(
                path.glob(f'*.{ending}'), key=lambda file: (len(file.name), file.name))]
            if not files:
                raise ReaderError('It has no metadata.yaml, and no file of mcap or sqlite3.')
        self._open = contextlib.ExitStack()
        with contextlib.ExitStack() as opening:
            self._bags = [opening.enter_context(_Bag(file)) for file in files]
            self._open = opening.pop_all()
        self.is_unfinished = files != [path] or any(bag.storage.is_cut for bag in self._bags)
        self.count = sum(one.msgcount for bag in self._bags for one in bag.connections)
        types = {}
        for connection in (one for bag in self._bags for one in bag.connections):
            types.setdefault(connection.topic, set()).add(connection.msgtype)
        self.types = {topic: found.pop() if len(found) == 1 else None
                      for topic, found in sorted(types.items())}

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, int, bytes]]:
        """Yield (topic, time in the bag [ns], serialised message) of some topics."""
        for bag in self._bags:
            wanted = [one for one in bag.connections if one.topic in topics]
            if wanted:
                for connection, at, data in bag.messages(wanted):
                    yield connection.topic, at, bytes(data)

    def close(self) -> None:
        """Close the files."""
        self._open.close()
