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

"""The graph of real nodes: separate processes over real DDS, from wind to bag."""
import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('rosbags')

from flag_sim.nodes.graph import Graph  # noqa: E402
from support.relay import Relay, remap  # noqa: E402
from support.shot import film, messages_of, stamp_of  # noqa: E402

FRAMES = 60
EVERY_FRAME = ('/camera/image_raw', '/camera/camera_info', '/vertices')


@pytest.fixture(scope='module')
def plain_bag(tmp_path_factory):
    """Return the bag of the small shot, filmed without disturbance."""
    folder = tmp_path_factory.mktemp('plain')
    with Graph(folder / 'log') as graph:
        assert film(graph, folder / 'bag', FRAMES) == 0, graph.log('wind')
        assert graph.processes['recorder'].poll() == 0, graph.log('recorder')
    return folder / 'bag'


def assert_same_data(bag, other):
    """Assert that two bags hold the same images and vertices, byte for byte."""
    for topic in ('/camera/image_raw', '/vertices'):
        for (time, message), (other_time, other_message) in zip(
                messages_of(bag, topic), messages_of(other, topic), strict=True):
            assert time == other_time
            assert np.array_equal(message.data, other_message.data), f'{topic} at {time}'


@pytest.mark.parametrize('topic', EVERY_FRAME)
def test_every_frame_once_and_in_order(plain_bag, topic):
    """A lockstep shot leaves one message a frame on each topic, stamped n / rate."""
    stamps = [stamp_of(message) for _, message in messages_of(plain_bag, topic)]
    assert stamps == [round(n * 1e9 / 30.0) for n in range(FRAMES)]


def test_two_runs_are_identical(plain_bag, tmp_path):
    """The same shot twice gives the same vertices and pixels to the bit."""
    with Graph(tmp_path / 'log') as graph:
        assert film(graph, tmp_path / 'bag', FRAMES) == 0, graph.log('wind')
    assert_same_data(plain_bag, tmp_path / 'bag')


@pytest.mark.parametrize('seed', range(2))
def test_lockstep_survives_a_bad_network(plain_bag, tmp_path, domain, seed):
    """Messages lost, doubled and delayed on every wire change nothing in the bag."""
    topics = ('parameters', 'vertices', 'camera/image_raw', 'camera/camera_info', 'frame_done')
    soon = ('-p', 'resend_after:=0.1')
    with Graph(tmp_path / 'log', domain) as graph, \
            Relay(domain, topics, chance=0.08, longest=0.4, seed=seed) as relay:
        status = film(graph, tmp_path / 'bag', FRAMES, extra={
            'wind': [*soon, *remap('parameters')],
            'physics': remap('vertices'),
            'renderer': remap('camera/image_raw', 'camera/camera_info', 'frame_done'),
            'recorder': remap('frame_done')})
        assert status == 0, graph.log('wind')
        assert min(relay.lost, relay.doubled, relay.delayed) > 10
    for topic in EVERY_FRAME:
        stamps = [stamp_of(message) for _, message in messages_of(tmp_path / 'bag', topic)]
        assert stamps == [round(n * 1e9 / 30.0) for n in range(FRAMES)], topic
    assert_same_data(plain_bag, tmp_path / 'bag')
