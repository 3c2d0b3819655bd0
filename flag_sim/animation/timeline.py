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


class Timeline:
    """
    What a shot's keys say at any time.

    tracks: {name: Track}; events: [(time [s], name)], in any order.
    loop: after its last key or event everything begins again, while time goes on.
    """

    def __init__(self, tracks, events=(), loop=False):
        self.tracks = dict(tracks)
        self.events = sorted(events)
        last = [track.times[-1] for track in self.tracks.values()]
        self.length = max(last + [time for time, _ in self.events], default=0.0)
        self.loop = bool(loop) and self.length > 0.0

    def at(self, time):
        """Return {track name: value} at `time` [s]."""
        return {name: self.value(name, time) for name in self.tracks}

    def value(self, name, time):
        """Return one track's value at `time` [s]."""
        return self.tracks[name].at(self.local(time))

    def local(self, time):
        """Return the time within a round [s]: time itself where nothing loops."""
        return time % self.length if self.loop else time

    def crossed(self, after, until):
        """
        Return [(time [s], name)] of the keys and events in (after, until] [s], in their order.

        In a loop the end of one round is the begin of the next: what lies on both counts once.
        """
        if not self.loop:
            return self._crossed_in_round(after, until)
        found = []
        for lap in range(int(max(after, 0.0) // self.length), int(until // self.length) + 1):
            begin = lap * self.length
            found += [(begin + time, name)
                      for time, name in self._crossed_in_round(after - begin, until - begin)
                      if lap == 0 or time > 0.0 or (self.length, name) not in self._ends()]
        return found

    def _crossed_in_round(self, after, until):
        keys = [(key, name) for name, track in self.tracks.items()
                for key in track.crossed(after, until)]
        return sorted(keys + [event for event in self.events if after < event[0] <= until])

    def _ends(self):
        keys = {(track.times[-1], name) for name, track in self.tracks.items()}
        return keys | set(self.events)
