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

"""The wind node: plays the wind and the keyframes, and decides when a frame happens."""
from collections.abc import Mapping, Sequence
import sys
import time

from flag_sim.animation.keys import values_at
from flag_sim.animation.wind_source import WindSource
from flag_sim.declarations.keyable import TARGETS
from flag_sim.declarations.wind import WIND
from flag_sim.protocol.clock import FrameClock
from flag_sim.protocol.frames import next_take
from flag_sim.protocol.missed_frames import MissedFrames
from flag_sim.protocol.requests import Requests
from flag_sim.protocol.take import Take
from flag_sim.protocol.throttled_log import Entry
from flag_sim.ros import frame_message, messages
from flag_sim.ros.animation_node import AnimationNode
from flag_sim.ros.delivery import check_delivery, Delivery
from flag_sim.ros.diagnostics import compute_time, Diagnostics, OK, WARN
from flag_sim.ros.gathering import Gathering
from flag_sim.ros.keyframes import Keyframes
from flag_sim.ros.lifecycle import run
from flag_sim.ros.topics import publish, subscribe
from geometry_msgs.msg import Vector3, Vector3Stamped
from rosgraph_msgs.msg import Clock as ClockMessage

POLL_PERIOD = 0.2
"""How often lockstep checks for overdue frames [s]."""
REPORT_PERIOD = 5.0
"""How often missed frames and a second wind are reported [s]."""
SECOND_WIND_WARNING = ('another node publishes parameters in this graph too: physics and renderer '
                       'start over whenever the sender changes')


class Wind(AnimationNode):
    """Publishes one `parameters` message per frame, `keyframe` at keys, and ends the shot."""

    def __init__(self):
        super().__init__('wind', WIND)
        self._parameters_out = publish(self, 'parameters')
        self._keyframe_out = publish(self, 'keyframe')
        self._wind_out = publish(self, 'wind')
        self._clock_out = publish(self, '/clock') if self.values['publish_clock'] else None
        self._message = frame_message.FrameMessage(self.get_fully_qualified_name())
        self._delivery = Delivery(self, self._send_again, self._on_done)
        names = self.values['wait_for'] and ['physics', *self.values['wait_for']]
        # The clients by which the others are asked for their parameters take 8 ms to be made.
        self._gathering = Gathering(self, 'parameters', names, self.companions.look)
        self._keyframes = Keyframes()
        self._missed = MissedFrames()
        # When _send_due last ran: steady time and process CPU time [s].
        self._last_look = time.monotonic(), time.process_time()
        self._requests = Requests()
        self._timer = None
        self._take = None
        self._begin_take()
        subscribe(self, 'reset', self._on_reset)
        subscribe(self, 'step', self._on_step)
        self._set_timer()
        self.create_timer(REPORT_PERIOD, self._report)
        self._diagnostics = Diagnostics(self, self._status)
        waits = 'served by' if self.values['pace'] == 'realtime' else 'waiting for'
        self.get_logger().info(f'{self._plan()}, {self.values["pace"]}, {waits} '
                               f'{", ".join(self.values["wait_for"]) or "nobody"}')

    def _plan(self):
        frames, rate = self.values['frames'], self.values['rate']
        length = f'{frames} frames' if frames else 'frames without end'
        stamps = ', stamps by the wall clock' * (self.values['stamp.clock'] == 'wall')
        return f'{length} at {rate:g} Hz{stamps}, {len(self.timeline.tracks)} tracks'

    # Parameters.

    def check(self, values: Mapping) -> None:
        """Raise ValueError for an animation that cannot be played, or would never finish."""
        check_delivery(values)
        if values['stamp.clock'] == 'wall' and values['stamp.start']:
            raise ValueError(f'stamp.start {values["stamp.start"]:g} s is only for stamp.clock '
                             'simulation, not for wall')
        super().check(values)

    def apply(self, changed: set[str]) -> None:
        """Play on with the new values."""
        super().apply(changed)
        now = self._take.clock.time / 1e9
        self._wind_source = self._wind_source.continued(self.values, self.timeline, now)
        self._take.length = self.values['frames']
        if 'wait_for' in changed:
            self._delivery.wait_for(self.values['wait_for'])
        if 'rate' in changed:
            self._report_missed()  # at the rate at which they were missed
            self._take.clock.change_rate(self.values['rate'])
        if changed & {'rate', 'pace', 'paused', 'frames'}:
            self._take.clock.wait()
            self._set_timer()
        if changed & {'paused', 'pace'}:
            self._requests.steps = 0  # they are for while it is paused
        if 'pace' in changed:
            # In real time no node waits for a resend, so nothing is kept in flight.
            self._delivery.clear()

    def now(self) -> float:
        """Return the time of the last frame in the animation [s]."""
        return self.timeline.local(max(self._take.previous, 0) / 1e9)

    # Time.

    def _begin_take(self):
        clock = FrameClock(
            self.values['rate'], round(self.values['stamp.start'] * 1e9),
            time.time_ns if self.values['stamp.clock'] == 'wall' else None)
        self._take = Take(next_take(self._take.number if self._take else 0), clock,
                          self.values['frames'], messages.LATEST)
        self._delivery.clear()
        self._keyframes.clear()
        self._wind_source = WindSource(self.values, self.timeline)

    def _set_timer(self):
        if self._timer is not None:
            self.destroy_timer(self._timer)
        playing = self.values['pace'] == 'realtime' and not self.values['paused']
        self._timer = self.create_timer(
            1.0 / self.values['rate'] if playing else POLL_PERIOD, self._on_timer)

    def _on_timer(self):
        now = time.monotonic()
        if self._requests.is_reset_asked:
            self._finish_reset(now)
        elif self.values['pace'] == 'lockstep':
            self._delivery.resend_overdue(now)
            self._fill_window()
        elif not self.values['paused'] and self._gathering.is_over(now):
            self._send_due(time.monotonic())
        self._end_if_done(now)

    def _on_step(self, _):
        """Send one frame while paused; in lockstep once the window has room for it."""
        if not self.values['paused']:
            return
        if self.values['pace'] == 'lockstep':
            self._requests.steps += 1
            self._fill_window()
        elif not self._take.is_over:
            self._delivery.make_room(self.values['window'])
            self._send(time.monotonic())

    def _on_reset(self, _):
        """Begin again; in lockstep only when the frames in flight are done."""
        now = time.monotonic()
        self._requests.reset(now)
        self._finish_reset(now)

    def _finish_reset(self, now):
        is_idle = self.values['pace'] == 'realtime' or not len(self._delivery)
        if self._requests.begins_take(is_idle, now, self.values['resend_after']):
            self._begin_take()
            self._log.write_few(Entry('info', 'reset: back to the first frame'), 'reset')

    def _end_if_done(self, now):
        if self._requests.is_reset_asked or self.ended.done() or not self._take.is_over:
            return
        is_gone = self.values['pace'] == 'realtime' and self._delivery.overdue(
            now, self.values['resend_after'])
        if not len(self._delivery) or is_gone:
            self._missed.frames['undone'] += len(self._delivery)
            beyond = f', and the next stamp is beyond {messages.LATEST / 1e9:.0f} s'
            self.get_logger().info(
                f'the shot is over: {self._take.clock.index} frames, {self._delivery.resent} sent '
                f'again, {self._missed.missed} missed' + beyond * self._take.is_beyond)
            self.ended.set_result(0)

    # Lockstep.

    def _fill_window(self):
        while ((not self.values['paused'] or self._requests.steps)
               and not self._requests.is_reset_asked
               and self._take.has_room(self._delivery, self.values['window'])):
            self._requests.steps = max(self._requests.steps - 1, 0)
            self._send(time.monotonic())

    def _send_again(self, sent):
        sent.frame = sent.frame._replace(oldest=sent.frame.index)
        self._parameters_out.publish(self._message.fill(sent.frame, *sent.message))
        self._publish_wind(sent.frame.stamp, sent.message[0])

    def _on_done(self):
        if self.values['pace'] == 'lockstep':
            self._delivery.resend_overdue(time.monotonic())
            self._fill_window()
        self._end_if_done(time.monotonic())

    # Real time.

    def _send_due(self, now):
        """Send the frame that is due; earlier ones that were not sent count as missed."""
        if self._take.is_over:
            return
        (before, computed_before), self._last_look = self._last_look, (now, time.process_time())
        skipped = self._take.skip_to(now)
        self._missed.skip(skipped, now - before, self._last_look[1] - computed_before)
        if self._take.is_beyond:
            return
        self._missed.frames['undone'] += self._delivery.make_room(self.values['window'])
        self._send(now)

    # Frames.

    def _send(self, now):
        """Send the next frame at steady time `now` [s]."""
        if self._take.previous < 0:
            self._take.clock.meet_wall()
        at = self._take.clock.time
        # In lockstep, nodes keep answers that may be requested again; in real time they keep none.
        frame = self._take.next_id(self._take.oldest_index(self._delivery)
                                   if self.values['pace'] == 'lockstep' else None)
        with self._stopwatch.measure('work'):
            # Keys and gusts are at times of the take, independent of its stamps.
            keyed = values_at(self.timeline, at / 1e9, TARGETS)
            wind = self._wind_source.at(at / 1e9)
            message = self._message.fill(frame, wind, keyed)
        with self._stopwatch.measure('publish'):
            self._delivery.send(frame, (wind, keyed), self.values['wait_for'], now)
            self._parameters_out.publish(message)
            self._publish_crossed(at)
            if self._clock_out is not None:
                self._clock_out.publish(ClockMessage(clock=messages.to_time(frame.stamp)))
            self._publish_wind(frame.stamp, wind)
        self._stopwatch.frames += 1
        self._missed.frames['sent'] += 1
        self._take.sent()

    def _publish_wind(self, stamp, wind):
        """Publish the wind of the frame at `stamp` [ns], if somebody listens."""
        if self._wind_out.get_subscription_count():
            self._wind_out.publish(Vector3Stamped(
                header=messages.header(stamp, messages.WORLD),
                vector=Vector3(x=wind[0], y=wind[1], z=wind[2])))

    def _publish_crossed(self, at):
        """Publish the keys and events of the frame that is `at` [ns] in the take."""
        try:
            self._keyframes.cross(self.timeline, self._take.previous, at, self._take.clock.offset)
        except ValueError as error:
            self._log.warn(f'a frame is too long to announce its keys: {error}')
        self._keyframes.publish(self._keyframe_out)

    # Reports.

    def _report(self):
        """Warn of frames that were missed, and of a second wind."""
        self._report_missed()
        if self.count_publishers('parameters') > 1:
            self._log.warn(SECOND_WIND_WARNING)

    def _report_missed(self):
        """Warn of frames that were missed since the last time."""
        report = self._missed.report(
            self._take.clock.rate, self._delivery.late_in_words(time.monotonic()),
            self.values['wait_for'])
        if report:
            self.get_logger().warning(report)

    def _status(self):
        """Return the `state` of the wind."""
        pace = 'paused' if self.values['paused'] else self.values['pace']
        late, missed = self._delivery.late_in_words(time.monotonic()), self._missed.lately()
        alarms = [f'waiting for {late}'] * bool(late) + [f'{missed} frames missed'] * bool(missed)
        alarms += [SECOND_WIND_WARNING] * (self.count_publishers('parameters') > 1)
        return (WARN if alarms else OK, '; '.join(alarms) or pace, {
            'pace': pace, 'rate [Hz]': self.values['rate'],
            'time [s]': max(self._take.previous, 0) / 1e9,
            'frames sent': self._missed.frames['sent'],
            'frames sent again': self._delivery.resent,
            'frames missed': self._missed.missed, 'waiting for': late or 'nobody',
            'tracks': len(self.timeline.tracks), **compute_time(self._stopwatch)})

    def close(self) -> None:
        """Log where the time went."""
        self.get_logger().info(self._stopwatch.summary())


def main(args: Sequence[str] | None = None) -> int:
    """Run the wind node; return the exit status."""
    return run(Wind, args)


if __name__ == '__main__':
    sys.exit(main())
