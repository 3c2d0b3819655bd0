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

"""Which parameters are asked for when: one request a node at a time, the latest values next."""
import collections
from collections.abc import Callable, Mapping
import dataclasses
import itertools


@dataclasses.dataclass
class _Group:
    values: dict
    together: bool
    on_answer: Callable


class Requests:
    """
    Sends changes of parameters so that a fast hand never makes a queue.

    send(token, node, values, together): sends them; its answer is handed to `answered`. While a
    node has not answered, what is set one by one waits, and of each parameter only its latest
    value; what is set together waits in its turn, whole.
    """

    def __init__(self, send: Callable[[int, str, dict, bool], None]):
        self._send = send
        self._tokens = itertools.count(1)
        self._under_way = {}  # {token: (node, group)}
        self._waiting = collections.defaultdict(collections.deque)  # {node: groups}

    def put(self, node: str, values: Mapping, on_answer: Callable[[dict], None]) -> None:
        """
        Set parameters {name: value}, each by itself.

        on_answer: called with {name: why it was refused, or ''} of what was sent at last; where
        others wait already, only the last call's is.
        """
        waiting = self._waiting[node]
        if waiting and not waiting[-1].together and waiting[-1].on_answer == on_answer:
            waiting[-1].values.update(values)
        else:
            waiting.append(_Group(dict(values), False, on_answer))
        self._send_next(node)

    def put_together(self, node: str, values: Mapping,
                     on_answer: Callable[[dict], None]) -> None:
        """Set all of the parameters {name: value, None to delete} or none."""
        self._waiting[node].append(_Group(dict(values), True, on_answer))
        self._send_next(node)

    def answered(self, token: int, reasons: Mapping[str, str]) -> None:
        """Take the answer to what was sent; send what has waited for it."""
        if token not in self._under_way:
            return
        node, group = self._under_way.pop(token)
        group.on_answer(dict(reasons))
        self._send_next(node)

    def forget(self, node: str) -> None:
        """Drop what waits for a node that is gone."""
        self._waiting.pop(node, None)

    def is_busy(self, node: str) -> bool:
        """Return whether a node has not answered yet."""
        return any(node == other for other, _ in self._under_way.values())

    def is_waiting(self, node: str) -> bool:
        """Return whether something waits until a node has answered."""
        return bool(self._waiting.get(node))

    def _send_next(self, node):
        waiting = self._waiting.get(node)
        if not waiting or self.is_busy(node):
            return
        group, token = waiting.popleft(), next(self._tokens)
        self._under_way[token] = node, group
        self._send(token, node, group.values, group.together)
