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

"""Delivery: a frame is sent until every node that is waited for has said that it is done."""
import time

from flag_sim.protocol.in_flight import FramesInFlight
from flag_sim.ros.messages import to_stamp
from flag_sim.ros.topics import publishers, subscribe
from rclpy.exceptions import InvalidNodeNameException
from rclpy.validate_node_name import validate_node_name

FIRST_RESEND = 0.2  # while nobody has ever answered, the graph is still coming together [s]
COMPLAIN_AGAIN = 5.0  # between complaints of one frame [s]
# What a frame needs on its way or where it comes from: none of them says `frame_done`.
SILENT = ('wind', 'physics', 'player')


def check_delivery(values):
    """Raise ValueError if frames sent by the parameters `values` would never be done."""
    if values['pace'] == 'lockstep' and not values['wait_for']:
        raise ValueError('pace lockstep needs at least one node in wait_for')
    for name in values['wait_for']:
        if name in SILENT:
            raise ValueError('wait_for must name nodes that send frame_done: renderer, recorder '
                             f'or your own; {name} sends none')
        try:
            validate_node_name(name)
        except InvalidNodeNameException:
            raise ValueError('wait_for must name nodes by letters, digits and _, without their '
                             f"namespace, not '{name}'") from None


class Delivery(FramesInFlight):
    """
    The frames in flight of a node that sends frames.

    node: has the parameter resend_after. send_again(sent): sends a frame in flight once more.
    on_done(): called when all have done a frame. answered: whether that has ever happened.
    """

    def __init__(self, node, send_again, on_done):
        super().__init__()
        self.answered = False
        self.resent = 0
        self._node = node
        self._send_again = send_again
        self._on_done = on_done
        # Steady time since which frames are in flight and nobody has answered any [s], or None.
        self._silent_since = None
        self._complaint = None, 0.0  # stamp of the frame last complained of, and when [s]
        subscribe(node, 'frame_done', self._on_frame_done)

    def send(self, frame, message, consumers, now):
        """Note that a frame was sent, as FramesInFlight does."""
        super().send(frame, message, consumers, now)
        if len(self) and self._silent_since is None:
            self._silent_since = now

    def clear(self):
        """Forget every frame."""
        super().clear()
        self._silent_since = None

    def _on_frame_done(self, message):
        stamp = to_stamp(message.stamp)
        given_up = stamp not in self
        is_done = self.done(stamp, message.frame_id)
        if is_done or given_up:
            self._silent_since = time.monotonic() if len(self) else None
        if is_done:
            self.answered = True
            if stamp == self._complaint[0]:
                self._node.get_logger().info(f'the frame at {stamp / 1e9:.3f} s is done')
            self._on_done()

    def resend(self, now):
        """Send the oldest frame again, at steady time `now` [s], if it is overdue."""
        after = self._node.values['resend_after']
        sent = self.overdue(now, after if self.answered else min(FIRST_RESEND, after))
        if sent is None:
            return
        self._send_again(sent)
        sent.last_time = now
        self.resent += 1
        if self.late(now):
            self._complain(sent, now)

    def late(self, now):
        """
        Return who has answered no frame for longer than `resend_after`, in words.

        Frames that left while another one was waited for are not late for that.
        """
        sent = self.oldest
        if sent is None or now - self._silent_since <= self._node.values['resend_after']:
            return ''
        return ', '.join(self._how(name) for name in sorted(sent.waiting_for))

    def _how(self, name):
        """Return a node's name, with what is known of a node that cannot have answered."""
        if name in publishers(self._node, 'frame_done').split(', '):
            return f'{name} (its log says why)'
        if name in self._node.get_node_names():
            return f'{name} (still starting, its log says why)'
        return f'{name} (no such node is running)'

    def _complain(self, sent, now):
        """Say whom a frame waits for: at once of every new frame, and of the same now and then."""
        stamp, said = self._complaint
        if sent.frame.stamp == stamp and now - said < COMPLAIN_AGAIN:
            return
        self._complaint = sent.frame.stamp, now
        self._node.get_logger().warning(
            f'the frame at {sent.frame.stamp / 1e9:.3f} s is not done: waiting for '
            f'{self.late(now)}; sent again')
