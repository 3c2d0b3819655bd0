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

"""What the window knows of the nodes, and through which it sets their parameters."""
from collections.abc import Callable, Mapping

from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.exchange import Answered, Changed, Described, Found, Reported
from flag_sim.viewer.exchange import Publish, SetParameters
from flag_sim.viewer.requests import Requests

ROLES = ('wind', 'physics', 'renderer')
"""What a node can be in the graph, whatever its name is."""


class GraphModel:
    """
    The nodes by their roles, their parameters, and what they say of themselves.

    ask(request): hands a request to the thread of ROS. Whoever shows something adds a function to
    on_nodes (called with nothing: who is there has changed, or is known at last), on_values (role,
    names: these have another value), on_answer (role, {name: why it was refused, or ''}) or
    on_reports (called with nothing).
    """

    def __init__(self, ask: Callable[[object], None]):
        self._ask = ask
        self._requests = Requests(self._send)
        self._answers = {}     # {full name: what takes the answers to what is set one by one}
        self._asked = {}       # {(node, name): value} that a node has not answered yet
        self._unheard = set()  # of those, of which the node has not told a change since
        self.nodes = {}        # {role: full name}
        self.descriptors = {}  # {full name: {name: Descriptor}}
        self.values = {}       # {full name: {name: value}}
        self.first_values = {}  # the same, when the window met the node
        self.reports = {}      # {full name: Reported}
        self.on_nodes, self.on_values, self.on_answer, self.on_reports = [], [], [], []

    # What is known.

    def is_known(self, role: str) -> bool:
        """Return whether there is a node of that role whose parameters are known."""
        return self.nodes.get(role) in self.descriptors

    def descriptor(self, role: str, name: str) -> Descriptor | None:
        """Return what the role's node tells of a parameter; None if it has none of that name."""
        return self.descriptors.get(self.nodes.get(role), {}).get(name)

    def value(self, role: str, name: str, default: object = None) -> object:
        """Return a parameter's value as its node has told it last."""
        return self.values.get(self.nodes.get(role), {}).get(name, default)

    def wanted(self, role: str, name: str, default: object = None) -> object:
        """Return the value that was asked for, as long as there is no answer; else `value`."""
        return self._asked.get((self.nodes.get(role), name), self.value(role, name, default))

    def first_value(self, role: str, name: str) -> object:
        """Return the value that the parameter had when the window met its node."""
        return self.first_values.get(self.nodes.get(role), {}).get(name)

    def report(self, role: str) -> Reported | None:
        """Return what the role's node has said of itself last."""
        return self.reports.get(self.nodes.get(role))

    def role_of(self, node: str) -> str | None:
        """Return the role of a node by its full name."""
        return next((role for role, name in self.nodes.items() if name == node), None)

    def keyed(self, role: str, name: str) -> bool:
        """Return whether a track plays the parameter, over whatever is set."""
        return f'{role}.{name}' in (self.value('wind', 'tracks') or [])

    # What comes.

    def take(self, news: object) -> None:
        """Take one piece of news from the exchange."""
        if isinstance(news, Found):
            self._take_nodes(news.nodes)
        elif isinstance(news, Described):
            self.descriptors[news.node] = {one.name: one for one in news.descriptors}
            self.values[news.node] = dict(news.values)
            self.first_values.setdefault(news.node, dict(news.values))
            _call(self.on_nodes)
        elif isinstance(news, Changed):
            self._take_change(news)
        elif isinstance(news, Answered):
            self._requests.answered(news.token, news.reasons)
        elif isinstance(news, Reported):
            self.reports[news.node] = news
            _call(self.on_reports)

    def _take_nodes(self, nodes):
        for node in self.nodes.values():
            # Who was started again under the same name tells everything anew.
            for known in (self.descriptors, self.values, self.reports):
                if node not in nodes.values():
                    known.pop(node, None)
            if node not in nodes.values():
                self._requests.forget(node)
        self.nodes = dict(nodes)
        _call(self.on_nodes)

    def _take_change(self, news):
        values = self.values.get(news.node)
        role = self.role_of(news.node)
        if values is None or role is None:
            return
        values.update(news.values)
        for name in news.deleted:
            values.pop(name, None)
        self._unheard -= {(news.node, name) for name in news.values}
        _call(self.on_values, role, {*news.values, *news.deleted})

    # What is asked.

    def put(self, role: str, values: Mapping) -> None:
        """Set parameters {name: value} of the role's node, each by itself."""
        node = self.nodes.get(role)
        if node is None:
            _call(self.on_answer, role, dict.fromkeys(values, f'there is no {role}'))
            return
        self._asked.update({(node, name): value for name, value in values.items()})
        self._unheard |= {(node, name) for name in values}
        self._requests.put(node, values, self._answer_of(node))

    def put_together(self, role: str, values: Mapping,
                     on_answer: Callable[[str], None]) -> None:
        """
        Set all of the parameters {name: value, None to delete} of the role's node, or none.

        on_answer(reason): called once, '' where they are set.
        """
        node = self.nodes.get(role)
        if node is None:
            on_answer(f'there is no {role}')
            return
        self._requests.put_together(node, values, lambda reasons: on_answer(
            next(filter(None, reasons.values()), '')))

    def publish(self, topic: str) -> None:
        """Send an empty message on `reset` or `step`."""
        self._ask(Publish(topic))

    def _answer_of(self, node):
        # One and the same for a node, so that what waits for it is put together.
        return self._answers.setdefault(node, lambda reasons: self._answered(node, reasons))

    def _answered(self, node, reasons):
        if not self._requests.is_waiting(node):
            # The answer may come before the event that tells the change.
            self.values.get(node, {}).update({
                name: value for (of, name), value in self._asked.items()
                if of == node and reasons.get(name) == '' and (of, name) in self._unheard})
            self._asked = {key: value for key, value in self._asked.items() if key[0] != node}
            self._unheard = {key for key in self._unheard if key[0] != node}
        role = self.role_of(node)
        if role is not None:
            _call(self.on_answer, role, reasons)

    def _send(self, token, node, values, together):
        known = self.descriptors.get(node, {})
        self._ask(SetParameters(token, node, values, {
            name: known[name] for name in values if name in known}, together))


def _call(listeners, *arguments):
    for listener in listeners:
        listener(*arguments)
