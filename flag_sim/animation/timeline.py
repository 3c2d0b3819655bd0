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
from collections.abc import Iterable, Mapping
import math

from flag_sim.animation.tracks import TIME_TOLERANCE, Track
from flag_sim.parameters import checks
from flag_sim.parameters.closed import constant

SHORTEST_ROUND = 1e-3  # of a loop [s]: a frame goes through all of its rounds
MOST_CROSSED = 1_000_000  # keys and events in one span: it takes some seconds to list them


def nearest_frame(time: float, rate: float) -> float:
    """Return the time [s] of the frame at n / rate [Hz] that is nearest; in between, the later."""
    return math.floor(time * rate + 0.5) / rate


@constant
class Timeline:
    """
    What a shot's keys say at any time.

    tracks: {name: Track}; events: [(time [s], name)], in any order (Blender: markers).
    loop: everything plays again and again (cyclic extrapolation) while time goes on. A round is
    from 0, or the first key if it is before 0, to the last key or event of all; a track whose
    keys end earlier keeps its last value until then. The end of a round and the beginning of the
    next are one moment, which shows the end, so that the last key is seen (as in Blender's
    cycles).
    Raises ValueError for a loop that is too short and for anything of the wrong type.
    """

    def __init__(self, tracks: Mapping[str, Track], events: Iterable[tuple[float, str]] = (),
                 loop: bool = False):
        loop = checks.boolean('loop', loop)
        checks.require(isinstance(tracks, Mapping), 'tracks', 'a dict of names and Tracks', tracks)
        for name, track in tracks.items():
            checks.require(isinstance(name, str), 'name of a track', 'a text', name)
            checks.instance(f'track {checks.shown(name)}', track, Track)
        events = [_event(event) for event in checks.listed('events', events)]
        self.tracks = dict(tracks)
        keys = [(time, name) for name, track in self.tracks.items() for time in track.times]
        self._marks = sorted([*keys, *events])
        self._times = [time for time, _ in self._marks]
        self.begin = min([0.0, *self._times[:1]])
        self.end = max(self._times, default=0.0)
        self.length = self.end - self.begin
        self.loop = loop and self.length > 0.0
        if self.loop and self.length < SHORTEST_ROUND:
            raise ValueError(f'a loop must take at least {SHORTEST_ROUND:g} s; its last key or '
                             f'event is at {checks.text(self.end)} s')
        if self.loop:
            self.tracks = {name: track.repeated(self.begin, self.end)
                           for name, track in self.tracks.items()}
        # A mark at the end of a round and at its beginning is crossed once.
        self._at_end = {name for time, name in self._marks if time == self.end}

    def at(self, time: float) -> dict[str, object]:
        """Return {track name: value at `time` [s]}."""
        local = self.local(time)
        return {name: track.at(local) for name, track in self.tracks.items()}

    def value(self, name: str, time: float) -> object:
        """Return one track's value at `time` [s]; raises ValueError where there is no track."""
        checks.require(isinstance(name, str) and name in self.tracks, 'name', 'that of a track',
                       name)
        return self.tracks[name].at(self.local(time))

    def local(self, time: float) -> float:
        """
        Return the time within a round [s]: time itself where nothing loops.

        Where a round ends and the next begins it is the end's.
        """
        time = checks.moment('time', time)
        if not self.loop:
            return time
        lap = max(math.ceil((time - TIME_TOLERANCE - self.end) / self.length), 0)
        return time - lap * self.length

    def crossed(self, after: float, until: float) -> list[tuple[float, str]]:
        """
        Return [(time [s], name)] of the keys and events in (after, until] [s], in their order.

        In a loop the end of one round is the beginning of the next: a mark on both counts once.
        A mark within TIME_TOLERANCE of an edge is at it. Raises ValueError for a span in which so
        many rounds play that there may be more than MOST_CROSSED.
        """
        after, until = checks.moment('after', after), checks.moment('until', until)
        found = []
        for lap in self._laps(after, until):
            shift = lap * self.length
            # Compared is the mark's own time, lap and all, which is the same for every frame:
            # one rounding more and frames at the end of a round would lose or double marks.
            first, last = (
                bisect.bisect_right(self._times, edge + TIME_TOLERANCE,
                                    key=lambda time: shift + time)
                for edge in (after, until))
            found += [(shift + time, name) for time, name in self._marks[first:last]
                      if lap == 0 or time > self.begin or name not in self._at_end]
        return found

    def _laps(self, after, until):
        """Return the rounds that may have marks in (after, until], one more at either side."""
        if not self.loop:
            return range(1)
        laps = range(max(int((after - self.begin) // self.length) - 1, 0),
                     int((until - self.begin) // self.length) + 2)
        checks.require(len(laps) * len(self._marks) <= MOST_CROSSED, 'until',
                       f'at most {MOST_CROSSED // len(self._marks)} rounds of the loop after '
                       f'{checks.text(after)} s', until)
        return laps


def _event(event):
    """Return an event; raise ValueError unless it is a time and a text."""
    checks.require(isinstance(event, (tuple, list)) and len(event) == 2, 'each of events',
                   'a time [s] and a name', event)
    time, name = event
    checks.require(isinstance(name, str), 'name of an event', 'a text', name)
    return checks.finite(f'time of the event {checks.shown(name)}', time), name
