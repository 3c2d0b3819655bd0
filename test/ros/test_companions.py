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

"""What the wind knows of its companions' parameters, in whatever order it hears of them."""
import time
from types import SimpleNamespace

from flag_sim.declarations.nodes import defaults, NODES
from flag_sim.ros.companions import Companions
from flag_sim.ros.messages import to_time
from flag_sim.ros.parameter_node import to_parameter
import pytest
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy.task import Future


class Network:
    """Stands in for the wind's node, and for what it hears and asks."""

    values = {}

    def __init__(self):
        self.questions = []

    def get_fully_qualified_name(self):
        return '/wind'

    def guarded(self, callback):
        return callback

    def resolve_topic_name(self, name):
        return f'/{name}'

    def get_subscriptions_info_by_topic(self, _):
        return [SimpleNamespace(node_namespace='/', node_name='physics', endpoint_gid=[1])]

    def create_subscription(self, _, topic, callback, profile):
        assert topic == '/parameter_events'
        self.hear = callback

    def create_timer(self, _, callback):
        self.look = callback

    def create_client(self, _, name):
        assert name == '/physics/get_parameters'
        return SimpleNamespace(service_is_ready=lambda: True, call_async=self.ask)

    def ask(self, request):
        self.questions.append((request, Future()))
        return self.questions[-1][1]

    def answer(self, **changed):
        """Let physics answer the last question."""
        values = {**defaults('physics'), **changed}
        items = {declaration.name: declaration.item for declaration in NODES['physics']}
        request, future = self.questions[-1]
        future.set_result(GetParameters.Response(values=[
            to_parameter(name, values[name], items[name]).get_parameter_value()
            for name in request.names]))

    def change(self, name, value, at):
        """Let physics say that a parameter was set at a time of its clock [ns]."""
        self.hear(ParameterEvent(
            node='/physics', stamp=to_time(at),
            changed_parameters=[to_parameter(name, value).to_parameter_msg()]))


@pytest.fixture
def network():
    """Return a network on which a wind follows its companions' `changes`."""
    network = Network()
    network.changes = []
    Companions(network, lambda name: None, network.changes.extend)
    network.look()
    return network


def test_an_answer_that_holds_a_change_does_not_hide_it(network):
    """The change was made before the answer, but its event comes after it: there is a change."""
    made = time.time_ns()
    network.answer(gravity=1.5)
    network.change('gravity', 1.5, made)
    network.change('gravity', 1.5, made)  # set twice: from here on it is known
    assert network.changes == [('physics', 'gravity', 1.5, 9.81), ('physics', 'gravity', 1.5, 1.5)]


@pytest.mark.parametrize('at', [lambda: time.time_ns() + 1, lambda: 10**9], ids=['wall', 'sim'])
def test_what_is_set_after_an_answer_to_what_it_says_is_no_change(network, at):
    """By a wall clock; and a node that runs by simulation time is not thought to be late."""
    network.answer(gravity=1.5)
    network.change('gravity', 1.5, at())
    network.change('gravity', 2.5, at())
    assert network.changes == [('physics', 'gravity', 1.5, 1.5), ('physics', 'gravity', 2.5, 1.5)]


def test_what_was_heard_before_an_answer_is_newer_than_it(network):
    """It was on its way while the parameter was set."""
    made = time.time_ns()
    network.change('gravity', 1.5, made)
    network.answer()
    network.change('gravity', 2.5, made)
    assert network.changes == [('physics', 'gravity', 1.5, 9.81), ('physics', 'gravity', 2.5, 1.5)]
