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

"""The player node: publishes the messages of a bag, by the clock or in lockstep."""
from collections.abc import Mapping, Sequence
import sys
import time

from flag_sim.declarations.player import PLAYER
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.recorded_frames import recorded_frames
from flag_sim.ros.bag import RecordedTopics
from flag_sim.ros.delivery import check_delivery, Delivery
from flag_sim.ros.frame_message import as_oldest
from flag_sim.ros.gathering import Gathering
from flag_sim.ros.lifecycle import run
from flag_sim.ros.node_log import NodeLog
from flag_sim.ros.parameter_node import BadParameter, ParameterNode
from flag_sim.ros.topics import publish, TOPICS

POLL_PERIOD = 0.05
"""How often lockstep checks for overdue frames [s]."""
SOURCES = ('parameters', 'vertices')
"""Topics that drive the pipeline; the first of them that the bag has is played by default."""


class Player(ParameterNode):
    """
    Publishes the serialised messages of a bag as they are, in the bag's order.

    In lockstep all messages with one stamp make up a frame, whenever they were received, and a
    frame leaves when the one before it is done, so nothing is lost. The topics asked for are
    played; by default `parameters` if the bag has it, else `vertices`.
    """

    def __init__(self):
        super().__init__('player', PLAYER)
        self._bag = RecordedTopics(self.values['path'])
        topics = self._chosen()
        self._out = {self._bag.names[topic]: publish(self, self._bag.names[topic])
                     for topic in topics}
        self._messages = self._bag.messages(topics)
        if self.values['pace'] == 'lockstep':
            self._messages = recorded_frames(
                self._messages, [name for name in self._out if TOPICS[name].every_frame])
        self._log = NodeLog(self)
        if self._bag.is_unfinished:
            self.get_logger().warning(f'{self.values["path"]} is not finished: what is whole of '
                                      'it is played')
        self._exit_status = 0
        self._next = self._read()
        self._start = None  # (steady time [s], time in the bag [ns]) of the first message
        self._delivery = Delivery(self, self._send_again, self._on_done)
        self._gathering = self._gather()
        self._timer = None
        self._arm(0.0)
        self.get_logger().info(f'playing {", ".join(self._out)} of {self.values["path"]}, '
                               f'{self.values["pace"]}')

    def check(self, values: Mapping) -> None:
        """Raise ValueError for frames that would never be done."""
        check_delivery(values)

    def _chosen(self):
        """Return the topics in the bag that are played."""
        present = self._bag.names.values()
        asked = self.values['topics'] or [
            next((name for name in SOURCES if name in present), ' and no '.join(SOURCES))]
        topics = [self._bag.find(name) for name in asked]
        names = [self._bag.names[topic] for topic in topics]
        for n, name in enumerate(names):
            if name in names[:n]:
                raise BadParameter(f'topics: {topics[names.index(name)]} and {topics[n]} would '
                                   f'both be played on {name}')
        return topics

    def _gather(self):
        """Return who is waited for at the start: the nodes that a source drives, or anybody."""
        first, names = next(iter(self._out)), self.values['wait_for']
        if first not in SOURCES:
            names = None
        elif names and first == 'parameters':
            names = ['physics', *names]
        return Gathering(self, first, names)

    def _read(self):
        """
        Return what the bag has next, or None; where it is damaged it ends, with status 1.

        In real time that is (name, time in the bag [ns], data), in lockstep a RecordedFrame.
        """
        try:
            return next(self._messages, None)
        except BadParameter as error:
            self.get_logger().error(f'{error}; nothing after {self._stopwatch.frames} messages of '
                                    f'{next(iter(self._out))} is played')
            self._exit_status = 1
            return None

    def _arm(self, seconds):
        """Call `_on_timer` again after `seconds`."""
        if self._timer is not None:
            self.destroy_timer(self._timer)
        self._timer = self.create_timer(max(seconds, 0.0), self._on_timer)

    def _on_timer(self):
        now = time.monotonic()
        if self.values['pace'] == 'lockstep':
            self._delivery.resend_overdue(now)
            self._give_up(now)
            self._send_frame(now)
            self._arm(POLL_PERIOD)
        elif self._gathering.is_over(now):
            self._send_due(now)
        else:
            self._arm(POLL_PERIOD)
        if self._next is None and not len(self._delivery) and not self.ended.done():
            self.get_logger().info('the bag is over')
            self.ended.set_result(self._exit_status)

    def _send_due(self, now):
        """Send what is due by the clock; then wait for the next."""
        while self._next is not None:
            if self._start is None:
                self._start = now, self._next[1]
            begin, first = self._start
            due = begin + (self._next[1] - first) * 1e-9 / self.values['rate']
            if due > time.monotonic():
                self._arm(due - time.monotonic())
                return
            name, _, data = self._next
            self._send(name, data)
            self._next = self._read()
        self._arm(POLL_PERIOD)

    def _send_frame(self, now):
        """Send all messages of the next frame, if none is in flight."""
        if self._next is None or len(self._delivery):
            return
        recorded, self._next = self._next, self._read()
        for name, data in recorded.messages:
            self._send(name, data)
        if recorded.trouble:
            self.get_logger().warning(recorded.trouble)
        if recorded.stamp is not None:
            frame = FrameId(recorded.stamp, None, recorded.stamp, recorded.stamp)
            self._delivery.send(frame, recorded, self.values['wait_for'], now)

    def _send(self, name, data):
        with self._stopwatch.measure('publish'):
            self._out[name].publish(data)
        self._stopwatch.frames += name == next(iter(self._out))

    def _send_again(self, sent):
        """Send a frame once more; nodes that wait for one that the bag lacks go on with it."""
        for name, data in sent.message.messages:
            self._out[name].publish(as_oldest(data) if name == 'parameters' else data)

    def _give_up(self, now):
        """Stop waiting for a frame that no node can serve, because the bag lacks a part of it."""
        sent = self._delivery.oldest
        if sent is None or not sent.message.lost or (
                now - sent.first_time <= self.values['resend_after']):
            return
        self._delivery.give_up()
        self._log.warn(f'no longer waiting for the frame at {sent.frame.stamp / 1e9:.3f} s: the '
                       f'bag lacks its {", ".join(sorted(sent.message.lost))}')

    def _on_done(self):
        if self.values['pace'] == 'lockstep':
            self._send_frame(time.monotonic())

    def close(self) -> None:
        """Close the bag and log where the time went."""
        self._bag.close()
        self.get_logger().info(self._stopwatch.summary())


def main(args: Sequence[str] | None = None) -> int:
    """Run the player node; return the exit status."""
    return run(Player, args)


if __name__ == '__main__':
    sys.exit(main())
