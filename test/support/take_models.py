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

"""The nodes' protocol as models on one network, without ROS: who is late, lost or killed."""
import heapq
import itertools
import random

from flag_sim.protocol.clock import FrameClock
from flag_sim.protocol.in_flight import FramesInFlight
from flag_sim.protocol.recording import Placement, Recording
from flag_sim.protocol.requests import Requests
from flag_sim.protocol.serving import FrameServer, Handlers
from flag_sim.protocol.stamp_buffer import StampBuffer
from flag_sim.protocol.take import Take

FRAMES = 12
RESEND_AFTER, WINDOW, QUEUE = 1.0, 3, 8
LATEST = (2**31 - 1) * 10**9
NAMES = 'wind', 'physics', 'renderer', 'recorder'
TICK = 0.05  # between looks of the wind [s]


class Network:
    """
    Carries messages (topic, content, sender) to those who listen, each after its own delay.

    loss, doubling: probability of each; longest: delay [s].
    """

    def __init__(self, seed):
        self.now = 0.0
        self.loss = self.doubling = 0.0
        self.longest = 0.001
        self._random = random.Random(seed)
        self._under_way, self._count = [], itertools.count()
        self._listeners = {}  # {topic: {node name: callback(content, sender)}}

    def listen(self, topic, name, callback):
        """Let a node hear a topic; one that is started again replaces the one before."""
        self._listeners.setdefault(topic, {})[name] = callback

    def leave(self, name):
        """Let a node hear nothing any more."""
        for listeners in self._listeners.values():
            listeners.pop(name, None)

    def publish(self, topic, content, sender):
        """Send a message to everybody who listens, or lose or double it on the way."""
        for name in self._listeners.get(topic, ()):
            for _ in range(1 + (self._random.random() < self.doubling)):
                if self._random.random() >= self.loss:
                    due = self.now + self.longest * self._random.random()
                    heapq.heappush(self._under_way, (
                        due, next(self._count), topic, name, content, sender))

    def run(self, until):
        """Deliver what is due until then."""
        while self._under_way and self._under_way[0][0] <= until:
            self.now, _, topic, name, content, sender = heapq.heappop(self._under_way)
            if name in self._listeners[topic]:
                self._listeners[topic][name](content, sender)
        self.now = until


class WindModel:
    """A wind in lockstep: the same objects as in the node, and what it does with them."""

    def __init__(self, network, life, take=0):
        self.network, self.sender, self.number = network, f'wind {life}', take
        self.in_flight, self.requests = FramesInFlight(), Requests()
        self.is_paused = self.is_over = False
        self.begin_take()
        network.listen('frame_done', 'wind', self.on_done)

    def begin_take(self):
        self.number += 1
        self.take = Take(self.number, FrameClock(30.0), FRAMES, LATEST)
        self.in_flight.clear()

    def send_again(self):
        sent = self.in_flight.resend(self.network.now, RESEND_AFTER)
        if sent is not None:
            sent.frame = sent.frame._replace(oldest=sent.frame.index)
            self.network.publish('parameters', sent.frame, self.sender)

    def fill_window(self):
        while ((not self.is_paused or self.requests.steps) and not self.requests.is_reset_asked
               and self.take.has_room(self.in_flight, WINDOW)):
            self.requests.steps = max(self.requests.steps - 1, 0)
            frame = self.take.next_id(self.take.oldest_index(self.in_flight))
            self.in_flight.send(frame, None, ['renderer', 'recorder'], self.network.now)
            assert len(self.in_flight) <= WINDOW
            self.network.publish('parameters', frame, self.sender)
            self.take.sent()

    def on_done(self, content, sender):
        if not self.is_over and self.in_flight.done(*content, self.network.now):
            self.send_again()
            self.fill_window()
            self.end_if_done()

    def look(self):
        if self.is_over:
            return
        if self.requests.is_reset_asked:
            self.finish_reset()
        else:
            self.send_again()
            self.fill_window()
        self.end_if_done()

    def reset(self):
        self.requests.reset(self.network.now)
        self.finish_reset()

    def finish_reset(self):
        idle = not len(self.in_flight)
        if self.requests.begins_take(idle, self.network.now, RESEND_AFTER):
            self.begin_take()

    def end_if_done(self):
        self.is_over = (not self.requests.is_reset_asked and self.take.is_over
                        and not len(self.in_flight))


class PhysicsModel:
    """Answers every frame's parameters with its vertices."""

    def __init__(self, network, life):
        self.network, self.sender = network, f'physics {life}'
        self.server = FrameServer(Handlers(
            lambda frame: True, lambda frame, _: frame.stamp,
            lambda stamp, _: network.publish('vertices', stamp, self.sender), lambda frame: None))
        network.listen('parameters', 'physics',
                       lambda frame, sender: self.server.take_frame(frame, None, sender))


class RendererModel:
    """Draws the frames whose vertices and parameters came, as the node does beside a wind."""

    def __init__(self, network, life):
        self.network, self.sender = network, f'renderer {life}'
        self.clouds, self.first = StampBuffer(QUEUE), None
        self.server = FrameServer(Handlers(
            lambda frame: frame.stamp in self.clouds,
            lambda frame, _: self.clouds.take(frame.stamp), self.answer, self.restart))
        network.listen('parameters', 'renderer',
                       lambda frame, sender: self.server.take_frame(frame, None, sender))
        network.listen('vertices', 'renderer', self.on_vertices)

    def restart(self, frame):
        self.first = frame.stamp
        self.clouds.keep({early.stamp for early in self.server.order.waiting.values()})

    def on_vertices(self, stamp, sender):
        if self.server.is_served(stamp):
            return
        if stamp == self.first:
            self.clouds.keep(())
        self.clouds.put(stamp, stamp)
        self.server.serve()

    def answer(self, stamp, _):
        self.network.publish('image', stamp, self.sender)
        self.network.publish('frame_done', (stamp, 'renderer'), self.sender)


class RecorderModel:
    """Records parameters, vertices and images."""

    def __init__(self, network, life):
        self.network, self.sender = network, f'recorder {life}'
        self.recording = Recording(['image', 'vertices', 'parameters'], FRAMES)
        self.early = {topic: StampBuffer(QUEUE) for topic in ('image', 'vertices')}
        network.listen('parameters', 'recorder', self.on_parameters)
        for topic in 'vertices', 'image':
            network.listen(topic, 'recorder',
                           lambda stamp, _, topic=topic: self.write(topic, stamp))

    def on_parameters(self, frame, sender):
        takes = self.recording.takes
        now = self.recording.follow(frame, frame.stamp, sender)
        for early in self.early.values():
            if takes < self.recording.takes:
                early.keep(())
        for stamp in now:
            self.write('parameters', stamp)
            for topic, early in self.early.items():
                if stamp in early:
                    self.write(topic, early.pop(stamp))

    def write(self, topic, stamp):
        if self.recording.is_early(topic, stamp):
            self.early[topic].put(stamp, stamp)
            return
        placement = self.recording.place(topic, stamp)
        if placement is Placement.WRITE and topic in self.early:
            early = self.early[topic]
            early.keep({other for other in early if other < stamp})
        if placement is Placement.ANSWER or (
                placement is Placement.WRITE and self.recording.written(topic, stamp)):
            self.network.publish('frame_done', (stamp, 'recorder'), self.sender)


class Stage:
    """A wind, physics, a renderer and a recorder on one network; each may be started again."""

    def __init__(self, seed=0):
        self.network = Network(seed)
        self.lives = itertools.count(1)
        self.wind = WindModel(self.network, 0)
        self.physics = PhysicsModel(self.network, 0)
        self.renderer = RendererModel(self.network, 0)
        self.recorder = RecorderModel(self.network, 0)

    def run(self, seconds):
        """Let time go by."""
        end = self.network.now + seconds
        while self.network.now < end:
            self.wind.look()
            self.network.run(min(self.network.now + TICK, end))

    def restart(self, name):
        """Kill a node and start it again."""
        life = next(self.lives)
        if name == 'wind':
            self.wind = WindModel(self.network, life, self.wind.number)
        else:
            setattr(self, name, {'physics': PhysicsModel, 'renderer': RendererModel,
                                 'recorder': RecorderModel}[name](self.network, life))

    def heal(self):
        """Let the network be sound again and nobody pause; what is under way still arrives."""
        self.network.loss = self.network.doubling = 0.0
        self.network.longest = 0.001
        self.wind.is_paused, self.wind.requests.steps = False, 0

    def assert_ends(self):
        """Assert that the take ends once the network is sound, and every queue is bounded."""
        self.heal()
        self.run(FRAMES * 4 * RESEND_AFTER + 20.0)
        # A recorder with which a stranger's frames count has ended before; the wind says so.
        oldest, has_all_frames = self.wind.in_flight.oldest, self.recorder.recording.has_all_frames
        assert self.wind.is_over or (has_all_frames and oldest.waiting_for == {'recorder'}), oldest
        for served in (self.physics.server, self.renderer.server):
            assert len(served) <= served.order.LONGEST_QUEUE
            assert len(served.inputs) <= served.order.LONGEST_QUEUE + 1
        assert len(self.renderer.clouds) <= QUEUE
