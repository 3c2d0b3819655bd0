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
import contextlib
import math
import os
import traceback

from flag_sim.declarations.nodes import NODES
from flag_sim.protocol.frames import FrameOrder
from flag_sim.protocol.throttled_log import MAX_CHARACTERS
from flag_sim.tools.domains import claimed_domain
from hypothesis import given, HealthCheck, Phase, seed, settings, strategies as st
from hypothesis.errors import HypothesisException
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


# What numpy warns of would stand in the log of a node.
pytestmark = pytest.mark.filterwarnings('error::RuntimeWarning')


class Count:
    """
    How many inputs were given to the node, what went wrong, and how many lines it has logged.

    faults: the exceptions with the places where they were raised, each once however often
    hypothesis tries it again.
    """

    def __init__(self, node, capfd):
        self.node = node
        self.inputs = self.lines = 0
        self.faults = set()
        self._capfd = capfd

    @contextlib.contextmanager
    def given(self, inputs):
        """Count inputs that are given in the `with` block, after which the node is as sound."""
        self.inputs += inputs
        try:
            yield
            self.check()
        except HypothesisException:
            raise  # an example that is not one
        except Exception as error:
            where = traceback.extract_tb(error.__traceback__)[-1]
            self.faults.add(f'{type(error).__name__} at {where.filename}:{where.lineno}')
            raise

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


@pytest.fixture(scope='module')
def counts(request):
    """Return the list of all Counts, which are added up in one line at the end of a soak."""
    counts = []
    yield counts
    if SOAK:
        faults = set().union(*(count.faults for count in counts))
        request.config.pluginmanager.get_plugin('terminalreporter').write_line(
            f'\nhostile inputs: {sum(count.inputs for count in counts)} inputs, '
            f'{len(faults)} faults, {sum(count.lines for count in counts)} lines in the logs'
            + ''.join(f'\n{fault}' for fault in sorted(faults)))


@pytest.fixture
def count(node, capfd, counts):
    """Return the Count of a test, which is told at its end."""
    count = Count(node, capfd)
    counts.append(count)
    yield count
    with capfd.disabled():
        if SOAK:
            print(f'\n{os.environ["PYTEST_CURRENT_TEST"]}: {count.inputs} inputs, '
                  f'{len(count.faults)} faults, {count.lines} lines in the log')


def test_sets_of_ten_parameters(node, count):
    """Each is set or refused with a short reason; whatever was set, the next frame is served."""
    @seed(13)
    @GENTLE
    @given(st.data())
    def hold(data):
        parameters = data.draw(parameters_of(node.get_name()))
        with count.given(2 * len(parameters)):
            results = call(node, SetParameters.Request(parameters=parameters)).results
            assert len(results) == len(parameters)
            results.append(call(node, SetParametersAtomically.Request(
                parameters=parameters)).result)
            for result in results:
                assert result.successful or 0 < len(result.reason) <= MAX_CHARACTERS
                assert '\n' not in result.reason
            feed(node, data, 2, [])
    hold()


def test_requests_about_parameters(node, count):
    """Whatever is asked for, there is an answer."""
    @seed(13)
    @GENTLE
    @given(st.lists(TEXTS, max_size=4), st.integers(0, 2**64 - 1))
    def hold(names, depth):
        with count.given(4):
            call(node, GetParameters.Request(names=names))
            call(node, GetParameterTypes.Request(names=names))
            call(node, DescribeParameters.Request(names=names))
            call(node, ListParameters.Request(prefixes=names, depth=depth))
    hold()


def test_messages_crafted_and_mutilated(node, count):
    """On every subscription, from two senders in turn."""
    @seed(13)
    @GENTLE
    @given(st.data())
    def hold(data):
        changes = data.draw(st.lists(CHANGES, max_size=10))
        with count.given(10):
            feed(node, data, 10, changes)
    hold()


def feed(node, data, number, changes):
    """Let messages arrive; those of which there are `changes` with other bytes."""
    for n in range(number):
        subscription = data.draw(st.sampled_from(list(node.subscriptions)))
        if subscription.msg_type not in MESSAGES:
            continue
        message = data.draw(MESSAGES[subscription.msg_type])
        # Drawn before: which bytes are a message hangs on more than the bytes, as on memory.
        sender = data.draw(st.sampled_from(SENDERS))
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
