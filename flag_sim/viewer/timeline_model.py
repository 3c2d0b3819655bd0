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

"""The wind's tracks as the timeline shows and edits them. No Qt."""
from collections.abc import Callable, Mapping
import contextlib
import dataclasses

from flag_sim.animation.timeline import nearest_frame, Timeline
from flag_sim.animation.tracks import Track
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.exchange import FramePlace
from flag_sim.viewer.graph_model import GraphModel
from flag_sim.viewer.key_edits import changes_of, Keys, read_keys, usual_law
from flag_sim.viewer.timeline_geometry import span_of
from flag_sim.viewer.undo import AUTOKEY, Edit, History

EDITED = ('tracks', 'keys.')
"""How the names of parameters begin that edits change."""
SHOWN = (*EDITED, 'events.', 'loop')
"""How the names of parameters begin that the timeline shows."""


@dataclasses.dataclass(frozen=True)
class Row:
    """
    One track: its keys, what it animates, and its curve.

    track: None where the keys cannot be played. span: values from below to above the keys, None
    where they are no numbers.
    """

    name: str
    keys: Keys
    descriptor: Descriptor
    track: Track | None
    span: tuple[float, float] | None

    @property
    def components(self) -> list:
        """Return which numbers of a key have a curve: [None] for a single one."""
        if self.span is None:
            return []
        return [*range(len(self.keys.values[0]))] if self.is_vector else [None]

    @property
    def is_vector(self) -> bool:
        """Return whether a key is a list of numbers."""
        return isinstance(self.keys.values[0], list)

    def value_at(self, time: float) -> object:
        """Return what the track plays at a time of the shot [s]."""
        if self.track is None:
            return self.keys.values[0]
        value = self.track.at(time)
        return [*value] if self.is_vector else value


class TimelineModel:
    """
    Reads the rows from the wind's parameters, and sets them as edits ask.

    say(text): tells why an edit was refused, and '' once one is made. on_change: functions called
    when what is shown has changed.
    """

    def __init__(self, graph: GraphModel, say: Callable[[str], None]):
        self._graph = graph
        self._say = say
        self._known = {}    # the wind's parameters of EDITED, as they were last
        self._asked = {}    # those that edits have asked for, until they are heard of
        self._under_way = 0  # edits that the wind has not answered
        self._later = []     # undo and redo that were asked for meanwhile
        self.history = History()
        self.rows = []
        self.events = []    # (time [s], name)
        self.timeline = Timeline({})
        self.on_change = []
        graph.on_nodes.append(self._read)
        graph.on_values.append(self._take_values)

    # Reading.

    @property
    def _told(self):
        return self._graph.values.get(self._graph.nodes.get('wind'), {})

    @property
    def _values(self):
        """Return what the wind will have once it has done what was asked of it."""
        return {name: value for name, value in {**self._told, **self._asked}.items()
                if value is not None}

    def row(self, name: str) -> Row | None:
        """Return the row of a track."""
        return next((row for row in self.rows if row.name == name), None)

    def _take_values(self, role, names):
        if role == 'wind' and any(name.startswith(SHOWN) for name in names):
            self._notice({name for name in names if name.startswith(EDITED)})
            self._read()

    def _notice(self, names):
        """Keep the history true where somebody else, or autokey, has changed keys."""
        values = self._told
        own = {name for name in names
               if name in self._asked and self._asked[name] == values.get(name)}
        for name in own:
            del self._asked[name]
        others = {name for name in names - own if values.get(name) != self._known.get(name)}
        if not others:
            return
        if values.get('autokey'):
            self.history.add(Edit(AUTOKEY, {name: self._known.get(name) for name in others},
                                  {name: values.get(name) for name in others}))
        else:
            self.history.forget(others)

    def _read(self):
        values = self._values
        self._known = {name: value for name, value in self._told.items()
                       if name.startswith(EDITED)}
        rows = [self._row(name, values) for name in values.get('tracks') or []]
        self.rows = [row for row in rows if row is not None]
        self.events = [*zip(values.get('events.times') or [], values.get('events.names') or [])]
        self.timeline = Timeline({})
        with contextlib.suppress(ValueError):  # what cannot be played is shown nevertheless
            self.timeline = Timeline({row.name: row.track for row in self.rows if row.track},
                                     self.events, values.get('loop') is True)
        for listener in self.on_change:
            listener()

    def _row(self, name, values):
        role, _, parameter = name.partition('.')
        descriptor = self._graph.descriptor(role, parameter) or Descriptor(parameter)
        flat, times = values.get(f'keys.{name}.values'), values.get(f'keys.{name}.times')
        length = descriptor.length
        if length is None and flat and times and len(flat) != len(times):
            length = len(flat) // len(times)  # its node is not there to tell
        keys = read_keys(values, name, usual_law(descriptor, flat), length)
        if keys is None:
            return None
        old = self.row(name)
        if old is not None and (old.keys, old.descriptor) == (keys, descriptor):
            return old  # thousands of keys take a while
        track = None
        with contextlib.suppress(ValueError):
            track = Track(keys.times, keys.values, keys.laws, descriptor.is_direction, keys.turns)
        numbers = [one for value in keys.values
                   for one in (value if isinstance(value, list) else [value])]
        is_number = all(type(one) in (int, float) for one in numbers)
        return Row(name, keys, descriptor, track, span_of(numbers) if is_number else None)

    def extent(self) -> tuple[float, float]:
        """Return from when to when there is something to show [s]."""
        end = max(self.timeline.end, *(row.keys.times[-1] for row in self.rows), 1.0)
        return min(self.timeline.begin, 0.0), end

    def playhead(self, stamp: int | None, place: FramePlace | None) -> float | None:
        """
        Return when in the shot a picture with a stamp [ns] is [s]; None before there is one.

        Stamps of a simulation begin at stamp.start; those of the wall clock say nothing of the
        shot, in which frame n is at n / rate.
        """
        if stamp is None:
            return None
        if self._values.get('stamp.clock') == 'wall':
            if place is None or place.index is None:
                return None
            time = place.index / (self._values.get('rate') or 30.0)
        else:
            time = stamp / 1e9 - (self._values.get('stamp.start') or 0.0)
        return self.timeline.local(time)

    @property
    def frame(self) -> float:
        """Return how long a frame takes [s]."""
        return 1.0 / (self._values.get('rate') or 30.0)

    def at_frame(self, time: float) -> float:
        """Return the time of the frame nearest to a time [s]."""
        return nearest_frame(time, self._values.get('rate') or 30.0)

    # Edits.

    def move(self, name: str, k: int, time: float, value: object) -> None:
        """Give a key another time [s] and value."""
        row = self.row(name)
        self._edit('move a key', name, row.keys.moved(k, time, value)[0])

    def set_law(self, name: str, k: int, law: str) -> None:
        """Give the segment that a key begins another law."""
        self._edit(f'law {law}', name, self.row(name).keys.with_law(k, law))

    def delete(self, name: str, k: int) -> None:
        """Delete a key, and with the last one the track."""
        self._edit('delete a key', name, self.row(name).keys.without(k))

    def delete_track(self, name: str) -> None:
        """Delete a track with all its keys."""
        self._edit('delete a track', name, None)

    def add(self, name: str, time: float) -> int:
        """Add a key where a track is at a time [s], so that nothing moves; return its place."""
        keys = self.row(name).keys
        value = self.row(name).value_at(time)
        keys = keys.having(time, value, keys.law_at(time))
        self._edit('add a key', name, keys)
        return keys.times.index(time)

    def key_parameter(self, role: str, parameter: str, time: float) -> None:
        """Add a key of the value that a parameter has, and a track for it if there is none."""
        name = f'{role}.{parameter}'
        descriptor = self._graph.descriptor(role, parameter)
        value = self._graph.wanted(role, parameter)
        if descriptor is None or value is None:
            return
        value = float(value) if descriptor.kind == 'int' else value
        row = self.row(name)
        if row is not None:
            self._edit('add a key', name, row.keys.having(time, value, row.keys.law_at(time)))
        else:
            self._edit('add a track', name,
                       Keys([time], [value], [usual_law(descriptor, None)]))

    def _edit(self, words, name, keys):
        changes = changes_of(self._values, name, keys)
        before = {name: self._values.get(name) for name in changes}
        edit = Edit(words, before, changes)
        self._put(changes, lambda: self.history.add(edit))

    def load(self, words: str, changes: Mapping, on_answer: Callable[[str], None]) -> None:
        """
        Set parameters {name: value} of the wind, all or none, as one edit.

        words: what it was; on_answer(reason): called once, '' where they are set.
        """
        before = {name: self._values.get(name) for name in changes}

        def then():
            self.history.add(Edit(words, before, dict(changes)))
            on_answer('')
        self._put(changes, then, on_answer)

    def undo(self) -> None:
        """Undo the last edit, or the one before if it is being undone."""
        if self._under_way:
            self._later.append(self.undo)
            return
        edit = self.history.next_undo
        if edit is not None:
            self._put(edit.before, self.history.undone)

    def redo(self) -> None:
        """Make the edit again that was undone last."""
        if self._under_way:
            self._later.append(self.redo)
            return
        edit = self.history.next_redo
        if edit is not None:
            self._put(edit.after, self.history.redone)

    def _put(self, changes, then, refused=None):
        """Set parameters of the wind, all or none; call `then` once they are set."""
        self._asked.update({name: value for name, value in changes.items()
                            if name.startswith(EDITED)})
        self._under_way += 1

        def answer(reason):
            self._under_way -= 1
            if reason:
                self._asked = {name: value for name, value in self._asked.items()
                               if name not in changes}
                self._later.clear()
                (refused or self._say)(reason)
            else:
                self._say('')
                then()
            self._read()  # what was dragged goes back
            while self._later and not self._under_way:
                self._later.pop(0)()
        self._graph.put_together('wind', changes, answer)
        self._read()
