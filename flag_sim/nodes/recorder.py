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

"""The recorder node: writes topics as they are into a bag, for those who have no `ros2 bag`."""
import collections
import datetime
import sys
import time

from flag_sim.declarations.nodes import RECORDER
from flag_sim.protocol.frames import Arrival, FrameOrder
from flag_sim.ros import messages
from flag_sim.ros.bag import Bag
from flag_sim.ros.lifecycle import run
from flag_sim.ros.parameter_node import BadParameter, ParameterNode
from flag_sim.ros.throttled_log import Refusals, Waiting
from flag_sim.ros.topics import publish, publishers, subscribe, TOPICS
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message

REMEMBERED = 1024  # frames of which copies are recognised
TAKE_GAP = 100_000_000  # time in the bag between two takes [ns]
LATEST = 2**63 - 1  # that rosbag2 can hold, as its times are signed [ns]
# Its last word may be lost, so a recorder that has all its frames goes on answering until the
# wind is gone or has not asked again for so long [s].
LINGER = 3.0


def counted(number, noun, plural=''):
    """Return a number of things in words."""
    return f'{number} {noun if number == 1 else plural or noun + "s"}'


def check_single(names):
    """Raise BadParameter if a topic is named twice."""
    doubles = [name for name, n in collections.Counter(names).items() if n > 1]
    if doubles:
        raise BadParameter(f'topics: each is named once, but {doubles[0]!r} more often')


class Recorder(ParameterNode):
    """
    Writes every message once, at its own stamp, and says on `frame_done` which frames are safe.

    In the bag a message's time is its stamp, so that the bag plays at the shot's own speed however
    fast it was made. After a reset the time in the bag goes on; it is later than the stamp only
    where the take's stamps are not beyond those of the take before.
    """

    def __init__(self):
        super().__init__('recorder', RECORDER)
        if not self.values['topics']:
            raise BadParameter('topics: there is nothing to record')
        self._topics = self._named()
        path = self.values['path'] or datetime.datetime.now().strftime('rosbag2_%Y_%m_%d-%H_%M_%S')
        self._bag = Bag(path, self.values['storage'], self.values['compression'])
        self._every_frame = {t for t in self._topics if TOPICS[t].every_frame}
        self._missing = {}  # topics that have not come, by stamp, of frames that are not whole
        self._whole = collections.OrderedDict()  # stamps of the latest whole frames
        self._order = FrameOrder()
        self._held = None  # parameters that are a late copy or begin a round, as the next tell
        self._takes = 0
        self._refusals = Refusals()
        self._offset = self._newest = 0
        self._copies = self._lost = 0
        self._frame_done_out = publish(self, 'frame_done')
        for name in self._topics:
            self._record(name)
        if 'parameters' not in self._topics:
            subscribe(self, 'parameters', self._refusing('parameters', self._follow_takes),
                      raw=True)
        self._waiting = Waiting(self, self._lacking, lambda: self._stopwatch.frames)
        self.get_logger().info(f'recording {", ".join(self._topics)} into {path}')

    def _named(self):
        """Return the topics by our own names; they may be given as the graph shows them."""
        known = [name for name, topic in TOPICS.items() if topic.stamped]
        shown = {self.resolve_topic_name(name): name for name in known}
        names = [shown.get(name, name) for name in self.values['topics']]
        unknown = [name for name in names if name not in known]
        if unknown:
            raise BadParameter(f'topics: {unknown[0]!r} is not one of {", ".join(known)}')
        check_single(names)
        return names

    def _record(self, name):
        topic = self.resolve_topic_name(name)
        self._bag.add_topic(topic, TOPICS[name].message)

        def write(data, info):
            for message in self._follow_takes(data, info) if name == 'parameters' else [data]:
                self._write(name, topic, message)
        subscribe(self, name, self._refusing(name, write), raw=True)

    def _refusing(self, name, take_in):
        """Return `take_in(data, info)` that tells of the ValueErrors it raises, and goes on."""
        def guarded(data, info):
            try:
                take_in(data, info)
            except ValueError as error:
                reason = f'a message on {name} is not recorded: {error}'
                if self._refusals.is_worth_saying(reason, time.monotonic()):
                    self.get_logger().warning(reason)
        return guarded

    def _follow_takes(self, data, info):
        """
        Notice when the shot begins anew: its stamps then are no copies of the earlier ones.

        Returns the messages that are to be recorded now: `data`, and what was held back before it.
        """
        try:
            message = deserialize_message(data, ParameterEvent)
        except RuntimeError:  # of the middleware; it names a line in its source
            raise ValueError(f'its {len(data)} bytes are no ParameterEvent') from None
        try:
            frame, _, _ = messages.read_parameters(message)
        except ValueError:
            return [data]  # physics refuses it and says so; here it is only recorded
        if frame.take is None:
            return [data]
        held, self._held = self._held, None
        arrival = self._order.arrive(frame, bytes(info['publisher_gid']['data']))
        first = min(self._order.waiting.values(), default=frame)
        is_round = arrival is Arrival.RESTART and len(self._order.waiting) > 1
        self._copies += held is not None and not is_round
        if arrival is Arrival.STALE:
            self._held = data
            return []
        while self._order.next_frame() is not None:
            pass  # its turn is all the same here, but a take that is played again is known by it
        if arrival is Arrival.RESTART:
            self._begin_take(first.stamp)
        return [held, data] if is_round else [data]

    def _begin_take(self, stamp):
        """Let a take whose first frame has `stamp` [ns] follow in the bag after the one before."""
        # Images of the first take may come before its parameters: they belong to it.
        if self._takes:
            self.get_logger().info(
                f'another take begins, as the wind was reset, a bag is played again or another '
                f'sender came: it follows in {self._bag.path} after '
                f'{counted(self._stopwatch.frames, "frame")} before')
            self._offset = max(self._newest + TAKE_GAP - stamp, 0)
            self._lost += len(self._missing)
            self._missing.clear()
            self._whole.clear()
        self._takes += 1

    def _write(self, name, topic, data):
        stamp = messages.serialized_stamp(data)
        if stamp < 0:  # a bag counts its times from 0
            raise ValueError(f'its stamp {stamp / 1e9} s is before 0')
        if stamp + self._offset > LATEST:
            raise ValueError(f'its stamp {stamp / 1e9} s after {self._takes - 1} takes is later '
                             f'than a bag can hold, {LATEST / 1e9} s')
        if name in self._every_frame:
            if stamp in self._whole:
                self._copies += 1
                self._last_asked = time.monotonic()
                self._say_done(stamp)  # it was not heard the first time
                return
            if len(self._whole) == REMEMBERED and stamp < next(iter(self._whole)):
                self._copies += 1
                return
        if self._is_full or self.ended.done():
            return
        if name in self._every_frame:
            missing = self._missing.setdefault(stamp, set(self._every_frame))
            if name not in missing:
                self._copies += 1
                return
            missing.discard(name)
        try:
            with self._stopwatch.share('work'):
                self._bag.write(topic, stamp + self._offset, data)
        except OSError as error:
            self._fail(error)
            return
        self._newest = max(self._newest, stamp + self._offset)
        if name in self._every_frame and not self._missing[stamp]:
            self._finish_frame(stamp)

    def _lacking(self):
        """Return in words what a frame after the last whole one lacks, or ''."""
        last = next(reversed(self._whole), -1)
        stamp = min((stamp for stamp in self._missing if stamp > last), default=None)
        if stamp is None or self._is_full:
            return ''
        name = min(self._missing[stamp], key=self._topics.index)
        senders = publishers(self, name)
        return f'{name} of the frame at {stamp / 1e9:.3f} s: ' + (
            f'{senders} has not sent it, its log says why' if senders else 'nobody publishes it')

    def _finish_frame(self, stamp):
        del self._missing[stamp]
        self._whole[stamp] = None
        if len(self._whole) > REMEMBERED:
            self._whole.popitem(last=False)
        if len(self._missing) > REMEMBERED:
            del self._missing[min(self._missing)]
            self._lost += 1
        self._stopwatch.frames += 1
        self._say_done(stamp)
        if self._is_full:
            self._last_asked = time.monotonic()
            self.create_timer(0.1, self._end_when_heard)

    @property
    def _is_full(self):
        return 0 < self.values['frames'] <= self._stopwatch.frames

    def _end_when_heard(self):
        heard = (not self.count_publishers('parameters')
                 or time.monotonic() - self._last_asked > LINGER)
        if heard and not self.ended.done():
            self.ended.set_result(0)

    def _say_done(self, stamp):
        with self._stopwatch.share('publish'):
            self._frame_done_out.publish(messages.header(stamp, self.get_name()))

    def _fail(self, error):
        self.get_logger().error(f'cannot write {self._bag.path}: {error}; the recording ends with '
                                f'{counted(self._stopwatch.frames, "frame")}')
        self.ended.set_result(1)

    def close(self):
        """Close the bag and say what is in it; return whether that could not be done."""
        try:
            self._bag.close()
        except OSError as error:
            self.get_logger().error(f'cannot finish {self._bag.path}: {error}')
            return True
        self.get_logger().info(
            f'{self._bag.path}: {counted(self._stopwatch.frames, "frame")}, '
            f'{self._bag.size / 1e6:.1f} MB on disk, '
            f'{counted(self._lost + len(self._missing), "incomplete frame")}, '
            f'{counted(self._copies, "copy", "copies")} left out'
            + (f', {self._takes} takes' if self._takes > 1 else ''))
        self.get_logger().info(self._stopwatch.summary())
        return False


def main(args=None):
    """Run the recorder node."""
    return run(Recorder, args)


if __name__ == '__main__':
    sys.exit(main())
