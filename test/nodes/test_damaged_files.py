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

"""Every file that is read may be damaged: it is read or refused in a line, and nothing dies."""
import contextlib
import resource
import signal

from flag_sim.nodes.wind import Wind
from flag_sim.parameters.config import config_path
from flag_sim.parameters.file_targets import keys_in
from flag_sim.parameters.params_file import check_path, save_parameters
from flag_sim.ros import messages
from flag_sim.ros.bag import Bag, RecordedTopics
from flag_sim.ros.bag_reader import LARGEST
from flag_sim.ros.parameter_node import BadParameter
from hypothesis import given
import lz4.frame
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import ReaderError, storage_mcap
from sensor_msgs.msg import Image
from support.damage import damaged, inputs

HUNG = 120
"""Seconds after which an input counts as one that hangs."""


@contextlib.contextmanager
def bounded():
    """End what hangs, and see that memory stays bounded."""
    def end(*_):
        raise TimeoutError('it hangs')
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    handler = signal.signal(signal.SIGALRM, end)
    signal.alarm(HUNG)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, handler)
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) << 10
    assert grown < 2 * LARGEST


def small_bag(path, storage, compression='none'):
    """Make a bag of a few frames; return its files, the data first."""
    bag = Bag(path, storage, compression)
    bag.add_topic('/parameters', ParameterEvent)
    bag.add_topic('/camera/image_raw', Image)
    for index in range(5):
        bag.write('/parameters', index * 10**7, serialize_message(ParameterEvent(node='/wind')))
        bag.write('/camera/image_raw', index * 10**7, serialize_message(
            messages.image_message(index * 10**7, np.zeros((2, 2, 3), np.uint8))))
        bag.flush()
    bag.close()
    return sorted(path.iterdir(), key=lambda file: file.name == 'metadata.yaml')


def read_bag(path):
    """Read a bag to its end; return the number of its messages, or -1 if it was refused."""
    with bounded():
        try:
            bag = RecordedTopics(path)
            try:
                found = list(bag.messages(bag.names))
            finally:
                bag.close()
        except BadParameter as error:
            assert len(str(error)) < 300 + len(str(path)) and '\n' not in str(error)
            return -1
    for name, at, data in found:
        assert isinstance(name, str) and isinstance(at, int) and isinstance(data, bytes)
    return len(found)


def test_a_whole_bag_is_read(tmp_path):
    """What the damage below begins with."""
    for storage in ('mcap', 'sqlite3'):
        small_bag(tmp_path / storage, storage)
        assert read_bag(tmp_path / storage) == 10


@pytest.mark.parametrize('is_finished', [True, False])
@pytest.mark.parametrize(('storage', 'compression'), [
    ('mcap', 'none'), ('mcap', 'zstd'), ('sqlite3', 'none')])
def test_damaged_data_of_a_bag(tmp_path, storage, compression, is_finished):
    """With and without its metadata; what it gives are messages, or it is refused."""
    file, metadata = small_bag(tmp_path / 'bag', storage, compression)
    if not is_finished:
        metadata.unlink()
    tried = []

    @inputs(60)
    @given(damaged(file.read_bytes()))
    def read(data):
        file.write_bytes(data)
        tried.append(read_bag(tmp_path / 'bag'))
    read()
    print(f'{len(tried)} damaged files of {storage}, {tried.count(-1)} refused, 0 faults')


def test_damaged_metadata_of_a_bag(tmp_path):
    """They name files, topics and types."""
    _, metadata = small_bag(tmp_path / 'bag', 'mcap')
    tried = []

    @inputs(60)
    @given(damaged(metadata.read_bytes()))
    def read(data):
        metadata.write_bytes(data)
        tried.append(read_bag(tmp_path / 'bag'))
    read()
    print(f'{len(tried)} damaged metadata, {tried.count(-1)} refused, 0 faults')


@pytest.mark.parametrize('compression', ['zstd', 'lz4'])
def test_a_chunk_that_says_little_and_holds_much(tmp_path, compression):
    """It takes no more memory than it says; what says more than the limit is refused."""
    pack = (lz4.frame if compression == 'lz4' else storage_mcap.zstd).compress
    packed = pack(bytes(1 << 24))
    unpack = storage_mcap.DECOMPRESSORS[compression]
    assert len(packed) < 1 << 18 and len(unpack(packed, 1000)) == 1001
    with pytest.raises(ReaderError, match='too large'):
        unpack(packed, LARGEST + 1)


def test_metadata_that_refer_to_themselves_are_refused(tmp_path):
    """Nine lines of them would be a text of a thousand million words."""
    _, metadata = small_bag(tmp_path / 'bag', 'mcap')
    lines = ['a0: &a0 [x]'] + [f'a{n}: &a{n} [{", ".join([f"*a{n - 1}"] * 9)}]'
                               for n in range(1, 10)]
    metadata.write_text('\n'.join(lines) + '\n' + metadata.read_text().replace(
        "compression_mode: ''", 'compression_mode: file').replace(
        "compression_format: ''", 'compression_format: *a9'))
    assert read_bag(tmp_path / 'bag') == -1


def test_damaged_params_files(tmp_path, domain):
    """Of the nodes, and of those that save_to finds: refused in a line, or taken."""
    path = tmp_path / 'x.yaml'
    save_parameters(path, '/wind', {'speed': 6.0, 'tracks': ['wind.speed'], 'events.names': [],
                                    'keys.wind.speed.times': [0.0, 1.0],
                                    'keys.wind.speed.values': [0.0, 1.0]})
    saved = path.read_bytes()
    tried = []

    def take(data):
        path.write_bytes(data)
        tried.append('refused')
        with bounded():
            with contextlib.suppress(ValueError):
                keys_in(path)
            with contextlib.suppress(ValueError):
                check_path(path, ('wind', 'physics', 'renderer'))
            try:
                context = rclpy.init(domain_id=domain, args=[
                    '--ros-args', '--params-file', str(path)])
            except RuntimeError:
                return  # which `run` says in a line
            with context:
                tried[-1] = 'read'
                if len(tried) % 10 == 0:  # a node takes a while
                    try:
                        Wind().destroy_node()
                    except BadParameter:
                        tried[-1] = 'refused'
    for whole in (saved, config_path('gust.yaml').read_bytes()):
        inputs(60)(given(damaged(whole))(take))()
    print(f'{len(tried)} damaged params files, {tried.count("refused")} refused, 0 faults')
