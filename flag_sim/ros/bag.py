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
from pathlib import Path
import sqlite3

from flag_sim.parameters import checks
from flag_sim.ros.parameter_node import BadParameter
from flag_sim.ros.topics import TOPICS

try:
    from rosbags.highlevel import AnyReader
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.rosbag2 import WriterError
    from rosbags.typesys import get_typestore, Stores
except ImportError:
    Writer = None


NOTHING_KEPT = 'sqlite3 keeps nothing of a bag that is not finished'
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
    reader understands; only mcap has it). A bag whose writer is killed keeps all but its last
    chunk in mcap and nothing in sqlite3. Raises BadParameter where it cannot be opened.
    """

    def __init__(self, path: str, storage: str, compression: str):
        if Writer is None:
            raise BadParameter(NO_ROSBAGS)
        if compression != 'none' and storage != 'mcap':
            raise BadParameter(f'compression {compression} needs storage mcap, not {storage}')
        self.path = expanded(path)
        self._storage = storage
        self._is_aborted = False
        self._types = get_typestore(Stores.ROS2_KILTED)
        self._connections = {}
        try:
            self._writer = Writer(self.path, version=9,
                                  storage_plugin=StoragePlugin[storage.upper()])
            if compression == 'zstd':
                self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            self._writer.open()
        except (WriterError, OSError, sqlite3.Error) as error:
            raise BadParameter(f'path {self.path}: {error}') from None

    def add_topic(self, topic: str, message_type: type) -> None:
        """Add a topic by its full name; `message_type` is a ROS message class."""
        self._connections[topic] = self._writer.add_connection(
            topic, type_name(message_type), typestore=self._types)

    def write(self, topic: str, time: int, data: bytes) -> None:
        """Write a serialised message at `time` [ns]; raises OSError where the disk is full."""
        try:
            self._writer.write(self._connections[topic], time, data)
        except sqlite3.Error as error:  # what was written before is rolled back
            self._abort()
            raise OSError(f'{error}; {NOTHING_KEPT}') from None

    def close(self) -> None:
        """
        Finish the file and its metadata.

        Raises OSError, which says what helps, where the disk is full or the bag is gone.
        """
        if not self.path.exists():
            self._abort()
            raise OSError('the folder is gone, and what was recorded with it')
        if self._is_aborted:
            raise OSError(NOTHING_KEPT)
        try:
            self._writer.close()
        except (OSError, sqlite3.Error) as error:
            self._abort()
            raise OSError(f'{error}; ' + (
                f"'ros2 bag reindex {self.path}' can make it readable"
                if self._storage == 'mcap' else NOTHING_KEPT)) from None

    @property
    def size(self) -> int:
        """Return how much of the disk the bag takes [bytes]."""
        return sum(file.stat().st_size for file in self.path.iterdir())

    def _abort(self):
        self._is_aborted = True
        with contextlib.suppress(OSError, sqlite3.Error):
            self._writer.abort()


class RecordedTopics:
    """
    The package's own topics in a bag, whoever recorded it.

    names: {topic in the bag: its name in `topics.TOPICS`} of all that have its type; a namespace
    before it makes no difference. Raises BadParameter where there is no bag that can be read.
    """

    def __init__(self, path: str):
        if Writer is None:
            raise BadParameter(NO_ROSBAGS)
        if not path:
            raise BadParameter('path must name a bag: --ros-args -p path:=my_bag')
        path = expanded(path)
        if not path.exists():
            raise BadParameter(f'path: there is no bag {str(path)!r}')
        if path.is_dir() and not (path / 'metadata.yaml').exists():
            raise BadParameter(
                f'path: {str(path)!r} is not a finished bag: it has no metadata.yaml. If its '
                f"recorder was killed, 'ros2 bag reindex {path}' helps: mcap has kept all but its "
                'last chunk, sqlite3 nothing')
        self._path = path
        with self._readable():
            self._reader = AnyReader([path])
            self._reader.open()
            types = {topic: info.msgtype for topic, info in sorted(self._reader.topics.items())}
        self.names = {topic: name for topic, type_ in types.items() for name in TOPICS
                      if topic.endswith('/' + name.lstrip('/'))
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
        wanted = [c for c in self._reader.connections if c.topic in topics]
        messages = self._reader.messages(wanted)
        while True:
            with self._readable():
                message = next(messages, None)
            if message is None:
                return
            connection, at, data = message
            yield self.names[connection.topic], at, bytes(data)

    @contextlib.contextmanager
    def _readable(self):
        """Raise BadParameter, naming the bag, for whatever the library says of its bytes."""
        try:
            yield
        except Exception as error:  # of YAML, of zstd, of MCAP, of SQLite, of the disk
            reason = f'{type(error).__name__}: {error}'
            raise BadParameter(f'path {self._path}: cannot be read, {reason}') from None

    def close(self) -> None:
        """Close the bag."""
        self._reader.close()
