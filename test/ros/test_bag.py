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

"""Bags that are finished, full, moved, killed in the middle or none."""
import contextlib
import os
import sqlite3
import struct
import subprocess
import sys
import tracemalloc

from flag_sim.ros.bag import Bag, KEPT, RecordedTopics, type_name
from flag_sim.ros.parameter_node import BadParameter
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_typestore, Stores
from sensor_msgs.msg import Image
from support.bags import images_bag, recorded
from support.traced import traced


@pytest.mark.parametrize('content', [
    b'\xff\xfe\x00', b'rosbag2: [', b'', b'rosbag2_bagfile_information: {version: nine}'])
def test_invalid_metadata_is_refused(tmp_path, content):
    """Whatever a parser says of it, the bag and the reason are named."""
    images_bag(tmp_path / 'bag', 1)
    (tmp_path / 'bag' / 'metadata.yaml').write_bytes(content)
    with pytest.raises(BadParameter, match=f'path {tmp_path / "bag"}: cannot be read, '):
        RecordedTopics(tmp_path / 'bag')


def test_an_invalid_number_in_the_metadata_is_refused(tmp_path):
    """Where the library meets it only after it has opened the bag."""
    images_bag(tmp_path / 'bag', 1)
    metadata = tmp_path / 'bag' / 'metadata.yaml'
    metadata.write_text(metadata.read_text().replace('message_count: 1', 'message_count: one'))
    with pytest.raises(BadParameter, match=f'path {tmp_path / "bag"}: cannot be read, TypeError'):
        RecordedTopics(tmp_path / 'bag')


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_full_disk_leaves_whole_what_was_flushed(tmp_path, storage):
    """No record is cut off; what was not answered may be lost."""
    code = f"""
import resource, signal
from flag_sim.ros.bag import Bag
from sensor_msgs.msg import Image
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, resource.RLIM_INFINITY))
bag = Bag({str(tmp_path / 'bag')!r}, {storage!r}, 'none')
bag.add_topic('/camera/image_raw', Image)
try:
    for done in range(100):
        bag.write('/camera/image_raw', done, bytes(7000))
        bag.flush()
except OSError as error:
    print(done)
try:
    bag.close()
except OSError as error:
    print(error)
"""
    said = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)
    done, error = said.stdout.splitlines()
    assert error == KEPT and int(done) > 30, said.stderr
    times = [at for _, at, _ in recorded(tmp_path / 'bag', 'camera/image_raw')]
    assert times == list(range(int(done)))
    if storage == 'mcap':
        (file,) = (tmp_path / 'bag').iterdir()
        data, end = file.read_bytes(), 8
        while end < len(data):
            end += 9 + int.from_bytes(data[end + 1:end + 9], 'little')
        assert end == len(data)


@pytest.mark.parametrize('storage', ['mcap', 'sqlite3'])
def test_a_long_bag_takes_no_more_memory_than_a_short_one(tmp_path, storage):
    """Every frame has an entry in the index that is written at the end."""
    bag = Bag(tmp_path / 'bag', storage, 'none')
    bag.add_topic('/camera/image_raw', Image)

    def fill(times):
        for time in times:
            bag.write('/camera/image_raw', time, bytes(8))
            bag.flush()
    fill(range(500))
    tracemalloc.start()
    fill(range(500, 3000))
    grown = traced()
    tracemalloc.stop()
    assert grown < 100_000
    bag.close()
    with AnyReader([tmp_path / 'bag']) as reader:
        assert [time for _, time, _ in reader.messages()] == list(range(3000))


@pytest.mark.parametrize('compression', ['none', 'zstd'])
def test_a_bag_is_as_rosbags_writes_it_to_the_byte(tmp_path, compression):
    """With small messages and large ones, in their order and not, and chunks of several."""
    random = np.random.default_rng(1)
    told = [(f'/{topic}', int(time), random.bytes(size)) for topic, time, size in zip(
        random.choice(['a', 'b'], 40), random.integers(0, 10**12, 40),
        random.choice([0, 9, 70_000, 800_000, 1_200_000], 40))]
    ours = Bag(tmp_path / 'ours' / 'bag', 'mcap', compression)
    theirs = Writer(tmp_path / 'theirs' / 'bag', version=9, storage_plugin=StoragePlugin.MCAP)
    if compression == 'zstd':
        theirs.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    theirs.open()
    types = get_typestore(Stores.ROS2_KILTED)
    connections = {}
    for topic, type_ in (('/a', Image), ('/b', ParameterEvent)):
        ours.add_topic(topic, type_)
        connections[topic] = theirs.add_connection(topic, type_name(type_), typestore=types)
    for n, (topic, time, data) in enumerate(told):
        ours.write(topic, time, data)
        theirs.write(connections[topic], time, data)
        if n % 3 == 2:
            ours.flush()
            if theirs.storage.chunk.bio.tell():
                theirs.storage.close_chunk()
    ours.close()
    theirs.close()
    for name in ('bag.mcap', 'metadata.yaml'):
        assert ((tmp_path / 'ours' / 'bag' / name).read_bytes()
                == (tmp_path / 'theirs' / 'bag' / name).read_bytes())


def test_a_bag_that_was_moved_or_replaced_is_gone(tmp_path):
    """Nothing is written where nobody will look for it, and nothing over what is there now."""
    bag = Bag(tmp_path / 'bag', 'mcap', 'none')
    bag.add_topic('/camera/image_raw', Image)
    bag.write('/camera/image_raw', 1, b'')
    bag.check()
    (tmp_path / 'bag').rename(tmp_path / 'other')
    images_bag(tmp_path / 'bag', 1)
    before = next((tmp_path / 'bag').glob('*.mcap')).read_bytes()
    for call in (bag.check, bag.flush, bag.close):
        with pytest.raises(OSError, match='the folder is gone'):
            call()
    assert next((tmp_path / 'bag').glob('*.mcap')).read_bytes() == before


def test_the_order_of_a_bag_without_its_index_is_that_of_time(tmp_path):
    """As with the index; what belongs together may be chunks apart."""
    bag = Bag(tmp_path / 'bag', 'mcap', 'zstd')
    bag.add_topic('/camera/image_raw', Image)
    bag.add_topic('/parameters', ParameterEvent)
    for at in (3, 1, 2, 6, 5, 4):
        bag.write('/camera/image_raw' if at % 2 else '/parameters', at, bytes(at))
        bag.flush()
    bag.close()

    def read():
        reader = RecordedTopics(tmp_path / 'bag')
        found = list(reader.messages(reader.names))
        reader.close()
        return reader.is_unfinished, found
    is_unfinished, whole = read()
    assert not is_unfinished and [at for _, at, _ in whole] == [1, 2, 3, 4, 5, 6]
    (tmp_path / 'bag' / 'metadata.yaml').unlink()
    assert read() == (True, whole)
    (file,) = (tmp_path / 'bag').glob('*.mcap')
    file.write_bytes(file.read_bytes()[:-20])
    assert read() == (True, whole)


def test_a_folder_without_a_bag_is_refused(tmp_path):
    """In words."""
    (tmp_path / 'bag').mkdir()
    with pytest.raises(BadParameter, match='It has no metadata.yaml, and no file of mcap'):
        RecordedTopics(tmp_path / 'bag')
    os.mkfifo(tmp_path / 'bag' / 'x.mcap')
    with pytest.raises(BadParameter, match='is not a file'):
        RecordedTopics(tmp_path / 'bag')


def sqlite_bag(folder):
    """Return the file of a small bag."""
    bag = Bag(str(folder), 'sqlite3', 'none')
    bag.add_topic('/parameters', ParameterEvent)
    bag.write('/parameters', 0, serialize_message(ParameterEvent()))
    bag.close()
    return folder / f'{folder.name}.db3'


def test_a_journal_that_names_another_file_is_not_followed(tmp_path):
    """By SQLite that file would be deleted once what was being written is taken back."""
    file, victim = sqlite_bag(tmp_path / 'bag'), tmp_path / 'thesis'
    victim.write_text('mine')
    name, magic = str(victim).encode(), bytes.fromhex('d9d505f920a163d7')
    pages = file.stat().st_size // 4096
    journal = (magic + struct.pack('>5I', 0, 0, pages, 512, 4096)).ljust(512, b'\0')
    journal += struct.pack('>I', 0x40000000 // 4096 + 1) + name
    journal += struct.pack('>2I', len(name), sum(name)) + magic
    file.with_name(f'{file.name}-journal').write_bytes(journal)
    with pytest.raises(BadParameter, match='names another file'):
        RecordedTopics(str(file.parent))
    assert victim.read_text() == 'mine'


@pytest.mark.parametrize('ending', ['-journal', '-wal', '-shm'])
def test_what_lies_beside_a_bag_is_no_link(tmp_path, ending):
    """It would be written to."""
    file = sqlite_bag(tmp_path / 'bag')
    (tmp_path / 'thesis').write_text('mine')
    file.with_name(f'{file.name}{ending}').symlink_to(tmp_path / 'thesis')
    with pytest.raises(BadParameter, match='is a link'):
        RecordedTopics(str(file.parent))
    assert (tmp_path / 'thesis').read_text() == 'mine'


@pytest.mark.parametrize('change', [
    'ALTER TABLE messages ADD x BLOB AS (zeroblob(999999000))',
    'CREATE VIEW endless AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT 1 FROM n) '
    'SELECT x FROM n',
    'CREATE TRIGGER again AFTER INSERT ON messages BEGIN DELETE FROM messages; END'])
def test_a_bag_holds_nothing_that_is_computed(tmp_path, change):
    """Which takes as much time and memory as its author likes."""
    file = sqlite_bag(tmp_path / 'bag')
    with contextlib.closing(sqlite3.connect(file)) as bag:
        bag.execute(change)
        bag.commit()
    with pytest.raises(BadParameter, match='computed|is a view|is a trigger'):
        RecordedTopics(str(file.parent))


@pytest.mark.parametrize('name', ['mine?x', 'a%41', 'a#b', 'x?mode=memory'])
def test_a_path_that_sqlite_takes_for_another_one_is_refused(tmp_path, name):
    """The library asks for it as a URI, without quoting."""
    with pytest.raises(BadParameter, match=r'no \?, % or #'):
        Bag(str(tmp_path / name), 'sqlite3', 'none')
    assert not list(tmp_path.iterdir())
    Bag(str(tmp_path / name), 'mcap', 'none').close()
