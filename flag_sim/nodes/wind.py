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

"""The wind node: holds the wind and the keyframes, and decides when a frame happens."""
import sys
import time

from flag_sim.nodes import keys, messages
from flag_sim.nodes.autokey import Autokey
from flag_sim.nodes.dials import WIND
from flag_sim.nodes.flight import Flight
from flag_sim.nodes.frames import Tag
from flag_sim.nodes.life import run
from flag_sim.nodes.parameters import DialNode
from flag_sim.nodes.params_file import check_path, save_parameters
from flag_sim.nodes.stopwatch import Stopwatch
from flag_sim.nodes.topics import publish, subscribe
from flag_sim.nodes.weather import Weather
from geometry_msgs.msg import Vector3, Vector3Stamped
from rclpy.clock import Clock, ClockType
from rosgraph_msgs.msg import Clock as ClockMessage

LOOK_AGAIN = 0.2  # how often lockstep looks for overdue frames [s]
FIRST_RESEND = 0.2  # while nobody has ever answered, the graph is still coming together [s]
REPORT = 5.0  # time between reports of missed frames [s]


class Wind(DialNode):
    """Publishes one `parameters` message per frame, `keyframe` at keys, and ends the shot."""

    def __init__(self):
        super().__init__('wind', WIND, allow_undeclared_parameters=True)
        self._timeline = keys.read_timeline(self.values)
        self._parameters_out = publish(self, 'parameters')
        self._keyframe_out = publish(self, 'keyframe')
        self._wind_out = publish(self, 'wind')
        self._clock_out = publish(self, '/clock') if self.values['publish_clock'] else None
        self._flight = Flight()
        self._stopwatch = Stopwatch()
        self._ever_done = False
        self._resent = self._missed = self._sent_since_report = self._missed_since_report = 0
        self._report_time = None
        self._complaint = None, 0.0  # the frame last complained of, and when [s]
        self._reset_since = None
        self._timer = None
        self._begin_take()
        subscribe(self, 'frame_done', self._on_frame_done)
        self._autokey = Autokey(self, self._now)
        subscribe(self, 'reset', self._on_reset)
        subscribe(self, 'step', self._on_step)
        self._set_timer()
        self.create_timer(REPORT, self._look_for_another)
        self.get_logger().info(f'{self._plan()}, {self.values["pace"]}, waiting for '
                               f'{", ".join(self.values["wait_for"]) or "nobody"}')

    def _plan(self):
        frames, rate = self.values['frames'], self.values['rate']
        length = f'{frames} frames' if frames else 'frames without end'
        return f'{length} at {rate:g} Hz, {len(self._timeline.tracks)} tracks'

    def _look_for_another(self):
        if self.count_publishers('parameters') > 1:
            self.get_logger().warning('another node publishes parameters in this graph too: '
                                      'physics and renderer begin anew with every change of wind')

    # Parameters.

    def adopt(self, given):
        """Take the keys of the tracks that are named."""
        known = {keys.key_name(track, part)
                 for track in self.values['tracks'] for part in keys.PARTS}
        for name in sorted(known & set(given)):
            self.values[name] = self.accept(name, given.pop(name))
            self.declare_parameter(name, self.values[name] or None, ignore_override=True)

    def accept(self, name, value):
        """Accept keys beside the dials."""
        if name.startswith('keys.') and name.endswith(keys.PARTS):
            return keys.accept_keys(name, value)
        return super().accept(name, value)

    def check(self, values):
        """Refuse tracks that cannot be played, and a lockstep with nobody."""
        if values['pace'] == 'lockstep' and not values['wait_for']:
            raise ValueError('pace lockstep needs at least one node in wait_for')
        if values['save_to']:
            check_path(values['save_to'])
        keys.read_timeline(values)

    def apply(self, changed):
        """Play on with the new values."""
        now = self._stamp(self._index)
        self._timeline = keys.read_timeline(self.values)
        self._weather = Weather(self.values, self._timeline, now / 1e9,
                                self._weather.passed(now / 1e9))
        if 'rate' in changed:
            self._origin = (self._index, now)
            self._rate = self.values['rate']
        if changed & {'rate', 'pace', 'paused', 'frames'}:
            self._due_origin = None
            self._set_timer()
        if self.values['save_to'] and any(
                name.startswith(('tracks', 'keys.', 'events.', 'save_to')) for name in changed):
            self._save()

    def _now(self):
        """Return where in the animation the last frame was [s]."""
        return self._timeline.local(max(self._previous, 0) / 1e9)

    def _save(self):
        try:
            save_parameters(self.values['save_to'], self.get_fully_qualified_name(), self.values)
        except OSError as error:
            self.get_logger().error(f'cannot save {self.values["save_to"]}: {error}')

    # Time.

    def _begin_take(self):
        self._take = time.time_ns()  # later takes have greater numbers, also across restarts
        self._index = 0
        self._rate = self.values['rate']
        self._origin = (0, 0)  # a frame and its stamp [ns], from which the rate counts
        self._due_origin = None
        self._previous = -1  # stamp of the frame before [ns]; a key at 0 is crossed by frame 0
        self._flight.clear()
        self._weather = Weather(self.values, self._timeline)

    def _stamp(self, index):
        """Return frame n's stamp [ns]: n / rate, without accumulated error."""
        first, stamp = self._origin
        return stamp + round((index - first) * 1e9 / self._rate)

    def _set_timer(self):
        if self._timer is not None:
            self.destroy_timer(self._timer)
        playing = self.values['pace'] == 'realtime' and not self.values['paused']
        self._timer = self.create_timer(
            1.0 / self.values['rate'] if playing else LOOK_AGAIN, self._on_timer,
            clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_timer(self):
        now = time.monotonic()
        if self._reset_since is not None:
            self._finish_reset(now)
        elif self.values['pace'] == 'lockstep':
            self._resend(now)
            self._fill_window()
        elif not self.values['paused']:
            self._send_due(now)
        self._end_if_done(now)

    def _is_last_sent(self):
        return 0 < self.values['frames'] <= self._index

    # Lockstep.

    def _fill_window(self):
        # Alone at first: what is sent before everybody has found everybody may be lost.
        window = self.values['window'] if self._ever_done else 1
        while (self._index - self._oldest_index() < window and not self.values['paused']
               and self._reset_since is None and not self._is_last_sent()):
            self._send(time.monotonic())

    def _oldest_index(self):
        """Return the oldest frame that may be asked for again; all nodes keep those after it."""
        return self._flight.oldest.tag.index if len(self._flight) else self._index

    def _resend(self, now):
        after = self.values['resend_after']
        frame = self._flight.overdue(now, after if self._ever_done else min(FIRST_RESEND, after))
        if frame is None:
            return
        frame.tag = frame.tag._replace(oldest=frame.tag.index)
        messages.set_tag(frame.message, frame.tag)
        self._parameters_out.publish(frame.message)
        frame.last_time = now
        self._resent += 1
        if now - frame.first_time > after:
            self._complain(frame, now)

    def _complain(self, frame, now):
        """Say whom a frame waits for: at once of every new frame, and of the same now and then."""
        index, said = self._complaint
        if frame.tag.index == index and now - said < REPORT:
            return
        self._complaint = frame.tag.index, now
        self.get_logger().warning(
            f'frame {frame.tag.index} (t = {frame.tag.stamp / 1e9:.3f} s) is not done: '
            f'waiting for {self._names(frame.waiting_for)}; sent again')

    def _names(self, nodes):
        """Return names of nodes, with a remark on those that are not there at all."""
        present = {end.node_name for end in self.get_publishers_info_by_topic('frame_done')}
        return ', '.join(name if name in present else f'{name} (no such node is running)'
                         for name in sorted(nodes))

    def _on_frame_done(self, message):
        if not self._flight.done(messages.to_stamp(message.stamp), message.frame_id):
            return
        self._ever_done = True
        self._stopwatch.frames += 1
        if self.values['pace'] == 'lockstep':
            self._resend(time.monotonic())
            self._fill_window()
        self._end_if_done(time.monotonic())

    # Real time.

    def _send_due(self, now):
        """Send the frame that is due; time that went by without the timer is frames missed."""
        if self._is_last_sent():
            return
        if self._due_origin is None:
            self._due_origin = now, self._index
        begin, first = self._due_origin
        due = max(first + round((now - begin) * self._rate), self._index)
        if self.values['frames']:
            due = min(due, self.values['frames'] - 1)
        self._count_missed(due - self._index)
        self._index = due
        while len(self._flight) >= self.values['window']:
            if self.values['wait_for'] and self._ever_done:
                self._count_missed(1)
            self._flight.give_up()
        self._send(now)
        self._report(now)

    def _count_missed(self, frames):
        self._missed += frames
        self._missed_since_report += frames

    def _report(self, now):
        self._sent_since_report += 1
        self._report_time = self._report_time or now
        if now - self._report_time < REPORT:
            return
        if self._missed_since_report:
            self.get_logger().warning(
                f'{self._missed_since_report} of the last {self._sent_since_report} frames were '
                f'not done in time: {", ".join(self.values["wait_for"])} cannot keep up with '
                f'{self._rate:g} Hz')
        self._report_time = now
        self._sent_since_report = self._missed_since_report = 0

    # Frames.

    def _send(self, now):
        stamp = self._stamp(self._index)
        in_turn = self.values['pace'] == 'lockstep'
        tag = Tag(stamp, self._take, self._index,
                  self._oldest_index() if in_turn else self._index)
        with self._stopwatch.share('work'):
            keyed = keys.values_at(self._timeline, stamp / 1e9)
            wind = self._weather.at(stamp / 1e9)
            message = messages.parameters_message(
                self.get_fully_qualified_name(), tag, wind, keyed)
        with self._stopwatch.share('publish'):
            self._flight.send(tag, message, self.values['wait_for'], now)
            self._parameters_out.publish(message)
            self._publish_crossed(stamp)
            if self._clock_out is not None:
                self._clock_out.publish(ClockMessage(clock=messages.to_time(stamp)))
            if self._wind_out.get_subscription_count():
                self._wind_out.publish(Vector3Stamped(
                    header=messages.header(stamp, messages.WORLD),
                    vector=Vector3(x=wind[0], y=wind[1], z=wind[2])))
        self._index += 1

    def _publish_crossed(self, stamp):
        """Publish the keys and events between the frame before and this one."""
        for key, name in self._timeline.crossed(self._previous / 1e9, stamp / 1e9):
            self._keyframe_out.publish(messages.header(round(key * 1e9), name))
        self._previous = stamp

    def _on_step(self, _):
        """Send one frame while paused."""
        if self.values['paused'] and not self._is_last_sent():
            self._send(time.monotonic())

    def _on_reset(self, _):
        """Begin again; in lockstep only when what is in flight has been done."""
        self._reset_since = time.monotonic()
        self._finish_reset(self._reset_since)

    def _finish_reset(self, now):
        waited = now - self._reset_since > self.values['resend_after']
        if self.values['pace'] == 'realtime' or not len(self._flight) or waited:
            self._reset_since = None
            self._begin_take()
            self.get_logger().info('reset: back to the first frame', throttle_duration_sec=1.0)

    def _end_if_done(self, now):
        if self._reset_since is not None or self.ended.done() or not self._is_last_sent():
            return
        gone = self.values['pace'] == 'realtime' and self._flight.overdue(
            now, self.values['resend_after'])
        if not len(self._flight) or gone:
            self._count_missed(len(self._flight))
            self.get_logger().info(
                f'the shot is over: {self._index} frames, {self._resent} sent again, '
                f'{self._missed} not done in time')
            self.ended.set_result(0)

    def close(self):
        """Say where the time went."""
        self.get_logger().info(self._stopwatch.summary())


def main(args=None):
    """Run the wind node."""
    return run(Wind, args)


if __name__ == '__main__':
    sys.exit(main())
