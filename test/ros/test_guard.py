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

"""What ends no node: requests that are no requests, callbacks that raise, a failing middleware."""
import importlib
import random

from flag_sim.declarations.nodes import NODES
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.throttled_log import MAX_CHARACTERS
from flag_sim.ros import guard, messages
from flag_sim.ros.topics import publish
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter as OwnParameter
from rclpy.serialization import serialize_message
from std_msgs.msg import Header
from support.forked import Graph
from support.frames import parameters_message
from support.nodes import call, made
from support.watch import eventually, Watcher

UNKNOWN = ParameterValue(type=10, double_value=1.0)
STRANGE = {
    'unknown type': Parameter(name='rate', value=UNKNOWN),
    'type 255': Parameter(name='rate', value=ParameterValue(type=255)),
    'no name': Parameter(value=UNKNOWN),
    'long name': Parameter(name='x' * 1_000_000, value=UNKNOWN),
    'bytes': Parameter(name='rate', value=ParameterValue(
        type=ParameterType.PARAMETER_BYTE_ARRAY, byte_array_value=[b'a'])),
    'not set': Parameter(name='rate'),
    'long text': Parameter(name='rate', value=ParameterValue(
        type=ParameterType.PARAMETER_STRING, string_value='a\n' * 1_000_000)),
    'time of a simulation as text': Parameter(name='use_sim_time', value=ParameterValue(
        type=ParameterType.PARAMETER_STRING, string_value='yes')),
    'time of a simulation deleted': Parameter(name='use_sim_time'),
}


@pytest.mark.parametrize('name', NODES)
def test_a_malformed_request_is_refused_in_one_short_line(tmp_path, domain, name):
    """Of every node, by both services that set parameters, and what is right beside it is set."""
    with made(name, domain, tmp_path) as node:
        for strange in STRANGE.values():
            for value in (strange, Parameter(name='use_sim_time', value=UNKNOWN)):
                results = call(node, SetParameters.Request(parameters=[value])).results
                results.append(call(node, SetParametersAtomically.Request(
                    parameters=[value])).result)
                for result in results:
                    assert not result.successful
                    assert 0 < len(result.reason) <= MAX_CHARACTERS
                    assert '\n' not in result.reason
        good = OwnParameter('use_sim_time', value=True).to_parameter_msg()
        results = call(node, SetParameters.Request(parameters=[STRANGE['type 255'], good])).results
        assert [result.successful for result in results] == [False, True]


def test_of_two_values_of_a_parameter_the_last_one_is_checked_and_counts(tmp_path, domain):
    """One that deletes it before would else let anything by."""
    with made('wind', domain, tmp_path) as node:
        name = 'keys.wind.speed.times'
        deleted = Parameter(name=name)
        text = OwnParameter(name, value='soon').to_parameter_msg()
        times = OwnParameter(name, value=[0.0, 1.0]).to_parameter_msg()
        assert call(node, SetParametersAtomically.Request(parameters=[times])).result.successful
        result = call(node, SetParametersAtomically.Request(parameters=[deleted, text])).result
        assert not result.successful and 'must be a list' in result.reason
        assert node.values[name] == [0.0, 1.0]
        result = call(node, SetParametersAtomically.Request(parameters=[text, times])).result
        assert result.successful


def test_a_process_answers_an_unknown_type_and_goes_on(tmp_path, domain):
    """Over the network, twice."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('wind', '-p', 'paused:=true')
        client = watcher.node.create_client(SetParameters, '/wind/set_parameters')
        eventually(client.service_is_ready, watcher)
        for _ in range(2):
            future = client.call_async(SetParameters.Request(
                parameters=[Parameter(name='rate', value=UNKNOWN)]))
            eventually(future.done, watcher)
            assert 'no parameter type' in future.result().results[0].reason
        assert graph.end('wind') == 0
        assert 'Traceback' not in graph.log('wind')


def test_bytes_that_are_no_message_stop_no_node(tmp_path, domain):
    """Sent by the middleware as they are, on all that it hears; the next frame is drawn."""
    draw = random.Random(3)
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('renderer', '-p', 'width:=32', '-p', 'height:=24')
        out = {name: watcher.publisher(name) for name in ('parameters', 'vertices')}
        images = watcher.listen('camera/image_raw')
        eventually(lambda: all(one.get_subscription_count() for one in out.values()), watcher)
        flat = np.zeros((2, 2, 3))
        cloud = messages.cloud_message(0, flat, flat)
        good = serialize_message(cloud)
        for _ in range(300):
            data = bytearray(good[:draw.randrange(4, len(good))])
            for _ in range(draw.randrange(4)):
                data[draw.randrange(len(data))] = draw.randrange(256)
            for one in out.values():
                one.publish(bytes(data))
            watcher.spin(0.0)
        frame = parameters_message('/x', FrameId(0, 1, 0, 0), np.zeros(3), {})
        eventually(lambda: out['parameters'].publish(frame) or out['vertices'].publish(cloud)
                   or images, watcher)
        assert graph.end('renderer') == 0
        assert 'Traceback' not in graph.log('renderer')
        told = [line for line in graph.log('renderer').splitlines() if '[renderer]' in line]
        assert len(told) < 30 and max(map(len, told)) < MAX_CHARACTERS + 100


class Failing:
    """A publisher of which the middleware fails so many times."""

    topic_name = '/keyframe'

    def __init__(self, times):
        self.times = times
        self.sent = []

    def publish(self, message):
        """Fail, or keep the message."""
        self.times -= 1
        if self.times >= 0:
            raise RuntimeError('cannot publish data')
        self.sent.append(message)


@pytest.mark.usefixtures('still_log')
def test_a_publish_that_fails_is_told_once_and_raises_nothing(domain, capfd):
    """Whoever publishes learns whether the message has left."""
    with rclpy.init(domain_id=domain):
        node = Node('publishing')
        own = publish(node, 'keyframe')
        failing = Failing(5)
        out = guard.GuardedPublisher(node, failing)
        assert [out.publish(Header()) for _ in range(7)] == [False] * 5 + [True] * 2
        assert len(failing.sent) == 2
        assert own.publish(Header()) and not own.publish('no message')
        assert own.get_subscription_count() == 0
        node.destroy_node()
    said = capfd.readouterr().err
    assert said.count('a message on /keyframe could not be sent: RuntimeError') == 1
    assert said.count('could not be sent: TypeError') == 1


def test_every_publisher_of_the_nodes_is_guarded():
    """None is made but by topics.publish."""
    for name in ('nodes.wind', 'nodes.physics', 'nodes.renderer', 'nodes.recorder',
                 'nodes.player', 'ros.diagnostics', 'ros.delivery', 'ros.companions'):
        source = importlib.import_module(f'flag_sim.{name}').__file__
        with open(source) as file:
            assert 'create_publisher' not in file.read()
