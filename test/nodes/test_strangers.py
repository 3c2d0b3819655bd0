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

"""What strangers send: it makes few and short lines, fills no memory, and silences nobody."""
import gc
import weakref

from flag_sim.protocol.frames import FrameId, FrameOrder
from flag_sim.protocol.throttled_log import MAX_CHARACTERS, MAX_REASONS
from flag_sim.ros import companions, messages
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterEvent, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import Parameter
from rclpy.task import Future
from std_msgs.msg import Header
from support.frames import parameters_message
from support.nodes import hear, made

SENDERS = [{'publisher_gid': {'data': [number] * 16}} for number in range(2)]
pytestmark = pytest.mark.usefixtures('still_log')


def lines_of(capfd):
    """Return the lines that were logged, and check that each is short."""
    lines = capfd.readouterr().err.splitlines()
    assert all(len(line) < MAX_CHARACTERS + 100 for line in lines)
    return lines


def test_two_winds_at_once_make_few_lines(bench, capfd):
    """Each is another sender to the one before: the cloth starts over with every frame."""
    for index in range(1, 300):
        for sender, take in zip(SENDERS, (10, 20)):
            message = parameters_message(
                '/wind', FrameId(10_000_000 * index, take, index, index), (6.0, 2.0, 0.5), {})
            hear(bench.node, 'parameters', message, sender)
    assert len(bench.clouds) == 598
    assert len(lines_of(capfd)) < 10


@pytest.mark.parametrize('value', [
    'x' * 10_000_000, 'a\n[ERROR] physics is on fire\n' * 10_000, '\x1b[31m' * 1_000_000])
def test_a_long_text_makes_one_short_line(bench, capfd, value):
    """In a message, as value and as name, and in a request; it writes no line of its own."""
    lines_of(capfd)
    frame = FrameId(0, 1, 0, 0)
    for keyed in ({'physics.stiffness': value}, {f'physics.{value}': 1.0}):
        assert bench.hear(parameters_message('/x', frame, np.zeros(3), keyed)) is None
    assert len(lines_of(capfd)) == 2
    for name, given in (('stiffness', value), (value, 1.0), ('solver', value)):
        result = bench.put(**{name: given})
        assert not result.successful and len(result.reason) <= MAX_CHARACTERS
        assert result.reason.isprintable()


def test_who_fills_one_topic_with_reasons_silences_no_other(domain, tmp_path, capfd):
    """A broken sender of vertices hides nothing that is said of parameters."""
    with made('renderer', domain, tmp_path, 'width:=32', 'height:=24') as node:
        for word in 'abcdefghijklmnopqrst':
            node.refuse('vertices', ValueError(f'reason {word}'))
        node.refuse('parameters', ValueError('wind must be finite'))
    said = '\n'.join(lines_of(capfd))
    assert said.count('a message on vertices') == MAX_REASONS
    assert 'a message on parameters is refused: wind must be finite' in said


def test_a_bounded_number_of_answers_is_kept(bench):
    """Although a sender says of all its frames that they may be asked for again."""
    for index in range(80):
        bench.hear(parameters_message(
            '/x', FrameId(10**7 * index, 1, index, 0), np.zeros(3), {}))
    assert len(bench.clouds) == 80
    assert len(bench.node._server) == FrameOrder.LONGEST_QUEUE
    assert len(bench.node._server.inputs) == 0


def test_clouds_of_the_future_hold_up_no_frame(domain, tmp_path):
    """More of them than the renderer keeps: each frame is drawn once its own cloud has come."""
    with made('renderer', domain, tmp_path, 'width:=32', 'height:=24') as node:
        served, flat = [], np.zeros((2, 2, 3))
        node.answer = lambda stamp, drawing: served.append(stamp)
        node.count_publishers = lambda topic: 1  # a wind is there
        for second in range(1000, 1008):
            hear(node, 'vertices', messages.cloud_message(second * 10**9, flat, flat), SENDERS[1])
        for index in range(20):
            stamp = index * 10**7
            hear(node, 'parameters', parameters_message(
                '/wind', FrameId(stamp, 1, index, max(index - 2, 0)), np.zeros(3), {}), SENDERS[0])
            hear(node, 'vertices', messages.cloud_message(stamp, flat, flat), SENDERS[0])
            assert served == [n * 10**7 for n in range(index + 1)]


def test_stamps_that_no_answer_can_have_are_refused(bench, capfd):
    """Nanoseconds of more than a second bring a message beyond what a time holds."""
    message = parameters_message('/x', FrameId(0, 1, 0, 0), np.zeros(3), {})
    message.stamp.sec, message.stamp.nanosec = 2**31 - 1, 2**32 - 1
    assert bench.hear(message) is None
    assert 'its stamp of 2147483647 s and 4294967295 ns is beyond' in capfd.readouterr().err


# The wind.

TRACK = {'keys.wind.speed.times': [0.0, 1.0], 'keys.wind.speed.values': [1.0, 2.0],
         'tracks': ['wind.speed']}


def put(node, **values):
    """Set parameters at once."""
    result = node.set_parameters_atomically(
        [Parameter(name.replace('__', '.'), value=value) for name, value in values.items()])
    assert result.successful, result.reason


def test_an_edited_track_leaves_no_old_copy(domain, tmp_path):
    """Nor its timeline, and not until some garbage collection: a million keys take 200 MB."""
    with made('wind', domain, tmp_path, 'paused:=true') as node:
        put(node, **TRACK)
        gc.collect()
        gc.disable()
        try:
            for speed in (3.0, 4.0, 5.0):
                old = [weakref.ref(node.timeline), weakref.ref(node.timeline.tracks['wind.speed'])]
                put(node, keys__wind__speed__values=[1.0, speed])
                assert [one() for one in old] == [None, None]
        finally:
            gc.enable()
        other = node.timeline.tracks['wind.speed']
        put(node, tracks=['wind.speed', 'wind.azimuth'], keys__wind__azimuth__times=[0.0],
            keys__wind__azimuth__values=[1.0])
        assert node.timeline.tracks['wind.speed'] is other  # it is not made again
        put(node, tracks=[])
        assert not node._made


def test_a_frame_announces_a_bounded_number_of_keys(domain, tmp_path):
    """A loop of a millisecond at a frame in a hundred seconds goes through 100,000 rounds."""
    with made('wind', domain, tmp_path, 'paused:=true', 'rate:=0.01', 'loop:=true') as node:
        names = [f'e{n}' for n in range(50)]
        put(node, events__names=names, events__times=[0.001 * n / 49 for n in range(50)])
        told = []
        node._keyframe_out.publish = lambda key: told.append(key) or True
        for _ in range(2):
            node._on_step(None)
        assert len(told) < 10_000 and node._take.clock.index == 2


def test_strangers_that_say_done_hide_nobody_who_is_late(domain, tmp_path):
    """Only those that are waited for are heard."""
    with made('wind', domain, tmp_path, 'pace:=lockstep', 'resend_after:=0.05') as node:
        node._on_timer()
        delivery, begin = node._delivery, node._delivery.oldest.first_time
        for consumer in ('stranger', ''):
            assert not delivery.done(0, consumer, begin + 1.0)
            assert not delivery.done(123, consumer, begin + 1.0)
        assert delivery.late(begin + 1.1, 0.5) == ['renderer']
        hear(node, 'frame_done', Header(frame_id='renderer'))
        assert delivery.answered


class Asked:
    """A client of a node that never answers."""

    def __init__(self):
        self.pending = []

    def service_is_ready(self):
        """Return that it is."""
        return True

    def call_async(self, request):
        """Return what is never done."""
        assert isinstance(request, GetParameters.Request)
        self.pending.append(Future())
        return self.pending[-1]

    def remove_pending_request(self, future):
        """Forget what was asked."""
        self.pending.remove(future)


def test_companions_and_what_they_are_asked_have_a_bound(domain, tmp_path, monkeypatch):
    """Anybody can be called physics, in as many namespaces as there are."""
    present = {f'/n{n}/physics': bytes([n]) for n in range(100)}
    monkeypatch.setattr(companions, 'subscribers', lambda node, name: present)
    with made('wind', domain, tmp_path, 'paused:=true') as node:
        monkeypatch.setattr(node, 'create_client', lambda *_: Asked())
        monkeypatch.setattr(node, 'destroy_client', lambda _: True)
        found = node.companions
        for _ in range(50):
            found.look()
        assert len(found._found) == len(found._clients) == companions.MAX_COMPANIONS
        assert all(len(client.pending) == 1 for client in found._clients.values())
        present.clear()  # those that are gone make room
        present['/other/physics'] = b'x'
        found.look()
        assert '/other/physics' in found._found
        assert len(found._clients) <= companions.MAX_COMPANIONS
        answer = GetParameters.Response(values=[ParameterValue(type=77)] * 3)
        found._learn('/other/physics', companions.NODES['physics'], answer, 0)
        assert '/other/physics' in found._answered


def test_an_event_with_many_changes_is_one_change(domain, tmp_path, capfd):
    """Of each parameter the last one counts; what makes no key is told once."""
    with made('wind', domain, tmp_path, 'paused:=true', 'autokey:=true') as node:
        for _ in range(9):
            node._on_step(None)
        changes = [ParameterMessage(name='gravity', value=ParameterValue(
            type=3, double_value=float(n % 19))) for n in range(10_000)]
        node.companions._on_event(ParameterEvent(node='/physics', changed_parameters=changes))
        assert node.values['keys.physics.gravity.values'] == [9.81, 9999.0 % 19]
        lines_of(capfd)
        for n in range(100):
            node._put_key('physics.gravity', f'no number {n}', 9.81)
    assert sum('no key was made' in line for line in lines_of(capfd)) == 1


def test_two_winds_at_once_make_few_lines_of_a_recorder(domain, tmp_path, capfd):
    """Every frame is of another take than the one before."""
    with made('recorder', domain, tmp_path) as node:
        for index in range(1, 100):
            for sender, take in zip(SENDERS, (10, 20)):
                hear(node, 'parameters', parameters_message(
                    '/wind', FrameId(10_000_000 * index, take, index, index),
                    (6.0, 2.0, 0.5), {}), sender)
        assert sum('another take' in line for line in lines_of(capfd)) <= MAX_REASONS


class Lossy:
    """A publisher in which messages are lost while `is_lossy`."""

    def __init__(self):
        self.is_lossy = True
        self.sent = []

    def publish(self, message):
        """Keep the message, or lose it; return whether it has left."""
        if not self.is_lossy:
            self.sent.append(message)
        return not self.is_lossy

    def get_subscription_count(self):
        """Return that somebody listens."""
        return 1


def test_a_frame_whose_image_has_not_left_is_not_done_until_it_is_asked_for_again(
        domain, tmp_path):
    """In lockstep the wind sends it again, and the answer that was kept leaves then."""
    with made('renderer', domain, tmp_path, 'width:=32', 'height:=24') as node:
        images, done = Lossy(), Lossy()
        done.is_lossy = False
        node._camera_out, node._frame_done_out = {'camera/image_raw': images}, done
        flat = np.zeros((2, 2, 3))
        cloud = messages.cloud_message(0, flat, flat)
        frame = parameters_message('/wind', FrameId(0, 1, 0, 0), np.zeros(3), {})
        hear(node, 'parameters', frame, SENDERS[0])
        hear(node, 'vertices', cloud, SENDERS[0])
        assert not done.sent and not images.sent
        images.is_lossy = False
        hear(node, 'parameters', frame, SENDERS[0])
        assert len(done.sent) == len(images.sent) == 1


def test_a_key_that_could_not_be_announced_is_with_the_next_frame(domain, tmp_path):
    """Once, and with its own stamp."""
    with made('wind', domain, tmp_path, 'paused:=true') as node:
        put(node, **TRACK)
        node._keyframe_out = keys = Lossy()
        node._on_step(None)
        keys.is_lossy = False
        for _ in range(3):
            node._on_step(None)
        assert [(key.stamp.sec, key.frame_id) for key in keys.sent] == [(0, 'wind.speed')]
