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

"""The recorder node: writes topics as they are into a bag, for users without `ros2 bag`."""
import collections
from collections.abc import Sequence
import datetime
import sys
import time

from flag_sim.declarations.recorder import RECORDER
from flag_sim.protocol.cdr import serialized_stamp
from flag_sim.protocol.recording import Placement, Recording
from flag_sim.protocol.stamp_buffer import StampBuffer
from flag_sim.protocol.throttled_log import Entry
from flag_sim.ros import frame_message, serialized
from flag_sim.ros.bag import Bag
from flag_sim.ros.lifecycle import run
from flag_sim.ros.node_log import NodeLog
from flag_sim.ros.parameter_node import BadParameter, ParameterNode
from flag_sim.ros.topics import DEPTH, publish, publishers, subscribe, TOPICS

CHECK = 0.5
"""Between looks whether the bag is still there [s]."""
LINGER = 3.0
"""
How long a complete recording keeps answering while the wind is there [s].

The last answer may be lost; then the wind asks again, and this time starts over.
"""


def counted(number: int, noun: str, plural: str = '') -> str:
    """Return a number with its noun, singular or plural."""
    return f'{number} {noun if number == 1 else plural or noun + "s"}'


class Recorder(ParameterNode):
    """
    Writes every message once, at its own stamp, and reports complete frames on `frame_done`.

    The time of a message in the bag is its stamp, so that the bag plays at the shot's own speed
    however fast it was made. After a reset the time in the bag goes on: it is later than the stamp
    if the new take's stamps are not later than those of the take before.
    """

    def __init__(self):
        super().__init__('recorder', RECORDER)
        if not self.values['topics']:
            raise BadParameter('topics: there is nothing to record')
        self._topics = self._named()
        path = self.values['path'] or datetime.datetime.now().strftime('rosbag2_%Y_%m_%d-%H_%M_%S')
        self._bag = Bag(path, self.values['storage'], self.values['compression'])
        self._recording = Recording([name for name in self._topics if TOPICS[name].every_frame],
                                    self.values['frames'])
        self._early = {name: StampBuffer(DEPTH) for name in self._topics}
        self._end_timer = None  # looks whether a recording that is full has been heard
        self._last_asked = 0.0  # steady time at which a frame was last requested again [s]
        self._log = NodeLog(self)
        self._frames = frame_message.FrameReader()
        self._frame_done_out = publish(self, 'frame_done')
        self._done = serialized.header(self.get_name())
        for name in self._topics:
            self._record(name)
        if 'parameters' not in self._topics:
            subscribe(self, 'parameters', self._refusing('parameters', self._answer), raw=True)
        self.create_timer(CHECK, self._check)
        self._log.watch(self._lacking, lambda: self._stopwatch.frames)
        self.get_logger().info(f'recording {", ".join(self._topics)} into {path}')

    def _named(self) -> Sequence[str]:
        """Return the topics by our own names; users may name them as the graph shows them."""
        known = [name for name, topic in TOPICS.items() if topic.stamped]
        shown = {self.resolve_topic_name(name): name for name in known}
        names = [shown.get(name, name) for name in self.values['topics']]
        unknown = [name for name in names if name not in known]
        if unknown:
            raise BadParameter(f'topics: {unknown[0]!r} is not one of {", ".join(known)}')
        doubles = [name for name, n in collections.Counter(names).items() if n > 1]
        if doubles:
            raise BadParameter(f'topics: each is named once, but {doubles[0]!r} more often')
        return names

    def _record(self, name):
        """Record a topic from now on."""
        topic = self.resolve_topic_name(name)
        self._bag.add_topic(topic, TOPICS[name].message)

        def write(data, info):
            for message in self._follow(data, info) if name == 'parameters' else [data]:
                self._write(name, topic, message)
                if name == 'parameters':
                    self._write_early(serialized_stamp(message))
        subscribe(self, name, self._refusing(name, write), raw=True)

    def _refusing(self, name, take_in):
        """Return `take_in(data, info)` that warns of the ValueErrors it raises, and goes on."""
        def guarded(data, info):
            try:
                take_in(data, info)
            except ValueError as error:
                self._log.warn(f'a message on {name} is not recorded: {error}')
        return guarded

    def _follow(self, data, info):
        """Follow the takes by a message of `parameters`; return what is to be recorded now."""
        try:
            frame, _, _ = self._frames.read(data)
        except frame_message.NoMessage:
            raise
        except ValueError:
            return [data]  # physics refuses it and says so; here it is only recorded
        takes = self._recording.takes
        now = self._recording.follow(frame, data, bytes(info['publisher_gid']['data']))
        if 0 < takes < self._recording.takes:
            self._log.write_few(Entry('info', (
                'another take begins (the wind was reset, a bag is played again, or there is '
                f'another sender): it is appended to {self._bag.path} after '
                f'{counted(self._stopwatch.frames, "frame")}')), 'takes')
        if takes < self._recording.takes:
            for early in self._early.values():
                early.keep(())  # they were of the take before
        return now

    def _write_early(self, stamp):
        """Write what came before the parameters of its frame, which are there now."""
        for name, early in self._early.items():
            if stamp in early:
                self._write(name, self.resolve_topic_name(name), early.pop(stamp))

    def _answer(self, data, info):
        """Follow the takes by parameters that are not recorded; say so for a complete frame."""
        for message in self._follow(data, info):
            stamp = serialized_stamp(message)
            self._write_early(stamp)
            if self._recording.is_complete(stamp):
                self._answer_again(stamp)
        self._end_if_full()

    def _answer_again(self, stamp):
        """Say that a frame is complete to who has not heard it the first time."""
        self._last_asked = time.monotonic()
        self._say_done(stamp)

    def _write(self, name, topic, data):
        """Write a message, if it is not there yet, and say when its frame is complete."""
        if self.ended.done():
            return
        stamp = serialized_stamp(data)
        if self._recording.is_early(name, stamp):
            self._early[name].put(stamp, data)
            return
        placement = self._recording.place(name, stamp)
        if placement is Placement.ANSWER:
            self._answer_again(stamp)
        if placement is not Placement.WRITE:
            return
        # A sender serves frames in their order: those after this one were of the take before.
        self._early[name].keep({early for early in self._early[name] if early < stamp})
        try:
            with self._stopwatch.measure('work'):
                self._bag.write(topic, self._recording.time(stamp), data)
                is_complete = self._recording.written(name, stamp)
                if is_complete:
                    self._bag.flush()  # done means that it outlives this process
        except OSError as error:
            self._fail(error)
            return
        if is_complete:
            self._stopwatch.frames += 1
            self._say_done(stamp)
            self._end_if_full()

    def _check(self):
        """Notice, while nothing comes to be written, that the bag is gone."""
        if not self.ended.done():
            try:
                self._bag.check()
            except OSError as error:
                self._fail(error)

    def _fail(self, error):
        """Say that nothing more can be written, and end; no frame is answered any more."""
        self.get_logger().error(
            f'cannot write {self._bag.path}: {error}; the recording ends with '
            f'{counted(self._stopwatch.frames, "frame")}')
        self.ended.set_result(1)

    def _say_done(self, stamp):
        with self._stopwatch.measure('publish'):
            self._frame_done_out.publish(self._done.at(stamp))

    def _end_if_full(self):
        if self._recording.has_all_frames and self._end_timer is None:
            self._last_asked = time.monotonic()
            self._end_timer = self.create_timer(0.1, self._end_when_heard)

    def _end_when_heard(self):
        heard = (not self.count_publishers('parameters')
                 or time.monotonic() - self._last_asked > LINGER)
        # A take that has begun meanwhile is recorded too.
        if self._recording.has_all_frames and heard and not self.ended.done():
            self.ended.set_result(0)

    def _lacking(self):
        """Return in words what the take or a frame after its last complete one lacks, or ''."""
        recording, over = self._recording, not self.count_publishers('parameters')
        lacking, outstanding = recording.lacking(), recording.outstanding
        # The frame that was under way when the wind ended lacks what nobody was asked for.
        if over and outstanding and (recording.takes or lacking is None):
            return (f'{outstanding} of {counted(self.values["frames"], "frame")} of a take: '
                    'no node publishes parameters any more; begin the shot again, or end this')
        if lacking is None:
            return ''
        stamp, missing = lacking
        name = min(missing, key=self._topics.index)
        senders = publishers(self, name)
        return f'{name} of the frame at {stamp / 1e9:.3f} s: ' + (
            'no node publishes parameters any more' if over and recording.takes else
            f'{senders} has not sent it, its log says why' if senders else 'no node publishes it')

    def close(self) -> bool:
        """Close the bag and say what is in it; return whether that could not be done."""
        try:
            self._bag.close()
        except OSError as error:
            self.get_logger().error(f'cannot finish {self._bag.path}: {error}')
            return True
        recording = self._recording
        self.get_logger().info(
            f'{self._bag.path}: {counted(self._stopwatch.frames, "frame")}, '
            f'{self._bag.size / 1e6:.1f} MB on disk, '
            f'{counted(recording.incomplete, "incomplete frame")}, '
            f'{counted(recording.copies, "copy", "copies")} left out'
            + (f', {recording.takes} takes' if recording.takes > 1 else ''))
        self.get_logger().info(self._stopwatch.summary())
        return False


def main(args: Sequence[str] | None = None) -> int:
    """Run the recorder node; return the exit status."""
    return run(Recorder, args)


if __name__ == '__main__':
    sys.exit(main())
