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

"""Gathering: what a sender in real time waits for before its first frame."""
from collections.abc import Callable, Iterable
import time

from flag_sim.ros.topics import subscribers
from rclpy.node import Node

LONGEST = 1.0
"""How long the nodes of a graph have to find a sender that has just started [s]."""


class Gathering:
    """
    Whether the nodes are there that a sender's first frame is for.

    Nodes that run already need up to half a second to discover a new one, each its own time. What
    is sent before that is lost to them, and in real time nobody sends it again: the cloth would
    begin in the midst of a shot, and a short bag would be over before anybody saw it. So a sender
    begins once all are there, or LONGEST after its start with those that are.

    node: the sender, which publishes `topic` of `topics.TOPICS`; names: of the nodes that are
    waited for, without their namespaces; None: any one is. then(): called once, when it is over,
    for what would take too long between two frames.
    """

    def __init__(self, node: Node, topic: str, names: Iterable[str] | None,
                 then: Callable[[], None] = lambda: None):
        self._node = node
        self._topic = topic
        self._names = names
        self._then = then
        self._deadline = time.monotonic() + LONGEST
        self._is_over = False

    def is_over(self, now: float) -> bool:
        """Return whether to begin at steady time `now` [s]; say who is not there by then."""
        if not self._is_over:
            present = {name.rpartition('/')[2] for name in subscribers(self._node, self._topic)}
            absent = sorted(set(self._names or ()) - present)
            is_met = bool(present) if self._names is None else not absent
            self._is_over = is_met or now >= self._deadline
            if self._is_over and absent:
                self._node.get_logger().info(
                    f'begins without {", ".join(absent)}: no node of this name subscribes to '
                    f'{self._node.resolve_topic_name(self._topic)} yet')
            if self._is_over:
                self._then()
        return self._is_over
