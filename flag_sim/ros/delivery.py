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

"""Delivery: a frame is sent again until every node in `wait_for` has reported it done."""
from collections.abc import Callable, Mapping
import time

from flag_sim.protocol.cdr import serialized_header
from flag_sim.protocol.in_flight import FramesInFlight, Sent
from flag_sim.protocol.throttled_log import Entry
from flag_sim.ros.node_log import NodeLog
from flag_sim.ros.parameter_node import ParameterNode
from flag_sim.ros.topics import publishers, subscribe
from rclpy.exceptions import InvalidNodeNameException
from rclpy.validate_node_name import validate_node_name

WARNING_PERIOD = 5.0
"""How often a warning of the same frame is repeated [s]."""
WITHOUT_FRAME_DONE = ('wind', 'physics', 'player', 'viewer')
"""Nodes that send frames, pass them on or look at them: none publishes `frame_done`."""


def check_delivery(values: Mapping) -> None:
    """Raise ValueError if frames sent by the parameters `values` would never be done."""
    if values['pace'] == 'lockstep' and not values['wait_for']:
        raise ValueError('pace lockstep needs at least one node in wait_for')
    for name in values['wait_for']:
        if name in WITHOUT_FRAME_DONE:
            raise ValueError('wait_for must name nodes that send frame_done: renderer, recorder '
                             f'or your own; {name} sends none')
        try:
            validate_node_name(name)
        except InvalidNodeNameException:
            raise ValueError('wait_for must name nodes by letters, digits and _, without their '
                             f"namespace, not '{name}'") from None


class Delivery(FramesInFlight):
    """
    The frames in flight of a node that sends frames and subscribes to `frame_done`.

    node: has the parameter resend_after. send_again(sent): sends a frame in flight again.
    on_done(): called when a frame is done by all nodes in `wait_for`.
    """

    def __init__(self, node: ParameterNode, send_again: Callable[[Sent], None],
                 on_done: Callable[[], None]):
        super().__init__()
        self._node = node
        self._log = NodeLog(node)
        self._send_again = send_again
        self._on_done = on_done
        self._warned = None, 0.0  # stamp of the frame that was last waited for, and when [s]
        self._told = None         # stamp of the frame that the log says is not done
        subscribe(node, 'frame_done', self._on_frame_done, raw=True)

    def _on_frame_done(self, data):
        stamp, name = serialized_header(data)
        if not self.done(stamp, name, time.monotonic()):
            return
        if stamp == self._told:
            self._told = None
            self._log.write_end(Entry('info', f'the frame at {stamp / 1e9:.3f} s is done'))
        self._on_done()

    def resend_overdue(self, now: float) -> None:
        """Send the oldest frame again, at steady time `now` [s], if it is overdue."""
        sent = self.resend(now, self._node.values['resend_after'])
        if sent is None:
            return
        self._send_again(sent)
        late = self.late_in_words(now)
        if late:
            self._warn(sent.frame.stamp, late, now)

    def late_in_words(self, now: float) -> str:
        """Return which nodes have answered no frame for `resend_after`, and why, or ''."""
        return ', '.join(map(self._with_state, self.late(now, self._node.values['resend_after'])))

    def _with_state(self, name):
        """Return a node's name, with what is known of a node that has not answered."""
        if name in publishers(self._node, 'frame_done').split(', '):
            return f'{name} (its log says why)'
        if name in self._node.get_node_names():
            return f'{name} (still starting, its log says why)'
        return f'{name} (no such node is running)'

    def _warn(self, stamp, late, now):
        """Warn of a frame that is waited for, at once and then now and then."""
        last, at = self._warned
        if last == stamp and now - at < WARNING_PERIOD:
            return
        self._warned = stamp, now
        reason = f'the frame at {stamp / 1e9:.3f} s is not done: waiting for {late}; sent again'
        if self._log.write_once(Entry('warning', reason)):
            self._told = stamp
