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

"""Frames that the wind node has missed in real time, and why."""
from collections import Counter
from collections.abc import Collection

MIN_CPU_SHARE = 0.5
"""A sender that computed for less than this fraction of a delay did not cause it."""


class MissedFrames:
    """
    Counts the frames of the wind node, and reports those that were missed.

    frames: a Counter of those that were `sent`, and of those that were missed because the wind
    itself was `slow`, because the machine was `busy` with other processes, or because the frames
    before were left `undone`.
    """

    CAUSES = ('undone', 'slow', 'busy')

    def __init__(self):
        self.frames = Counter()
        self._reported, self._shown = Counter(), Counter()

    @property
    def missed(self) -> int:
        """Return how many frames were missed."""
        return self._missed(self.frames)

    def skip(self, count: int, seconds: float, computed: float) -> None:
        """
        Note that `count` frames were due in the last `seconds` [s] and not sent.

        computed: how much of this time the wind's process had a processor [s].
        """
        self.frames['slow' if computed >= MIN_CPU_SHARE * seconds else 'busy'] += count

    def report(self, rate: float, late: str, consumers: Collection[str]) -> str:
        """
        Return a warning of the frames that were missed since the last one, '' if there are none.

        rate: of the frames [Hz]; late: the nodes that the wind waits for now, in words, or '';
        consumers: the names of all nodes in `wait_for`.
        """
        new, self._reported = self.frames - self._reported, self.frames.copy()
        missed = self._missed(new)
        if not missed:
            return ''
        causes = {'undone': f'not done in time by {late or ", ".join(consumers)}',
                  'slow': 'not sent, the wind itself was too slow',
                  'busy': 'not sent, the machine was busy with other processes'}
        reasons = [f'{new[cause]} {words}' for cause, words in causes.items() if new[cause]]
        way_out = '; a lower rate misses fewer, pace lockstep none'
        if late:
            way_out = '' if new['undone'] else f'; still waiting for {late}'
        return (f'{missed} of the last {new["sent"] + missed - new["undone"]} frames were missed '
                f'at {rate:g} Hz: {", ".join(reasons)}{way_out}')

    def lately(self) -> int:
        """Return how many frames were missed since the last call."""
        new, self._shown = self.frames - self._shown, self.frames.copy()
        return self._missed(new)

    def _missed(self, frames):
        return sum(frames[cause] for cause in self.CAUSES)
