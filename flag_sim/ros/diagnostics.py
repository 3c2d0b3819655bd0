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

"""Diagnostics on `state`: how a node is doing, published while there is a subscriber."""
from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from flag_sim.protocol.stopwatch import Stopwatch
from flag_sim.ros.topics import publish
from rclpy.node import Node

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
PERIOD = 1.0
"""How often a message is published [s]."""


class Diagnostics:
    """
    Publishes a DiagnosticArray on `state` every second while there is a subscriber.

    status(): returns the level, a message, and {name with unit: value} for the node's users.
    """

    def __init__(self, node: Node, status: Callable[[], tuple[bytes, str, dict]]):
        self._node = node
        self._status = status
        self._out = publish(node, 'state')
        self._timer = node.create_timer(PERIOD, self._publish)

    def _publish(self):
        if not self._out.get_subscription_count():
            return
        level, message, values = self._status()
        message = DiagnosticArray(status=[DiagnosticStatus(
            level=level, name=self._node.get_fully_qualified_name(), message=message,
            hardware_id='none', values=[KeyValue(key=key, value=_words(value))
                                        for key, value in values.items()])])
        # Diagnostics have the node's own time: they are about now, not about a frame.
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._out.publish(message)


def _words(value):
    return f'{value:.6g}' if isinstance(value, float) else str(value)


def compute_time(stopwatch: Stopwatch) -> dict:
    """Return how long a frame's work took on average since the last time, as {name: value}."""
    spent = stopwatch.lap()
    return {'compute time per frame [ms]': 'no frame' if spent is None else 1e3 * spent}
