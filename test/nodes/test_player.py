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

"""The player: bags as `ros2 bag record` writes them, with gaps, takes, namespaces and names."""
from flag_sim.declarations.player import PLAYER
from flag_sim.declarations.recorder import RECORDER
from flag_sim.nodes.player import Player
from flag_sim.nodes.recorder import Recorder
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from flag_sim.ros.bag import Bag, RecordedTopics
from flag_sim.ros.parameter_node import BadParameter
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image, PointCloud2
from std_msgs.msg import Header, String
from support.forked import Graph
from support.frames import parameters_message
from support.shot import messages_of, SMALL, stamp_of

FRAME = 10**9 // 30  # [ns]
FRAMES = 12
NOW = 1_796_000_000 * 10**9  # of a wall clock [ns]
# When a topic's message is received after its frame was sent [ns]: more than two frames late.
LATE = {'/parameters': 0, '/vertices': 5 * FRAME // 2, '/camera/image_raw': 9 * FRAME // 2}
FLAT = np.zeros((2, 2, 3))


def parameters(index, take=1, window=3):
    """Return the serialised parameters of a frame in lockstep."""
    return serialize_message(parameters_message(
        '/wind', FrameId(index * FRAME, take, index, max(index - window + 1, 0)),
        [9.0, 3.0, 0.0], {}))


def vertices(index):
    """Return the serialised vertices of a frame."""
    return serialize_message(messages.cloud_message(index * FRAME, FLAT, FLAT))


def make_bag(path, rows):
    """Make a bag of [(time [ns], topic, message class, serialised)]; return its path."""
    bag = Bag(path, 'mcap', 'none')
    for topic, kind in {topic: kind for _, topic, kind, _ in rows}.items():
        bag.add_topic(topic, kind)
    for time, topic, _, data in sorted(rows, key=lambda row: row[0]):
        bag.write(topic, time, data)
    bag.close()
    return path


def received(path, frames=FRAMES, lost=(), prefix=''):
    """Make a bag with times of receipt, without the messages `lost` {(topic, index)}."""
    rows = [(NOW + index * FRAME + LATE[topic], prefix + topic, kind, make(index))
            for index in range(frames)
            for topic, kind, make in (('/parameters', ParameterEvent, parameters),
                                      ('/vertices', PointCloud2, vertices))
            if (topic, index) not in lost]
    return make_bag(path, rows)


@pytest.mark.parametrize('topics, consumers', [
    ('[parameters]', ('physics', 'renderer')), ('[parameters, vertices]', ('renderer',)),
    ('[/vertices, /parameters]', ('renderer',)), ('[vertices]', ('renderer',))])
def test_a_bag_with_times_of_receipt_plays_in_lockstep(tmp_path, domain, topics, consumers):
    """Every frame, once and in its turn."""
    bag = received(tmp_path / 'received')
    assert films(tmp_path, domain, bag, topics, consumers) == list(range(FRAMES))


def films(tmp_path, domain, bag, topics, consumers):
    """Play a bag in lockstep; return the indices of the images that were recorded of it."""
    with Graph(tmp_path / 'log', domain) as graph:
        for node in consumers:
            graph.start(node, *(SMALL if node == 'renderer' else ()))
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[/camera/image_raw]')
        graph.start('player', '-p', f'path:={bag}', '-p', 'pace:=lockstep', '-p',
                    f'topics:={topics}', '-p', 'wait_for:=[renderer, recorder]',
                    '-p', 'resend_after:=0.5')
        assert graph.wait('player', 90.0) == 0, graph.log('player') + graph.log('renderer')
        assert graph.end('recorder') == 0
    return [round(stamp_of(m) / FRAME)
            for _, m in messages_of(tmp_path / 'bag', '/camera/image_raw')]


def test_what_a_bag_lacks_holds_up_no_frame_that_it_has(tmp_path, domain):
    """A recorder that was late has lost a frame's vertices here, and all of a frame there."""
    bag = received(tmp_path / 'received',
                   lost={('/vertices', 3), ('/parameters', 7), ('/vertices', 7)})
    images = films(tmp_path, domain, bag, '[parameters, vertices]', ('renderer',))
    assert images == [i for i in range(FRAMES) if i not in (3, 7)]
    said = (tmp_path / 'log' / 'player.log').read_text()
    assert 'no longer waiting for the frame at 0.100 s: the bag lacks its vertices' in said


def player(domain, path, *topics, **values):
    """Return what a player of a bag would publish on; raise BadParameter if it refuses."""
    given = [f'path:={path}', *([f'topics:=[{", ".join(topics)}]'] if topics else [])]
    with rclpy.init(domain_id=domain, args=[
            '--ros-args', *(part for argument in given for part in ('-p', argument))]):
        node = Player()
        names = list(node._out)
        node.close()
        node.destroy_node()
    return names


@pytest.fixture(scope='module')
def two_flags(tmp_path_factory):
    """Return a bag of two cloths, and of others' topics that are called as ours are."""
    folder = tmp_path_factory.mktemp('two')
    text = serialize_message(String(data='x'))
    return make_bag(folder / 'bag', [
        (0, '/a/vertices', PointCloud2, vertices(0)), (0, '/b/vertices', PointCloud2, vertices(0)),
        (0, '/camera/image_raw', Image, serialize_message(messages.image_message(
            0, np.zeros((2, 2, 3), np.uint8)))),
        (0, '/node/parameters', String, text), (0, '/robot/wind', String, text)])


@pytest.mark.parametrize('topics, reason', [
    ((), 'the bag has 2 topics of the name vertices, /a/vertices, /b/vertices; name one'),
    (('vertices',), '/a/vertices, /b/vertices; name one'),
    (('/a/vertices', '/b/vertices'), '/a/vertices and /b/vertices would both be played on vert'),
    (('/a/vertices', '/a/vertices'), '/a/vertices and /a/vertices would both be played'),
    (('/vertices',), 'the bag has no /vertices; it has /a/vertices, /b/vertices, /camera/image'),
    (('wind',), 'the bag has no wind; it has'),
    (('parameters',), 'the bag has no parameters; it has'),
])
def test_topics_that_mean_not_one_thing_are_refused(domain, two_flags, topics, reason):
    """With the names as they stand in the bag."""
    with pytest.raises(BadParameter) as refusal:
        player(domain, two_flags, *topics)
    assert reason in str(refusal.value)


def test_names_as_the_bag_shows_them_are_accepted(domain, two_flags):
    """With their namespace, which is that of the nodes that were recorded."""
    assert player(domain, two_flags, '/b/vertices', 'camera/image_raw') == [
        'vertices', 'camera/image_raw']


def test_a_bag_without_a_source_is_refused(tmp_path, domain):
    """Nothing is played then unless it is asked for."""
    bag = make_bag(tmp_path / 'bag', [
        (0, '/keyframe', Header, serialize_message(messages.header(0, 'x')))])
    with pytest.raises(BadParameter, match='no parameters and no vertices; it has /keyframe'):
        player(domain, bag)
    with pytest.raises(BadParameter, match='has no vertices'):
        RecordedTopics(bag).find('vertices')


@pytest.mark.parametrize('names, refused', [
    ('[/cam1/vertices, /cam1/camera/image_raw]', ''),
    ('[/vertices]', "'/vertices' is not one of"),
    ('[vertices, /cam1/vertices]', "each is named once, but 'vertices'")])
def test_the_recorder_takes_names_as_the_graph_shows_them(tmp_path, domain, names, refused):
    """In its own namespace, for all that it records is relative to it."""
    arguments = ['--ros-args', '-r', '__ns:=/cam1', '-p', f'path:={tmp_path / "bag"}',
                 '-p', f'topics:={names}']
    with rclpy.init(domain_id=domain, args=arguments):
        if refused:
            with pytest.raises(BadParameter) as refusal:
                Recorder()
            assert refused in str(refusal.value)
            return
        node = Recorder()
        assert {s.topic_name for s in node.subscriptions} >= {
            '/cam1/vertices', '/cam1/camera/image_raw'}
        node.close()
        node.destroy_node()


@pytest.mark.parametrize('make, declarations', [(Player, PLAYER), (Recorder, RECORDER)])
def test_what_counts_only_at_the_start_is_refused_while_running(tmp_path, domain, make,
                                                                declarations):
    """These two read all their parameters once."""
    path = tmp_path / 'new' if make is Recorder else received(tmp_path / 'bag')
    with rclpy.init(domain_id=domain, args=['--ros-args', '-p', f'path:={path}']):
        node = make()
        for declaration in declarations:
            value = ['x'] if declaration.default == [] else declaration.default
            (result,) = node.set_parameters([Parameter(declaration.name, value=value)])
            assert result.reason == f'{declaration.name} is fixed at the start of the node'
        node.close()
        node.destroy_node()
