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

"""The parameters of another node, over the network, from a node that asks and one that answers."""
import time

from flag_sim.declarations.nodes import NODES
from flag_sim.nodes.wind import Wind
from flag_sim.ros import remote_node
from flag_sim.ros.guard import GuardedNode
from flag_sim.ros.parameter_node import _descriptor, to_parameter
from flag_sim.ros.remote_node import RemoteNode, to_descriptor, to_value
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.executors import SingleThreadedExecutor


class Asker:
    """Knows a wind in the same process by its services alone."""

    def __init__(self, domain):
        self._domain = domain
        self.described, self.changed, self.answers = [], [], []

    def __enter__(self):
        """Return self; the wind is there, and nothing is asked yet."""
        self._context = rclpy.init(domain_id=self._domain)
        self._context.__enter__()
        self.wind, self.node = Wind(), GuardedNode('asker')
        self.remote = RemoteNode(
            self.node, '/wind', lambda *told: self.described.append(told),
            lambda *told: self.changed.append(told))
        self.node.create_subscription(
            ParameterEvent, '/parameter_events',
            lambda event: event.node == '/wind' and self.remote.take_event(event), 10)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        return self

    def serve(self):
        """Let the wind answer from now on."""
        self._executor.add_node(self.wind)

    def put(self, values, together=False):
        """Set parameters of the wind."""
        kinds = {one.name: one.kind for one in self.described[-1][0]} if self.described else {}
        self.remote.put(values, kinds, together, self.answers.append)

    def until(self, condition):
        """Let everything happen until the condition holds."""
        end = time.monotonic() + 60.0
        while not condition():
            assert time.monotonic() < end
            self._executor.spin_once(timeout_sec=0.02)
            self.remote.look()

    def __exit__(self, *_):
        """End both nodes."""
        self.remote.close()
        self._executor.shutdown()
        self.wind.close()
        self._context.__exit__(None, None, None)


def test_a_node_is_learnt_followed_and_set(domain):
    with Asker(domain) as asker:
        asker.serve()
        asker.until(lambda: asker.described)
        descriptors, values = asker.described[0]
        assert values['speed'] == 6.0 and values['tracks'] == []
        assert {one.name for one in descriptors} >= set(asker.wind.values)
        asker.put({'speed': 7, 'rate': 5000.0})
        asker.until(lambda: asker.answers)
        assert asker.answers == [{'speed': '', 'rate': 'rate must be a number from 0.01 to 1000 '
                                                       '[Hz], not 5000.0'}]
        asker.until(lambda: ({'speed': 7.0}, ()) in asker.changed)
        keys = {'tracks': ['wind.speed'], 'keys.wind.speed.times': [0.0],
                'keys.wind.speed.values': [1.0]}
        asker.put(keys, together=True)
        asker.until(lambda: len(asker.answers) == 2)
        assert set(asker.answers[1].values()) == {''}
        asker.put({'tracks': [], **dict.fromkeys([*keys][1:])}, together=True)
        asker.until(lambda: len(asker.answers) == 3)
        asker.until(lambda: any(deleted for _, deleted in asker.changed))
        assert 'keys.wind.speed.times' not in asker.wind.values
        asker.put({'tracks': ['x', 'y'], 'speed': 1.0}, together=True)
        asker.until(lambda: len(asker.answers) == 4)
        assert all("'x'" in reason for reason in asker.answers[3].values())
        assert asker.wind.values['speed'] == 7.0  # all or none


def test_a_node_that_does_not_answer_is_given_up_and_asked_again(domain, monkeypatch):
    """Its services are there, and nobody serves them; nothing waits for it."""
    monkeypatch.setattr(remote_node, 'PATIENCE', 0.3)
    with Asker(domain) as asker:
        asker.until(lambda: asker.remote._pending)
        asker.put({'speed': 7.0})
        asker.until(lambda: asker.answers)
        assert asker.answers == [{'speed': '/wind did not answer within 0.3 s'}]
        asker.put({'speed': 8.0})
        asker.remote.close()
        assert len(asker.answers) == 2
    with Asker(domain) as asker:
        asker.until(lambda: asker.remote._pending)
        time.sleep(0.4)
        asker.remote.look()
        monkeypatch.undo()  # on a busy machine an answer may take longer
        asker.serve()
        asker.until(lambda: asker.described)


def test_what_is_heard_while_a_node_is_learnt_is_not_older():
    """An event that comes before the answer counts, though the answer says something else."""
    told = []
    remote = RemoteNode.__new__(RemoteNode)
    remote._on_described = lambda descriptors, values: told.append(values)
    remote._heard, remote._names = {}, None
    values = {'a': 1.0, 'b': 2.0}
    messages = [to_parameter(name, value).to_parameter_msg() for name, value in values.items()]
    event = ParameterEvent(changed_parameters=[to_parameter('a', 5.0).to_parameter_msg()],
                           deleted_parameters=[messages[1]])
    remote.take_event(event)
    remote._finish([*values], [remote_node.ParameterDescriptor() for _ in values],
                   [message.value for message in messages])
    assert told == [{'a': 5.0}]


@pytest.mark.parametrize('node', NODES)
def test_descriptors_tell_what_is_declared(node):
    """Of every parameter of every node: kind, unit, range, choices, length."""
    for one in NODES[node]:
        message = _descriptor(one)
        message.name = one.name
        value = to_parameter(one.name, one.default, one.item).to_parameter_msg().value
        read = to_descriptor(message, value)
        assert (read.name, read.effect, read.unit, read.is_fixed) == (
            one.name, one.effect, one.unit, one.fixed)
        assert read.kind == one.kind.__name__ + 's' * one.is_list
        assert read.length == (one.length if one.is_list else None)
        assert read.choices == (() if one.is_list else tuple(one.choices))
        for found, limit in ((read.low, one.low), (read.high, one.high)):
            assert found == (None if limit is None else pytest.approx(limit, rel=1e-5))


@pytest.mark.parametrize('value, kind, words', [
    ('a', 'float', "'a' is no float"), ([1.0, 'b'], 'floats', 'is no floats'),
    (2 ** 70, 'int', 'is no int'), (2.5, 'int', '2.5 is no int'), (3, 'strs', 'is no strs')])
def test_a_value_of_another_kind_is_refused(value, kind, words):
    with pytest.raises(ValueError, match=words):
        to_value(value, kind)
