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

"""A bag that is looped gives as much in every round as in the first."""
import itertools

from flag_sim.nodes.renderer import Renderer
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
import numpy as np
import pytest
import rclpy
from support.bench import Bench, WIND
from support.forked import Graph
from support.frames import parameters_message
from support.nodes import hear
from support.shot import messages_of, SMALL, stamp_of
from support.watch import eventually, Watcher

FRAME = 10**9 // 25  # [ns]
FRAMES, ROUNDS = 40, 3


def bag(window=1, takes=(1,)):
    """Return the frames of a bag."""
    return [FrameId(index * FRAME, take, index, max(index - window + 1, 0))
            for take in takes for index in range(FRAMES)]


def parameters(frame):
    """Return the `parameters` message of a frame."""
    return parameters_message('/wind', frame, WIND, {})


@pytest.mark.parametrize('frames', [bag(), bag(window=3), bag(takes=(1, 2))])
def test_physics_moves_the_cloth_in_every_round_as_in_the_first(domain, frames):
    """To the byte: every round begins with the cloth at rest."""
    with rclpy.init(domain_id=domain):
        bench = Bench()
        for frame in ROUNDS * frames:
            bench.hear(parameters(frame))
        clouds = [cloud.data for cloud in bench.clouds]
        bench.close()
    assert len(clouds) == ROUNDS * len(frames)
    for number in range(1, ROUNDS):
        assert clouds[number * len(frames):(number + 1) * len(frames)] == clouds[:len(frames)]
    assert clouds[0] != clouds[FRAMES - 1]


@pytest.mark.parametrize('topics', [
    ('parameters', 'vertices'), ('vertices', 'parameters'), ('vertices',)])
@pytest.mark.parametrize('frames', [bag(), bag(window=3), bag(takes=(1, 2))])
def test_the_renderer_draws_every_frame_of_every_round(domain, topics, frames, monkeypatch):
    """Of a bag of vertices, with their parameters or without, whichever of both comes first."""
    flat = np.zeros((2, 2, 3))
    drawn = []
    monkeypatch.setattr('flag_sim.nodes.renderer.WIND_DISCOVERY_TIME', 0.0)
    with rclpy.init(domain_id=domain, args=['--ros-args', *SMALL]):
        node = Renderer()
        node.answer = lambda stamp, shot: drawn.append(stamp)
        node.count_publishers = lambda topic: int('parameters' in topics)
        for frame in ROUNDS * frames:
            sent = {'parameters': parameters(frame),
                    'vertices': messages.cloud_message(frame.stamp, flat, flat)}
            for topic in topics:
                hear(node, topic, sent[topic])
        node.destroy_node()
    assert drawn == [frame.stamp for frame in ROUNDS * frames]


def test_a_looped_bag_gives_all_images_of_every_round(tmp_path, domain):
    """Through real nodes; what is recorded of the rounds are takes, one after another."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        images, done = watcher.listen('camera/image_raw'), watcher.listen('frame_done')
        player = watcher.publisher('parameters')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[parameters, camera/image_raw]')
        first, *others = bag()

        def is_served(frame):
            """Return whether a frame is drawn and recorded: then none waits in a queue."""
            return messages.to_stamp(images[-1].header.stamp) == frame.stamp and 'recorder' in [
                message.frame_id for message in done
                if messages.to_stamp(message.stamp) == frame.stamp]
        eventually(lambda: player.publish(parameters(first)) or images and (
            {message.frame_id for message in done} == {'renderer', 'recorder'}), watcher)
        for frame in others + (ROUNDS - 1) * bag():
            del done[:]
            player.publish(parameters(frame))
            if frame.index:  # the first of a round is drawn with the second
                eventually(lambda: is_served(frame), watcher)
        # The first frame was sent until it was heard: its copies are no others.
        stamps = [stamp for stamp, _ in itertools.groupby(
            messages.to_stamp(image.header.stamp) for image in images)]
        assert stamps == ROUNDS * [frame.stamp for frame in bag()]
        assert graph.end('recorder') == 0
        assert f'{ROUNDS} takes' in graph.log('recorder')
    for topic in ('/camera/image_raw', '/parameters'):
        recorded = messages_of(tmp_path / 'bag', topic)
        times = [time for time, _ in recorded]
        assert len(times) == ROUNDS * FRAMES and times == sorted(times)
    assert [stamp_of(m) for _, m in messages_of(tmp_path / 'bag', '/camera/image_raw')] == stamps
