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

"""What a wind tells people of its frames: how many were missed and why, and of another wind."""
from collections import Counter
import time

ANOTHER = ('another node publishes parameters in this graph too: physics and renderer begin anew '
           'with every change of wind')


class MissedFrames:
    """
    Counts a wind's frames, and tells of those that were missed.

    node: the wind, which has the parameter wait_for; delivery: its Delivery. frames: a Counter of those
    that were `sent`, that were `skipped`, when time went by without them, and that were left
    `undone`, when others were too slow.
    """

    def __init__(self, node, delivery):
        self._node = node
        self._delivery = delivery
        self.frames = Counter()
        self._reported, self._shown = Counter(), Counter()

    @property
    def missed(self):
        """Return how many frames were missed."""
        return _missed(self.frames)

    def report(self, rate):
        """Warn of frames of `rate` [Hz] missed since the last time, and of another wind."""
        self.report_missed(rate)
        if self._has_rival():
            self._node.get_logger().warning(ANOTHER)

    def report_missed(self, rate):
        """Warn of frames of `rate` [Hz] that were missed since the last time."""
        new, self._reported = self.frames - self._reported, self.frames.copy()
        if not _missed(new):
            return
        late = self._delivery.late(time.monotonic())
        causes = [f'{new["undone"]} not done in time by ' + (
            late or ', '.join(self._node.values['wait_for']))] * bool(new['undone'])
        causes += [f'{new["skipped"]} not sent, the wind itself was too slow'] * bool(
            new['skipped'])
        way_out = '; a lower rate misses fewer, pace lockstep none'
        if late:
            way_out = '' if new['undone'] else f'; still waiting for {late}'
        self._node.get_logger().warning(
            f'{_missed(new)} of the last {new["sent"] + new["skipped"]} frames were missed at '
            f'{rate:g} Hz: {", ".join(causes)}{way_out}')

    def status(self):
        """Return what is wrong since the last time, in words, and the figures for `state`."""
        new, self._shown = self.frames - self._shown, self.frames.copy()
        late = self._delivery.late(time.monotonic())
        alarms = [f'waiting for {late}'] if late else []
        if _missed(new):
            alarms.append(f'{_missed(new)} frames missed')
        if self._has_rival():
            alarms.append(ANOTHER)
        return alarms, {
            'frames sent': self.frames['sent'], 'frames sent again': self._delivery.resent,
            'frames missed': self.missed, 'waiting for': late or 'nobody'}

    def _has_rival(self):
        return self._node.count_publishers('parameters') > 1


def _missed(frames):
    return frames['skipped'] + frames['undone']
