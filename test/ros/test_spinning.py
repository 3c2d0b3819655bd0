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

"""Spinning: what callbacks raise, and floods, keep no other callback of a node from running."""
import itertools
import threading
import time

from flag_sim.protocol.throttled_log import MAX_CHARACTERS
from flag_sim.ros import intake, spinning
from flag_sim.ros.guard import GuardedNode
from flag_sim.ros.spinning import spin_guarded
import pytest
from rcl_interfaces.srv import GetParameters
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from std_msgs.msg import Header

FALLBACK = 'callbacks are run by the SingleThreadedExecutor'
pytestmark = pytest.mark.usefixtures('still_log')


@pytest.fixture(params=['events', 'single'])
def executor(request, monkeypatch):
    """Let nodes be spun by one executor, and then by the other."""
    if request.param == 'single':
        monkeypatch.setattr(spinning, 'EventsExecutor', None)
    elif spinning.why_no_events():
        pytest.skip(spinning.why_no_events())
    return request.param


@pytest.fixture
def node(domain):
    """Yield a node that is to be spun, in the default context."""
    with rclpy.init(domain_id=domain):
        node = GuardedNode('spun')
        yield node
        node.destroy_node()


def spin(node, is_over, seconds=60.0):
    """Spin a node until something holds; fail if it does not in time."""
    over, end = Future(), time.monotonic() + seconds

    def look():
        if not over.done() and (is_over() or time.monotonic() > end):
            over.set_result(None)
    timer = node.create_timer(0.01, look)
    spin_guarded(node, over)
    node.destroy_timer(timer)
    assert is_over()


def test_what_a_callback_raises_is_told_once_and_the_next_one_runs(executor, node, capfd):
    """With where it was raised, in one short line."""
    called = []

    def raising():
        called.append(len(called))
        raise OverflowError(f'number {len(called)}\n' + 'a' * 10_000_000)
    node.create_timer(0.001, raising)
    spin(node, lambda: len(called) > 20)
    lines = [line for line in capfd.readouterr().err.splitlines() if FALLBACK not in line]
    assert len(lines) == 1 and len(lines[0]) < MAX_CHARACTERS + 100
    assert 'a callback failed, the node goes on: OverflowError (test_spinning.py:' in lines[0]


def test_every_message_is_served_though_all_callbacks_raise(executor, node, capfd):
    """Those too that came at once, in their order, and what is no message is told as such."""
    out = node.create_publisher(Header, 'some', 8)
    heard = []

    def hear(message, info):
        heard.append((int(message.frame_id), len(info['publisher_gid']['data'])))
        raise ValueError('heard')
    node.create_subscription(Header, 'some', hear, 8)
    for n in range(3):
        out.publish(Header(frame_id=str(n)))
    out.publish(b'\0\1\0\0 is no header')
    for n in range(3, 6):
        out.publish(Header(frame_id=str(n)))
    spin(node, lambda: len(heard) >= 6)
    assert [n for n, _ in heard] == list(range(6)) and all(length for _, length in heard)
    said = capfd.readouterr().err
    assert said.count('ValueError') == 2 and '17 bytes on some are no Header' in said
    assert 'Traceback' not in said


def test_what_came_with_a_fault_of_the_executor_itself_is_served(executor, node, capfd):
    """It forgets all else that it was told of at the same time."""
    out = node.create_publisher(Header, 'some', 8)
    heard, asked = [], []

    def fail(what, noted):
        noted.append(what)
        raise RuntimeError('cannot take')
    subscription = node.create_subscription(Header, 'some', lambda _: None, 8)
    service = node.create_service(GetParameters, 'ask', lambda _, response: response)
    # In place of the guarded ones, so that the executor meets what they raise.
    subscription.callback = lambda message, info=None: fail(message, heard)
    service.callback = lambda request, _: fail(request, asked)
    subscription.raw = False
    client = node.create_client(GetParameters, 'ask')
    assert client.wait_for_service(30.0)
    for n in range(5):
        out.publish(Header(frame_id=str(n)))
        client.call_async(GetParameters.Request(names=[str(n)]))
    spin(node, lambda: len(heard) == len(asked) == 5)
    assert [int(message.frame_id) for message in heard] == list(range(5))
    assert [int(request.names[0]) for request in asked] == list(range(5))
    said = capfd.readouterr().err
    assert said.count('a callback failed, the node goes on: RuntimeError') == 1


def test_what_has_event_callbacks_is_not_destroyed_while_the_node_runs(node, capfd):
    """The EventsExecutor would crash, now or later; before and afterwards it can be."""
    if spinning.why_no_events():
        pytest.skip(spinning.why_no_events())
    kept = [node.create_publisher(Header, 'some', 8),
            node.create_subscription(Header, 'some', lambda _: None, 8)]
    destroy = [node.destroy_publisher, node.destroy_subscription]
    timers = [node.create_timer(0.001, lambda one=one, end=end: tried.append(one) or end(one))
              for one, end in zip(kept, destroy)]
    tried = []
    spin(node, lambda: all(one in tried for one in kept))
    assert capfd.readouterr().err.count('cannot be destroyed while') == 1  # a cause is told once
    assert kept[0] in node.publishers and kept[1] in node.subscriptions
    for timer in timers:
        node.destroy_timer(timer)
    assert all(end(one) for one, end in zip(kept, destroy))


def test_a_service_whose_callback_fails_answers(executor, node):
    """With what the response is by default, so that nobody waits forever."""
    def fail(request, response):
        response.values = []
        raise RuntimeError('no answer')
    node.create_service(GetParameters, 'ask', fail)
    client = node.create_client(GetParameters, 'ask')
    assert client.wait_for_service(30.0)
    answers = [client.call_async(GetParameters.Request()) for _ in range(3)]
    spin(node, lambda: all(answer.done() for answer in answers))
    assert all(answer.result() == GetParameters.Response() for answer in answers)


def test_a_message_that_cannot_be_taken_stops_no_other_callback(node, capfd, monkeypatch):
    """Although rclpy leaves its callback, and the group of it, marked as running."""
    monkeypatch.setattr(spinning, 'EventsExecutor', None)
    take, failed, called = SingleThreadedExecutor._take_timer, [], []

    def failing(self, timer):
        if len(failed) < 3:
            failed.append(timer)
            timer.handle.call_timer_with_info()
            raise RuntimeError('cannot take')
        return take(self, timer)
    monkeypatch.setattr(SingleThreadedExecutor, '_take_timer', failing)
    for _ in range(2):
        node.create_timer(0.001, lambda: called.append(1))
    spin(node, lambda: len(called) >= 5)
    assert len(failed) == 3
    assert capfd.readouterr().err.count('RuntimeError (test_spinning.py') == 1


def test_a_context_that_is_shut_down_ends_the_spinning(executor, node):
    """It is no fault of a callback."""
    node.create_timer(0.001, node.context.try_shutdown)
    spin_guarded(node, Future())


def test_a_future_set_by_another_thread_ends_the_spinning(executor, node):
    """Also one that is set before, and while a callback runs; afterwards it hurts nobody."""
    for delay in (None, 0.0, 0.02, 0.1):
        over = Future()
        if delay is None:
            over.set_result(None)
        else:
            threading.Timer(delay, over.set_result, (None,)).start()
        spin_guarded(node, over)
    late = Future()
    spin(node, lambda: True)
    late.set_result(None)


def test_a_mismatch_of_quality_of_service_is_told(executor, node, capfd):
    """By rclpy, whichever executor hands its events on."""
    said = []

    def is_told():
        said.append(capfd.readouterr().err)
        return 'incompatible QoS' in ''.join(said)
    node.create_subscription(Header, 'some', lambda _: None, 8)
    node.create_publisher(Header, 'some', QoSProfile(
        depth=8, reliability=ReliabilityPolicy.BEST_EFFORT))
    spin(node, is_told)


def test_the_fallback_is_told_once(node, capfd, monkeypatch):
    """With the reason."""
    monkeypatch.setattr(spinning, 'EventsExecutor', None)
    spin(node, lambda: True)
    said = capfd.readouterr().err
    assert said.count(FALLBACK) == 1 and 'this rclpy has no EventsExecutor' in said
    monkeypatch.undo()
    monkeypatch.setattr(spinning, 'get_rmw_implementation_identifier', lambda: 'rmw_other')
    spin(node, lambda: True)
    assert 'tested with rmw_fastrtps_cpp only' in capfd.readouterr().err


def test_requests_that_come_at_once_hold_up_no_topic(executor, node):
    """They are answered all the same, in their order."""
    asked, answered, heard = [], [], []

    def answer(request, response):
        answered.append(int(request.names[0]))
        return response
    node.create_service(GetParameters, 'ask', answer)
    client = node.create_client(GetParameters, 'ask')
    out = node.create_publisher(Header, 'some', 8)
    node.create_subscription(
        Header, 'some', lambda _: heard.append(len(asked) - len(answered)), 8)
    assert client.wait_for_service(30.0)

    def ask():
        if max(heard, default=0) <= 1 and len(answered) == len(asked) == 10 * len(heard):
            for _ in range(10):
                client.call_async(GetParameters.Request(names=[str(len(asked))]))
                asked.append(None)
            out.publish(Header())
            time.sleep(0.05)  # so that all have arrived, the message last
    node.create_timer(0.01, ask)
    spin(node, lambda: max(heard, default=0) > 1 and len(answered) == len(asked))
    assert answered == list(range(len(asked)))


def test_a_flood_on_one_topic_holds_up_no_other(executor, domain, monkeypatch):
    """Sent several times as fast as it is served, and the order of what is served stays."""
    monkeypatch.setattr(intake, 'LONGEST_QUEUE', 5_000_000)
    with rclpy.init(domain_id=domain):
        node, sender = GuardedNode('flooded'), Node('flooding')
        flood, other = (sender.create_publisher(Header, name, 8) for name in ('flood', 'other'))
        served, waited, sent = [], [], []
        is_over = threading.Event()

        def serve(message):
            served.append(int(message.frame_id))
            time.sleep(0.002)
        node.create_subscription(Header, 'flood', serve, 8)
        node.create_subscription(Header, 'other', lambda message: waited.append(
            1.0 - int(message.frame_id) / len(sent)), 8)

        def send():
            for n in itertools.count():
                if is_over.is_set():
                    return
                flood.publish(Header(frame_id=str(n)))
                sent.append(n)
                if n % 100 == 0:
                    other.publish(Header(frame_id=str(n)))
                time.sleep(0.0002)
        thread = threading.Thread(target=send)
        thread.start()
        spin(node, lambda: len(waited) > 10)
        is_over.set()
        thread.join()
        # How much of all was sent since: nine tenths where the flood is served first.
        assert sorted(waited[2:9])[3] < 0.5
        assert served == sorted(served)
        sender.destroy_node()
        node.destroy_node()
