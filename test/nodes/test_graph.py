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
import signal

from flag_sim.drawing.camera import Camera
import numpy as np
import pytest
from support.forked import Graph
from support.relay import Relay, remap
from support.shot import film, messages_of, SMALL, stamp_of
from support.soak import SOAK

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


def project_by_hand(points, info, camera):
    """Return u, v of world points (..., 3) for a camera that looks along +y, tilted."""
    x, y, z = np.moveaxis(points - camera.position, -1, 0)
    tilt = camera.elevation
    depth = y * np.cos(tilt) - z * np.sin(tilt)
    down = -z * np.cos(tilt) - y * np.sin(tilt)
    return info.k[2] + info.k[0] * x / depth, info.k[5] + info.k[4] * down / depth


def covered(u, v, shape):
    """Return the pixels (height, width) whose centres are in a triangle of the grid (u, v)."""
    mask = np.zeros(shape, bool)
    corners = np.stack([u, v], axis=-1)
    upper = np.stack([corners[:-1, :-1], corners[:-1, 1:], corners[1:, :-1]], axis=2)
    lower = np.stack([corners[1:, 1:], corners[1:, :-1], corners[:-1, 1:]], axis=2)
    for triangle in np.concatenate([upper.reshape(-1, 3, 2), lower.reshape(-1, 3, 2)]):
        (left, top), (right, bottom) = np.floor(triangle.min(0)), np.ceil(triangle.max(0))
        rows, columns = np.mgrid[int(top):int(bottom) + 1, int(left):int(right) + 1]
        sides = [(b[0] - a[0]) * (rows - a[1]) - (b[1] - a[1]) * (columns - a[0])
                 for a, b in zip(triangle, np.roll(triangle, -1, axis=0))]
        inside = np.all(np.sign(sides) >= 0, axis=0) | np.all(np.sign(sides) <= 0, axis=0)
        mask[rows[inside], columns[inside]] = True
    return mask


def test_the_flag_is_on_the_pixels_that_camera_info_says(plain_bag):
    """
    The vertices, projected by hand with K and the pose, cover just the flag's red pixels.

    An edge that passes a pixel's centre by less than the 1/256 pixel to which vertices are
    snapped may fall on either side of it; the pole hides what is left of its edge.
    """
    _, info = messages_of(plain_bag, '/camera/camera_info')[0]
    camera = Camera()
    pole, _ = project_by_hand(np.array([0.06, 0.0, 8.0]), info, camera)
    beside = int(pole) + 1
    for (_, image), (_, cloud) in list(zip(messages_of(plain_bag, '/camera/image_raw'),
                                           messages_of(plain_bag, '/vertices')))[::6]:
        points = np.frombuffer(cloud.data, np.float32).reshape(21, 31, 6)[..., :3].astype(float)
        expected = covered(*project_by_hand(points, info, camera), (120, 160))[:, beside:]
        pixels = np.array(image.data).reshape(120, 160, 3)[:, beside:].astype(int)
        red = (pixels[..., 0] > 1.5 * pixels[..., 1]) & (pixels[..., 0] > 1.5 * pixels[..., 2])
        assert expected.sum() > 1500
        assert (red != expected).sum() <= 2


@pytest.mark.parametrize('source, nodes', [
    ('parameters', ('physics', 'renderer')), ('vertices', ('renderer',))])
def test_a_bag_plays_to_the_same_images(plain_bag, tmp_path, source, nodes):
    """
    The parameters alone give the pictures again, byte for byte.

    The sun is keyed in this shot. Vertices alone are drawn in the light of the renderer's own
    parameters, here that of the first key: so the first picture is the same, and the last is not.
    """
    topics = '[camera/image_raw, vertices]'
    morning = (*SMALL, '-p', 'sun.elevation:=0.2')
    with Graph(tmp_path / 'log') as graph:
        for node in nodes:
            graph.start(node, *(morning if node == 'renderer' else ()))
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p', f'topics:={topics}')
        graph.start('player', '-p', f'path:={plain_bag}', '-p', 'pace:=lockstep', '-p',
                    f'topics:=[{source}]', '-p', 'wait_for:=[renderer, recorder]')
        assert graph.wait('player', 90.0) == 0, graph.log('player')
    if source == 'parameters':
        assert_same_data(plain_bag, tmp_path / 'bag')
    else:
        before, after = ([message.data for _, message in messages_of(bag, '/camera/image_raw')]
                         for bag in (plain_bag, tmp_path / 'bag'))
        assert np.array_equal(before[0], after[0])
        assert not np.array_equal(before[-1], after[-1])
    stamps = [time for time, _ in messages_of(tmp_path / 'bag', '/camera/image_raw')]
    assert stamps == [round(n * 1e9 / 30.0) for n in range(FRAMES)]


@pytest.mark.parametrize('seed', range(8 if SOAK else 1))
def test_lockstep_survives_a_bad_network(plain_bag, tmp_path, domain, seed):
    """
    Messages lost, doubled and delayed on every wire change nothing in the bag.

    So two runs of a shot are the same to the bit, whatever happens to one of them.
    """
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


def test_leaving_a_graph_interrupts_each_node_once(tmp_path):
    """A second signal would end one that is just closing its bag."""
    asked = []

    class Closing:

        def __init__(self, name):
            """Have a name to tell."""
            self.name = name

        def poll(self):
            return None

        def send_signal(self, number):
            asked.append((self.name, number))

        def wait(self, seconds):
            return 0
    with Graph(tmp_path, domain=0) as graph:
        graph.processes.update(recorder=Closing('recorder'), renderer=Closing('renderer'))
    assert asked == [('recorder', signal.SIGINT), ('renderer', signal.SIGINT)]
