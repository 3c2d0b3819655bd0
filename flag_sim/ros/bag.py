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

"""Bags, written and read by the rosbags library; the real rosbag2 reads and plays them too."""
from collections.abc import Iterable, Iterator
import contextlib
import os
from pathlib import Path
import sqlite3

from flag_sim.parameters import checks
from flag_sim.ros.bag_index import IndexOnDisk
from flag_sim.ros.mcap_chunks import ChunkWriter
from flag_sim.ros.parameter_node import BadParameter
from flag_sim.ros.topics import TOPICS

try:
    from flag_sim.ros.bag_reader import BagReader, check_sqlite_path
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.rosbag2 import ReaderError, WriterError
    from rosbags.typesys import get_typestore, Stores
except ImportError:
    Writer = None


KEPT = 'what was said to be done is kept, and the player plays it'
GONE = 'the folder is gone, and what was recorded with it'
NO_ROSBAGS = "bags need rosbags: pip install 'flag_sim[record]'"


def expanded(path: str) -> Path:
    """Return a bag's path with the home that `~` stands for; raise BadParameter without one."""
    try:
        return checks.path('path', path)
    except ValueError as error:
        raise BadParameter(str(error)) from None


def type_name(message_type: type) -> str:
    """Return how bags name a ROS message class."""
    package = message_type.__module__.split('.')[0]
    return f'{package}/msg/{message_type.__name__}'


class Bag:
    """
    A new bag at `path`; nothing that exists is overwritten.

    storage: 'mcap' or 'sqlite3'; compression: 'none' or 'zstd' (of the file's chunks, which every
    reader understands; only mcap has it). A bag whose writer is killed keeps all that was written
    before the last `flush`, and `RecordedTopics` reads it. Raises BadParameter where it cannot be
    opened.
    """

    def __init__(self, path: str, storage: str, compression: str):
        if Writer is None:
            raise BadParameter(NO_ROSBAGS)
        if compression != 'none' and storage != 'mcap':
            raise BadParameter(f'compression {compression} needs storage mcap, not {storage}')
        self.path = expanded(path)
        self._storage = storage
        self._is_aborted = False
        self._whole = 0  # bytes of the file at the last flush
        self._types = get_typestore(Stores.ROS2_KILTED)
        self._connections = {}
        self._index = contextlib.ExitStack()
        try:
            if storage == 'sqlite3':
                check_sqlite_path(self.path)
            self._writer = Writer(self.path, version=9,
                                  storage_plugin=StoragePlugin[storage.upper()])
            if compression == 'zstd':
                self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            self._writer.open()
            self._file = self._writer.storage.path
            if storage == 'sqlite3':
                # To wait for the disk at every flush took 30 ms. The system has all of it either
                # way, and keeps it whatever becomes of this process.
                self._writer.storage.conn.execute('PRAGMA synchronous = OFF')
            else:
                self._writer.storage.chunks = self._index.enter_context(
                    contextlib.closing(IndexOnDisk(self.path)))
                self._writer.storage = ChunkWriter(self._writer.storage)
            self._identity = _identity(self._file)
        except (ReaderError, WriterError, OSError, sqlite3.Error) as error:
            raise BadParameter(f'path {self.path}: {error}') from None

    def add_topic(self, topic: str, message_type: type) -> None:
        """Add a topic by its full name; `message_type` is a ROS message class."""
        self._connections[topic] = self._writer.add_connection(
            topic, type_name(message_type), typestore=self._types)

    def write(self, topic: str, time: int, data: bytes) -> None:
        """
        Write a serialised message at `time` [ns].

        Raises OSError where the disk is full; then the bag ends as it was at the last flush.
        """
        with self._ending():
            self._writer.write(self._connections[topic], time, data)

    def flush(self) -> None:
        """
        Hand all that was written to the system, which keeps it if this process is killed.

        Raises OSError where the disk is full or the bag is gone; then it ends as it was before.
        """
        with self._ending():
            self.check()
            storage = self._writer.storage
            if self._storage == 'sqlite3':
                storage.conn.commit()
            else:
                self._whole = storage.flush()

    def check(self) -> None:
        """Raise OSError if the file that is written to is no longer in its place."""
        if _identity(self._file) != self._identity:
            raise OSError(GONE)

    @contextlib.contextmanager
    def _ending(self):
        """End the bag where it can be written no more, and raise OSError."""
        try:
            yield
        except (OSError, sqlite3.Error) as error:
            self._abort()
            raise OSError(str(error)) from None

    def close(self) -> None:
        """
        Finish the file and its metadata.

        Raises OSError, which says what helps, where the disk is full or the bag is gone.
        """
        if self._is_aborted:
            self.check()
            raise OSError(KEPT)
        self.flush()
        try:
            with self._ending(), self._index:
                self._writer.close()
        except OSError as error:
            raise OSError(f'{error}; {KEPT}') from None

    @property
    def size(self) -> int:
        """Return how much of the disk the bag takes [bytes]."""
        return sum(file.stat().st_size for file in self.path.iterdir())

    def _abort(self):
        """Leave the file as it was at the last flush: no record of it is cut off."""
        self._is_aborted = True
        with contextlib.suppress(OSError, sqlite3.Error), self._index:
            self._writer.abort()
        if self._storage == 'mcap' and _identity(self._file) == self._identity:
            with contextlib.suppress(OSError):
                os.truncate(self._file, self._whole)


def _identity(path):
    """Return which file is at `path`, or None."""
    with contextlib.suppress(OSError):
        found = os.stat(path)
        return found.st_dev, found.st_ino
    return None


class RecordedTopics:
    """
    The package's own topics in a bag, whoever recorded it.

    names: {topic in the bag: its name in `topics.TOPICS`} of all that have its type; a namespace
    before it makes no difference. is_unfinished: whether its recorder was killed: what is whole of
    it is read. Raises BadParameter where there is no bag that can be read.
    """

    def __init__(self, path: str):
        if Writer is None:
            raise BadParameter(NO_ROSBAGS)
        if not path:
            raise BadParameter('path must name a bag: --ros-args -p path:=my_bag')
        path = expanded(path)
        if not path.exists():
            raise BadParameter(f'path: there is no bag {str(path)!r}')
        self._path = path
        with self._readable():
            self._reader = BagReader(path)
            self.is_unfinished = self._reader.is_unfinished
            self.names = {topic: name for topic, type_ in self._reader.types.items()
                          for name in TOPICS if topic.endswith('/' + name.lstrip('/'))
                          and type_ == type_name(TOPICS[name].message)}

    def find(self, name: str) -> str:
        """
        Return the topic in the bag that is meant by its name there or in `topics.TOPICS`.

        Raises BadParameter where there is none, and where there are several.
        """
        found = [topic for topic, own in self.names.items() if own == name]
        if name in self.names:
            found = [name]
        if not found:
            raise BadParameter(f'topics: the bag has no {name}; '
                               f'it has {", ".join(self.names) or "none of ours"}')
        if len(found) > 1:
            raise BadParameter(f'topics: the bag has {len(found)} topics of the name {name}, '
                               f"{', '.join(found)}; name one as it stands there: "
                               f"topics:='[{found[0]}]'")
        return found[0]

    def messages(self, names: Iterable[str]) -> Iterator[tuple[str, int, bytes]]:
        """
        Yield (name in `topics.TOPICS`, time in the bag [ns], serialised message), in its order.

        names: of the topics that are read, as `find` takes them. Raises BadParameter where the
        bag is damaged.
        """
        topics = {self.find(name) for name in names}
        messages = self._reader.messages(topics)
        while True:
            with self._readable():
                message = next(messages, None)
            if message is None:
                return
            topic, at, data = message
            yield self.names[topic], at, data

    @contextlib.contextmanager
    def _readable(self):
        """Raise BadParameter, naming the bag, for whatever the library says of its bytes."""
        try:
            yield
        except Exception as error:  # of YAML, of zstd, of MCAP, of SQLite, of the disk
            reason = ' '.join(f'{type(error).__name__}: {error}'[:200].split())
            raise BadParameter(f'path {self._path}: cannot be read, {reason}') from None

    def close(self) -> None:
        """Close the bag."""
        self._reader.close()
