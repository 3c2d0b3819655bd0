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

"""Autokey: what a user sets on any node while a shot plays becomes a key (the source's 1.5)."""
from flag_sim.dials.catalogue import NODES
from flag_sim.nodes import keys
from flag_sim.nodes.parameters import to_parameter
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import qos_profile_parameter_events

LOOK_AGAIN = 0.5  # between attempts to reach the nodes whose values are not known yet [s]


class Autokey:
    """
    Listens to /parameter_events and, while `autokey` is on, keys every change that can be keyed.

    node: the wind; now(): where in the animation it is [s]. A track that begins needs the value
    that its parameter had before, so the nodes are asked once for what they have. Playback sets no
    parameter, so it is never heard here.
    """

    def __init__(self, node, now):
        self._node = node
        self._now = now
        self._known = {f'{node.get_name()}.{name}': value for name, value in node.values.items()}
        self._clients = {name: AsyncParameterClient(node, name)
                         for name in ('physics', 'renderer')}
        node.create_subscription(ParameterEvent, '/parameter_events', self._on_event,
                                 qos_profile_parameter_events)
        self._timer = node.create_timer(LOOK_AGAIN, self._ask)

    def _ask(self):
        """Ask each node that has come up for its values, once."""
        for name, client in list(self._clients.items()):
            if client.services_are_ready():
                names = [dial.name for dial in NODES[name]]
                future = client.get_parameters(names)
                future.add_done_callback(
                    lambda done, name=name, names=names: self._learn(name, names, done.result()))
                del self._clients[name]
        if not self._clients:
            self._timer.cancel()

    def _learn(self, node, names, answer):
        for name, value in zip(names, answer.values):
            self._known.setdefault(f'{node}.{name}', parameter_value_to_python(value))

    def _on_event(self, event):
        namespace, _, node = event.node.rpartition('/')
        if (namespace or '/') != self._node.get_namespace() or node not in NODES:
            return
        for parameter in event.changed_parameters:
            track = f'{node}.{parameter.name}'
            try:
                dial = keys.target_dial(track)
                value = parameter_value_to_python(parameter.value)
            except ValueError:
                continue  # keys themselves, and what no track can animate
            except RuntimeError:
                continue  # a value of a type that ROS does not know, which anybody can publish
            old = self._known.get(track, dial.default)
            self._known[track] = value
            if self._node.values['autokey']:
                self._put_key(track, value, old)

    def _put_key(self, track, value, old):
        """Make a key of what a user has set; the wind checks the track that comes out of it."""
        values = self._node.values
        try:
            changes = keys.with_key(values, track, self._now(), value, old, 0.5 / values['rate'])
        except ValueError as error:
            self._node.get_logger().warning(f'no key is made: {error}')
            return
        if changes:
            result = self._node.set_parameters_atomically(
                [to_parameter(name, new) for name, new in changes.items()])
            if not result.successful:
                self._node.get_logger().warning(f'no key is made: {result.reason}')
