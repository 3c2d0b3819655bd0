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

"""Companions: the physics and renderer nodes of a wind, and their parameters' values."""
from collections.abc import Callable, Mapping
import contextlib
import time
from typing import NamedTuple

from flag_sim.declarations.nodes import defaults, named, NODES, own_values
from flag_sim.ros.messages import to_stamp
from flag_sim.ros.parameter_node import ParameterNode
from flag_sim.ros.topics import subscribers
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events

POLL_PERIOD = 0.5
"""How often to check which nodes are there [s]."""
CHECKS_PER_REQUEST = 4
"""After how many checks a node that has not answered is asked again."""
MAX_COMPANIONS = 16
"""Nodes of which the parameters are known; more than these are not asked."""
COMPANIONS = ('physics', 'renderer')
"""Names of the nodes that are companions, in any namespace."""
LONGEST_DELAY = 5_000_000_000
"""By how much an event may come later than an answer to a question after it [ns]."""


class Learnt(NamedTuple):
    """The names of values that are known from an answer alone, and when it was made [ns]."""

    names: set[str]
    asked: int
    answered: int

    def may_hold(self, name: str, stamp: int) -> bool:
        """Return whether the answer may hold a change that was made at `stamp` [ns] already."""
        return name in self.names and self.asked - LONGEST_DELAY <= stamp <= self.answered


class Companions:
    """
    Knows the parameters of every physics and renderer that subscribes to `parameters`.

    Each is asked for them when it is found, in any namespace; from then on its changes are
    followed on /parameter_events.

    node: the wind. on_answer(name): called when a node, by its full name, has sent its values.
    on_change(changes): called with every change on a companion or the wind itself, as
    [(kind, name, value, old)]; old is the parameter's default where it is not known: an answer may
    come before the event of a change that it holds already.
    """

    def __init__(self, node: ParameterNode, on_answer: Callable[[str], None],
                 on_change: Callable[[list], None]):
        self._node = node
        self._on_answer = on_answer
        self._on_change = on_change
        self._own_name = node.get_fully_qualified_name()
        self._known = {self._own_name: dict(node.values)}  # {node: {name: value}}
        self._found = {}  # the endpoint of each node that was found, which a restart renews
        self._asked = {}  # in which look each node was asked last
        self._pending = {}  # what each node was asked and has not answered
        self._learnt = {}  # of each node that has answered and not said of all its changes
        self._answered = set()
        self._clients = {}
        self._looks = 0
        node.create_subscription(ParameterEvent, '/parameter_events', self._on_event,
                                 qos_profile_parameter_events)
        node.create_timer(POLL_PERIOD, self.look)

    def look(self) -> None:
        """Find the nodes that are there, and ask those that have not sent their values."""
        self._looks += 1
        present = subscribers(self._node, 'parameters')
        for name, endpoint in present.items():
            if _base_name(name) in COMPANIONS and self._found.get(name) != endpoint:
                if not self._has_room(name, present):
                    continue
                if name in self._found:
                    self._known[name] = {}
                    self._learnt.pop(name, None)
                self._found[name] = endpoint
                self._asked.pop(name, None)
                self._answered.discard(name)
        for name in self._found.keys() - self._answered:
            if self._looks - self._asked.get(name, -CHECKS_PER_REQUEST) >= CHECKS_PER_REQUEST:
                self._ask(name)

    def _has_room(self, name, present):
        """Return whether a node can be known, for which one that is gone is forgotten."""
        gone = [other for other in self._found if other not in present]
        if name not in self._found and len(self._found) >= MAX_COMPANIONS and gone:
            self._forget(gone[0])
        return name in self._found or len(self._found) < MAX_COMPANIONS

    def _forget(self, node):
        for noted in (self._found, self._known, self._asked, self._pending, self._learnt):
            noted.pop(node, None)
        self._answered.discard(node)
        if node in self._clients:
            self._node.destroy_client(self._clients.pop(node))

    def _ask(self, node):
        if node not in self._clients:
            self._clients[node] = self._node.create_client(GetParameters, f'{node}/get_parameters')
        if not self._clients[node].service_is_ready():
            return
        self._asked[node] = self._looks
        declarations = NODES[_base_name(node)]
        if node in self._pending:  # rclpy keeps it for ever else
            self._clients[node].remove_pending_request(self._pending[node])
        future = self._pending[node] = self._clients[node].call_async(
            GetParameters.Request(names=[declaration.name for declaration in declarations]))
        asked = time.time_ns()
        future.add_done_callback(self._node.guarded(
            lambda done: self._learn(node, declarations, done.result(), asked)))

    def _learn(self, node, declarations, answer, asked):
        if node not in self._found:
            return  # it was forgotten meanwhile
        self._pending.pop(node, None)
        known = self._known.setdefault(node, {})
        learnt = self._learnt[node] = Learnt(set(), asked, time.time_ns())
        for declaration, value in zip(declarations, answer.values):
            # What was heard meanwhile is not older than the answer.
            if declaration.name not in known:
                learnt.names.add(declaration.name)
                with contextlib.suppress(RuntimeError):  # a type that ROS does not know
                    _keep(known, declaration, parameter_value_to_python(value))
        self._answered.add(node)
        self._on_answer(node)

    def _on_event(self, event):
        kind = 'wind' if event.node == self._own_name else _base_name(event.node)
        is_near = kind in COMPANIONS and _namespace(event.node) == _namespace(self._own_name)
        if not (event.node in self._known or is_near):
            return
        known = self._known.setdefault(event.node, {})
        declarations = named(kind)
        learnt, stamp = self._learnt.get(event.node), to_stamp(event.stamp)
        changes = []
        # Of many changes of one parameter the last one counts.
        for parameter in {one.name: one for one in event.changed_parameters}.values():
            declaration = declarations.get(parameter.name)
            try:
                value = parameter_value_to_python(parameter.value)
            except RuntimeError:
                continue  # a value of a type that ROS does not know
            if declaration is not None:
                old = known.get(declaration.name, declaration.default)
                if learnt and learnt.may_hold(declaration.name, stamp) and old == value:
                    old = declaration.default  # what it was before the answer is not known
                changes.append((kind, declaration.name, value, old))
                _keep(known, declaration, value)
                if learnt:
                    learnt.names.discard(declaration.name)
        if changes:
            self._on_change(changes)

    def settings(self, keyed: Mapping) -> tuple[dict[str, dict], list[str]]:
        """
        Return {node: {name: value}} of what is not at its default, and what is lacking, in words.

        keyed: {track: value} at the shot's first frame: a parameter that is keyed has that value.
        """
        settings = {}
        for node in sorted(self._answered):
            kind, settings[node] = _base_name(node), {}
            own = own_values(kind, keyed)
            for name, default in defaults(kind).items():
                value = own.get(name, self._known[node].get(name))
                if value not in (None, default):
                    settings[node][name] = value
        lacking = [f'{node} did not answer' for node in sorted(self._found.keys()
                                                               - self._answered)]
        lacking += [f'no {kind} was found' for kind in COMPANIONS
                    if kind not in map(_base_name, self._found)]
        return settings, lacking


def _keep(known, declaration, value):
    """Note a value if the parameter can have it; a foreign node may have the same name."""
    with contextlib.suppress(ValueError):
        known[declaration.name] = declaration.accept(value)


def _base_name(node):
    """Return the name of a node without its namespace; nodes are named as executables."""
    return node.rpartition('/')[2]


def _namespace(node):
    """Return the namespace of a node by its full name."""
    return node.rpartition('/')[0]
