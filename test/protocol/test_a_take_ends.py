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

"""Whatever the network and its strangers do, a take ends: the nodes' protocol, without ROS."""
import heapq
import itertools
import random

from flag_sim.protocol.clock import FrameClock
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.in_flight import FramesInFlight
from flag_sim.protocol.recording import Placement, Recording
from flag_sim.protocol.requests import Requests
from flag_sim.protocol.serving import FrameServer, Handlers
from flag_sim.protocol.stamp_buffer import StampBuffer
from flag_sim.protocol.take import Take
from hypothesis import settings, strategies as st
from hypothesis.stateful import initialize, rule, RuleBasedStateMachine
import pytest

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


EVIL = st.floats(0.0, 0.6)
INDEX = st.integers(0, 3 * FRAMES)


class Trouble(RuleBasedStateMachine):
    """Anything may happen at any time in a shot; afterwards it ends."""

    @initialize(seed=st.integers(0, 2**16))
    def begin(self, seed):
        """Start the nodes."""
        self.stage = Stage(seed)
        self.is_plain = True  # nobody interferes, and there is but one take

    @rule(loss=EVIL, doubling=EVIL, longest=st.sampled_from([0.001, 0.3, 3.0]))
    def spoil(self, loss, doubling, longest):
        """Let the network lose, double and hold back messages."""
        network = self.stage.network
        network.loss, network.doubling, network.longest = loss, doubling, longest
        # Two late copies in a row are taken for another round of the take.
        self.is_plain &= longest < RESEND_AFTER and (doubling == 0.0 or longest < TICK)

    @rule(seconds=st.sampled_from([0.01, 0.3, 2.5]))
    def go_on(self, seconds):
        """Let time go by."""
        self.stage.run(seconds)

    @rule(name=st.sampled_from(NAMES))
    def kill(self, name):
        """Kill a node and start it again."""
        self.is_plain &= name in ('physics', 'renderer')
        self.stage.restart(name)

    @rule(times=st.integers(1, 5), seconds=st.sampled_from([0.0, 0.3]))
    def reset(self, times, seconds):
        """Ask for resets, in a row."""
        self.is_plain = False
        for _ in range(times):
            self.stage.wind.reset()
            self.stage.run(seconds)

    @rule(steps=st.integers(0, 20))
    def pause(self, steps):
        """Pause, and ask for many single steps at once."""
        self.stage.wind.is_paused = True
        for _ in range(steps):
            self.stage.wind.requests.steps += 1
            self.stage.wind.fill_window()

    @rule()
    def play(self):
        """Go on after a pause."""
        self.stage.heal()

    @rule(indices=st.lists(INDEX, min_size=1, max_size=80), shift=st.sampled_from([0, 1]))
    def foreign_vertices(self, indices, shift):
        """Vertices of a stranger, at the stamps of frames or beside them."""
        self.is_plain = False
        for index in indices:
            stamp = round(index * 1e9 / 30.0) + shift
            self.stage.network.publish('vertices', stamp, 'stranger')

    @rule(frames=st.lists(st.tuples(INDEX, INDEX), min_size=1, max_size=80),
          take=st.sampled_from([-1, 0, 1, None]), shift=st.sampled_from([0, 1]),
          is_bridged=st.booleans())
    def foreign_parameters(self, frames, take, shift, is_bridged):
        """Parameters of a stranger, or by the same bridge, of any take, index and stamp."""
        self.is_plain = False
        wind = self.stage.wind
        for index, back in frames:
            stamp = round(index * 1e9 / 30.0) + shift
            frame = (FrameId(stamp, None, stamp, stamp) if take is None else
                     FrameId(stamp, wind.number + take, index, max(index - back, 0)))
            self.stage.network.publish(
                'parameters', frame, wind.sender if is_bridged else 'stranger')

    @rule(index=INDEX, name=st.sampled_from(['renderer', 'recorder', 'stranger']))
    def foreign_answer(self, index, name):
        """Somebody says that a frame is done."""
        self.is_plain = False
        self.stage.network.publish('frame_done', (round(index * 1e9 / 30.0), name), 'stranger')

    def teardown(self):
        """See that the shot ends."""
        if hasattr(self, 'stage'):
            self.stage.assert_ends()
            recording = self.stage.recorder.recording
            assert not self.is_plain or (
                self.stage.wind.is_over and recording.in_take == recording.complete == FRAMES)
            # What is missing after the shot is told.
            assert recording.has_all_frames or recording.outstanding or not recording.complete


Trouble.TestCase.settings = settings(max_examples=60, stateful_step_count=15, deadline=None)
TestTrouble = Trouble.TestCase


@pytest.mark.parametrize('name', NAMES)
@pytest.mark.parametrize('when', [0.0, 0.02, 60.0])
def test_a_node_that_is_killed_and_started_again_holds_up_no_take(name, when):
    """Before, during and after the shot; with the wind the shot begins anew."""
    stage = Stage()
    stage.network.longest = 0.01
    stage.run(when)
    stage.restart(name)
    stage.assert_ends()
    is_whole = name != 'recorder' or when == 0.0
    assert stage.recorder.recording.has_all_frames == is_whole
    if not is_whole and when < 60.0:
        assert stage.recorder.recording.outstanding > 0  # which its log tells


@pytest.mark.parametrize('order', list(itertools.permutations(NAMES)), ids='-'.join)
def test_nodes_that_start_in_any_order_make_a_whole_take(order):
    """Each while those before it wait, or go on; none that is waited for misses a frame."""
    stage = Stage()
    stage.wind.is_over = True
    for name in order:
        stage.network.leave(name)
    for name in order:
        stage.restart(name)
        stage.run(1.3)
    stage.assert_ends()
    assert stage.recorder.recording.in_take == stage.recorder.recording.complete == FRAMES


def test_steps_of_a_paused_wind_respect_the_window():
    """They leave as frames are done, and none is forgotten."""
    stage = Stage()
    stage.wind.is_paused = True
    for _ in range(8):
        stage.wind.requests.steps += 1
        stage.wind.fill_window()
    stage.run(5.0)
    assert stage.wind.take.clock.index == 8 and not len(stage.wind.in_flight)


def test_resets_in_a_row_do_not_put_one_another_off():
    """Although a frame in flight is lost and nobody will answer it."""
    stage = Stage()
    stage.network.loss = 1.0
    stage.run(0.1)
    first = stage.wind.number
    for _ in range(10):
        stage.wind.reset()
        stage.run(0.3)
    assert stage.wind.number > first


def test_a_reset_in_mid_shot_gives_the_recorder_a_whole_take():
    """What it had of the take before does not count."""
    stage = Stage()
    stage.network.longest = 0.05
    stage.run(0.5)
    assert 0 < stage.recorder.recording.in_take < FRAMES
    stage.wind.reset()
    stage.assert_ends()
    assert stage.recorder.recording.in_take == FRAMES < stage.recorder.recording.complete


def test_vertices_of_the_future_hold_up_no_take():
    """More of them than the renderer keeps."""
    stage = Stage()
    for index in range(8):
        stage.network.publish('vertices', 10**12 + index, 'stranger')
    stage.assert_ends()
    assert stage.recorder.recording.in_take == FRAMES


def test_parameters_of_the_future_hold_up_no_take():
    """More of them than anybody keeps, by the wind's own name, as through a bridge."""
    stage = Stage()
    stage.network.longest = 0.05
    stage.run(0.2)
    for index in range(100, 200):
        stage.network.publish('parameters', FrameId(index * 10**8, stage.wind.number, index, 0),
                              stage.wind.sender)
    stage.assert_ends()


def test_a_frame_that_was_passed_over_for_a_stranger_is_served_in_the_end():
    """Its sender asks for it again and again, and sends nothing else."""
    stage = Stage()
    stage.network.longest = 0.05
    stage.run(0.2)
    index = stage.wind.in_flight.oldest.frame.index + 2
    stage.network.publish('parameters', FrameId(7, stage.wind.number, index, index),
                          stage.wind.sender)
    stage.assert_ends()


def test_frames_of_a_stranger_without_a_take_do_not_fill_the_recording():
    """Else it ends before the wind's last one, which would wait for ever."""
    stage = Stage()
    for stamp in (10**12, 0):
        stage.network.publish('parameters', FrameId(stamp, None, stamp, stamp), 'stranger')
    stage.assert_ends()
    assert stage.wind.is_over and stage.recorder.recording.in_take == FRAMES
