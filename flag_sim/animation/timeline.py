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

"""A timeline: many tracks and named events under one clock, once or again and again."""
import bisect

from flag_sim import checks
from flag_sim.animation.tracks import SAME, Track
from flag_sim.attributes import constant

SHORTEST_ROUND = 1e-3  # of a loop [s]: a frame goes through all of its rounds


@constant
class Timeline:
    """
    What a shot's keys say at any time.

    tracks: {name: Track}; events: [(time [s], name)], in any order (Blender: markers).
    loop: after the last key or event of all, everything begins again while time goes on (cyclic
    extrapolation); a track whose keys end earlier holds until then.
    Raises ValueError for a loop that is too short, and for what is no track, event or boolean.
    """

    def __init__(self, tracks, events=(), loop=False):
        loop = checks.boolean('loop', loop)
        for name, track in dict(tracks).items():
            checks.instance(f'track {name!r}', track, Track)
        events = [_event(*event) for event in events]
        self.tracks = dict(tracks)
        keys = [(time, name) for name, track in self.tracks.items() for time in track.times]
        self._marks = sorted([*keys, *events])
        self._times = [time for time, _ in self._marks]
        self.length = max(self._times, default=0.0)
        self.loop = bool(loop) and self.length > 0.0
        if self.loop and self.length < SHORTEST_ROUND:
            raise ValueError(f'a loop must take at least {SHORTEST_ROUND:g} s; its last key or '
                             f'event is at {self.length:g} s')
        # What stands at the end of a round and at its begin is one crossing.
        self._at_end = {name for time, name in self._marks if time == self.length}

    def at(self, time):
        """Return {track name: value at `time` [s]}."""
        local = self.local(time)
        return {name: track.at(local) for name, track in self.tracks.items()}

    def value(self, name, time):
        """Return one track's value at `time` [s]."""
        return self.tracks[name].at(self.local(time))

    def local(self, time):
        """
        Return the time within a round [s]: time itself where nothing loops.

        The end of a round is the begin of the next.
        """
        if not self.loop:
            return time
        local = time % self.length
        return local if local + SAME < self.length else 0.0

    def crossed(self, after, until):
        """
        Return [(time [s], name)] of the keys and events in (after, until] [s], in their order.

        In a loop the end of one round is the begin of the next: what lies on both counts once.
        What is within SAME of an edge is at it.
        """
        found = []
        for lap in self._laps(after, until):
            begin = lap * self.length
            # Compared is the mark's own time, lap and all, which is the same for every frame:
            # one rounding more and frames at the end of a round would lose or double marks.
            first, last = (
                bisect.bisect_right(self._times, edge + SAME, key=lambda time: begin + time)
                for edge in (after, until))
            found += [(begin + time, name) for time, name in self._marks[first:last]
                      if lap == 0 or time > 0.0 or name not in self._at_end]
        return found

    def _laps(self, after, until):
        """Return the rounds that may have marks in (after, until], one more at either side."""
        if not self.loop:
            return range(1)
        return range(max(int(after // self.length) - 1, 0), int(until // self.length) + 2)


def _event(time, name):
    """Return an event as it is; raise ValueError if it is none."""
    checks.require(isinstance(name, str), 'name of an event', 'a text', name)
    return checks.finite(f"time of the event '{name}'", time), name
