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

"""The player node, the recorder's twin: sends what a bag holds, by the clock or in lockstep."""
import sys
import time

from flag_sim.dials.catalogue import PLAYER
from flag_sim.nodes.bag import RecordedTopics
from flag_sim.nodes.delivery import check_delivery, Delivery
from flag_sim.nodes.frames import Tag
from flag_sim.nodes.life import run
from flag_sim.nodes.parameters import BadParameter, DialNode
from flag_sim.nodes.recorder import serialized_stamp
from flag_sim.nodes.topics import publish
from rclpy.clock import Clock, ClockType

LOOK_AGAIN = 0.05  # how often lockstep looks for what is overdue [s]
# What drives the pipeline from the bag on; played if nothing else is asked for.
SOURCES = ('parameters', 'vertices')


class Player(DialNode):
    """
    Publishes the serialised messages of a bag as they are, in the bag's order.

    In lockstep the next frame leaves when the one before is done, so nothing is lost. Played are
    the topics asked for, else `parameters` if the bag has it, else `vertices`.
    """

    def __init__(self):
        super().__init__('player', PLAYER)
        self._bag = RecordedTopics(self.values['path'])
        self._out = {name: publish(self, name) for name in self._chosen()}
        self._messages = self._bag.messages(self._out)
        self._status = 0
        self._next = self._read()
        self._start = None  # (steady time [s], time in the bag [ns]) of the first message
        self._flight = Delivery(self, self._send_again, self._on_done)
        self._timer = None
        self._arm(0.0)
        self.get_logger().info(f'playing {", ".join(self._out)} of {self.values["path"]}, '
                               f'{self.values["pace"]}')

    def check(self, values):
        """Refuse frames that would never be done."""
        check_delivery(values)

    def _chosen(self):
        """Return the names of the topics that are played."""
        present = self._bag.names.values()
        asked = self.values['topics'] or [name for name in SOURCES if name in present][:1]
        missing = [name for name in asked if name not in present]
        if missing or not asked:
            raise BadParameter(f'topics: the bag has no {", ".join(missing or SOURCES)}; '
                               f'it has {", ".join(sorted(present)) or "none of ours"}')
        return asked

    def _read(self):
        """Return the bag's next message, or None; where it is damaged it ends, with status 1."""
        try:
            return next(self._messages, None)
        except BadParameter as error:
            self.get_logger().error(f'{error}; nothing after {self._stopwatch.frames} messages of '
                                    f'{next(iter(self._out))} is played')
            self._status = 1
            return None

    def _arm(self, seconds):
        """Look again after `seconds`."""
        if self._timer is not None:
            self.destroy_timer(self._timer)
        self._timer = self.create_timer(max(seconds, 0.0), self._on_timer,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_timer(self):
        now = time.monotonic()
        if self.values['pace'] == 'lockstep':
            self._flight.resend(now)
            self._send_frame(now)
            self._arm(LOOK_AGAIN)
        else:
            self._send_due(now)
        if self._next is None and not len(self._flight) and not self.ended.done():
            self.get_logger().info('the bag is over')
            self.ended.set_result(self._status)

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
            self._send()
        self._arm(LOOK_AGAIN)

    def _send_frame(self, now):
        """Send all messages of the next stamp, if none is in flight."""
        if self._next is None or len(self._flight):
            return
        at = self._next[1]
        sent = []
        while self._next is not None and self._next[1] == at:
            sent.append(self._send())
        try:
            stamp = serialized_stamp(sent[-1][1])
        except ValueError as error:
            self.get_logger().warning(f'{sent[-1][0]} is not waited for: {error}')
            return
        self._flight.send(Tag(stamp, None, stamp, stamp), sent, self.values['wait_for'], now)

    def _send(self):
        name, _, data = self._next
        with self._stopwatch.share('publish'):
            self._out[name].publish(data)
        self._stopwatch.frames += name == next(iter(self._out))
        self._next = self._read()
        return name, data

    def _send_again(self, frame):
        for name, data in frame.message:
            self._out[name].publish(data)

    def _on_done(self):
        if self.values['pace'] == 'lockstep':
            self._send_frame(time.monotonic())

    def close(self):
        """Close the bag and say where the time went."""
        self._bag.close()
        self.get_logger().info(self._stopwatch.summary())


def main(args=None):
    """Run the player node."""
    return run(Player, args)


if __name__ == '__main__':
    sys.exit(main())
