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

"""Hostile inputs for every node: it serves the next frame, tells in short, and keeps in bounds."""
import math
import os

from flag_sim.declarations.nodes import NODES
from flag_sim.protocol.frames import FrameOrder
from flag_sim.protocol.throttled_log import MAX_CHARACTERS
from flag_sim.tools.domains import claimed_domain
from hypothesis import given, HealthCheck, Phase, seed, settings, strategies as st
import numpy as np
import pytest
from rcl_interfaces.srv import (
    DescribeParameters, GetParameters, GetParameterTypes, ListParameters, SetParameters,
    SetParametersAtomically)
from support.fuzz import CHANGES, MESSAGES, mutilated, parameters_of, TEXTS
from support.nodes import call, hear, made, unguarded
from support.soak import SOAK

EXAMPLES = 1000 if SOAK else 15
"""Examples a test and node; each is up to ten inputs."""
GENTLE = settings(
    max_examples=EXAMPLES, deadline=None, database=None, derandomize=not SOAK,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.generate, Phase.shrink] if SOAK else [Phase.generate])
SENDERS = [{'publisher_gid': {'data': [number] * 16}} for number in range(2)]
LONGEST_PREFIX = 80
"""Of a line in the log, what stands before the text [characters]."""


class Count:
    """How many inputs were given to the node, and how many lines it has logged."""

    def __init__(self, node, capfd):
        self.node = node
        self.inputs = self.lines = 0
        self._capfd = capfd

    def check(self):
        """Raise AssertionError unless the node is as sound as before."""
        node = self.node
        for name, value in node.values.items():
            numbers = value if isinstance(value, list) else [value]
            assert all(math.isfinite(one) for one in numbers if isinstance(one, float)), name
        for line in self._capfd.readouterr().err.splitlines():
            assert len(line) <= MAX_CHARACTERS + LONGEST_PREFIX, line
            self.lines += line.startswith('[')  # the middleware writes of bytes without it
        server = getattr(node, '_server', None)
        if server is not None:
            assert len(server.order.waiting) <= FrameOrder.LONGEST_QUEUE
            assert len(server.inputs) <= FrameOrder.LONGEST_QUEUE + 1
            assert len(server) <= FrameOrder.LONGEST_QUEUE


@pytest.fixture(scope='module', params=NODES)
def node(request, tmp_path_factory):
    """Return each node in this process; nothing is spun, and nobody else is in its domain."""
    with claimed_domain() as domain, made(
            request.param, domain, tmp_path_factory.mktemp('fuzz'),
            'paused:=true', 'width:=32', 'height:=24', 'grid.rows:=5', 'grid.columns:=6',
            'threads:=1', 'tracks:=[wind.speed]', 'keys.wind.speed.times:=[0.0, 1.0]',
            'keys.wind.speed.values:=[1.0, 2.0]') as one:
        yield one


@pytest.fixture
def count(node, capfd):
    """Return the Count of a test, which is told at its end."""
    count = Count(node, capfd)
    yield count
    with capfd.disabled():
        if SOAK:
            print(f'\n{os.environ["PYTEST_CURRENT_TEST"]}: {count.inputs} inputs, 0 faults, '
                  f'{count.lines} lines in the log')


def test_sets_of_ten_parameters(node, count):
    """Each is set or refused with a short reason; whatever was set, the next frame is served."""
    @seed(13)
    @GENTLE
    @given(st.data())
    def hold(data):
        parameters = data.draw(parameters_of(node.get_name()))
        results = call(node, SetParameters.Request(parameters=parameters)).results
        assert len(results) == len(parameters)
        results.append(call(node, SetParametersAtomically.Request(parameters=parameters)).result)
        for result in results:
            assert result.successful or 0 < len(result.reason) <= MAX_CHARACTERS
            assert '\n' not in result.reason
        count.inputs += 2 * len(parameters)
        feed(node, data, 2, [])
        count.check()
    hold()


def test_requests_about_parameters(node, count):
    """Whatever is asked for, there is an answer."""
    @seed(13)
    @GENTLE
    @given(st.lists(TEXTS, max_size=4), st.integers(0, 2**64 - 1))
    def hold(names, depth):
        call(node, GetParameters.Request(names=names))
        call(node, GetParameterTypes.Request(names=names))
        call(node, DescribeParameters.Request(names=names))
        call(node, ListParameters.Request(prefixes=names, depth=depth))
        count.inputs += 4
        count.check()
    hold()


def test_messages_crafted_and_mutilated(node, count):
    """On every subscription, from two senders in turn."""
    @seed(13)
    @GENTLE
    @given(st.data())
    def hold(data):
        feed(node, data, 10, data.draw(st.lists(CHANGES, max_size=10)))
        count.inputs += 10
        count.check()
    hold()


def feed(node, data, number, changes):
    """Let messages arrive; those of which there are `changes` with other bytes."""
    for n in range(number):
        subscription = data.draw(st.sampled_from(list(node.subscriptions)))
        if subscription.msg_type not in MESSAGES:
            continue
        message = data.draw(MESSAGES[subscription.msg_type])
        if n < len(changes):
            message = mutilated(subscription.msg_type, message, changes[n])
        if message is None:
            continue
        sender = data.draw(st.sampled_from(SENDERS))
        hear(node, subscription.topic_name[1:], message, sender)
    for timer in list(node.timers):
        with unguarded(node):
            timer.callback()


def test_what_physics_sends_is_finite(node):
    """After all of that."""
    if node.get_name() == 'physics':
        for _, cloud in node._server._answers.values():
            assert np.isfinite(np.frombuffer(cloud.data, np.float32)).all()
