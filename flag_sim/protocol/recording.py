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

"""Recording: which messages of which frames are in a bag, and at what time in it."""
import collections
from collections.abc import Collection, Hashable
import enum

from flag_sim.protocol.frames import Arrival, FrameId, FrameOrder

REMEMBERED_FRAMES = 1024
"""Number of latest frames whose copies are recognised."""
REMEMBERED_TAKES = 8
"""Number of earlier takes that may go on: how many frames of each are complete is kept."""
TAKE_GAP = 100_000_000
"""Time in the bag between two takes [ns]."""
LATEST = 2**63 - 1
"""Latest time that rosbag2 can hold, as its times are signed [ns]."""


class Placement(enum.Enum):
    """What becomes of a message that has arrived."""

    WRITE = enum.auto()   # it is written into the bag
    ANSWER = enum.auto()  # its frame is complete, but the sender has not received that
    IGNORE = enum.auto()  # it is a copy, or comes after the end


class Recording:
    """
    The frames of a bag.

    every_frame: the topics that are recorded of which every frame has one message; with one of
    each a frame is complete. length: of the take with which it is full [frames]; 0: without end.
    complete: how many frames are; in_take: of the present take in all its rounds, without those of
    a stranger who sends no take; copies: how many messages were left out because they are recorded
    already; takes: how many have begun.
    The time of a message in the bag is its stamp. After a reset the time in the bag goes on: it is
    later than the stamp if the new take's stamps are not later than those of the take before.
    """

    def __init__(self, every_frame: Collection[str], length: int = 0):
        self._every_frame = set(every_frame)
        self._length = length
        self._missing: dict[int, set[str]] = {}  # topics by stamp, of frames not complete
        self._latest = collections.OrderedDict()  # stamps of the latest complete frames
        # {stamp: whether it has a take} of the take's latest parameters
        self._followed = collections.OrderedDict()
        self._take = None  # number of the present take
        self._in_takes = collections.OrderedDict()  # {number: complete frames} of those before it
        self._order = FrameOrder()
        self._held = None  # parameters that are a late copy or begin a round: the next ones decide
        self._offset = self._newest = 0  # of times in the bag [ns]
        self._lost = 0
        self.complete = self.in_take = self.copies = self.takes = 0

    @property
    def has_all_frames(self) -> bool:
        """Return whether the present take has as many complete frames as were asked for."""
        return 0 < self._length <= self.in_take

    @property
    def outstanding(self) -> int:
        """Return how many frames the newest take lacks to be full; 0 before it has any."""
        return max(self._length - self.in_take, 0) if self.takes or self.complete else 0

    @property
    def incomplete(self) -> int:
        """Return how many frames have begun to arrive and are not complete."""
        return self._lost + len(self._missing)

    def follow(self, frame: FrameId, data: bytes, sender: Hashable) -> list[bytes]:
        """
        Detect from a frame's serialised parameters whether another take begins.

        The stamps of a new take are no copies of earlier ones. Return the messages to record now:
        `data`, and what was held back before it.
        """
        if frame.take is None:
            self._note(frame.stamp, self._followed.get(frame.stamp, False))
            return [data]
        held, self._held = self._held, None
        arrival = self._order.arrive(frame, sender)
        first = min(self._order.waiting.values(), default=frame)
        is_round = arrival is Arrival.RESTART and len(self._order.waiting) > 1
        self.copies += held is not None and not is_round
        if arrival is Arrival.STALE:
            self._held = data
            return []
        while self._order.next_frame() is not None:
            pass  # its turn is all the same here, but a take that is played again is known by it
        if arrival is Arrival.RESTART:
            self._begin_take(frame.take, first.stamp)
            if is_round:
                self._count(first.stamp)
        self._count(frame.stamp)
        return [held, data] if is_round else [data]

    def _count(self, stamp):
        """Note that the parameters of the take's frame at `stamp` [ns] have come."""
        if not self._followed.get(stamp):
            self.in_take += stamp in self._latest
            self._note(stamp, True)

    def _note(self, stamp, has_take):
        self._followed[stamp] = has_take
        if len(self._followed) > REMEMBERED_FRAMES:
            self._followed.popitem(last=False)

    def _begin_take(self, number, stamp):
        """Let a take whose first frame has `stamp` [ns] follow in the bag after the one before."""
        # Images of the first take may come before its parameters: they belong to it.
        if self.takes:
            self._offset = max(self._newest + TAKE_GAP - stamp, 0)
            self._lost += len(self._missing)
            self._missing.clear()
            self._latest.clear()
            self._followed.clear()
            if number != self._take:
                self._in_takes[self._take] = self.in_take
                if len(self._in_takes) > REMEMBERED_TAKES:
                    self._in_takes.popitem(last=False)
        if number != self._take:
            # Late messages of an older take may have come between the frames of this one.
            self.in_take = self._in_takes.pop(number, 0)
        self._take = number
        self.takes += 1

    def is_early(self, topic: str, stamp: int) -> bool:
        """
        Return whether a message has come before its frame's parameters, in a take after the first.

        It may be a late one of the take before, which had a frame of the same stamp: then it comes
        before what its sender makes of the new take's earlier frames.
        """
        return (self.takes > 1 and topic in self._every_frame and topic != 'parameters'
                and stamp not in self._followed and stamp not in self._latest)

    def place(self, topic: str, stamp: int) -> Placement:
        """
        Return what becomes of a message of a topic with a stamp [ns].

        Raises ValueError for a stamp that the bag cannot hold.
        """
        if stamp < 0:  # a bag counts its times from 0
            raise ValueError(f'its stamp {stamp / 1e9} s is before 0')
        if self.time(stamp) > LATEST:
            raise ValueError(f'its stamp {stamp / 1e9} s after {self.takes - 1} takes is later '
                             f'than a bag can hold, {LATEST / 1e9} s')
        if topic not in self._every_frame:
            return Placement.IGNORE if self.has_all_frames else Placement.WRITE
        if stamp in self._latest:
            self.copies += 1
            # Only parameters tell their take: others may be early ones of the next, not copies.
            return Placement.IGNORE if self.takes and topic != 'parameters' else Placement.ANSWER
        if len(self._latest) == REMEMBERED_FRAMES and stamp < next(iter(self._latest)):
            self.copies += 1
            return Placement.IGNORE
        if self.has_all_frames:
            return Placement.IGNORE
        missing = self._missing.get(stamp)
        if missing is None:
            self._make_room()
            missing = self._missing[stamp] = set(self._every_frame)
        if topic not in missing:
            self.copies += 1
            return Placement.IGNORE
        missing.discard(topic)
        return Placement.WRITE

    def _make_room(self):
        """Of many incomplete frames forget one, first one of which no parameters told."""
        if len(self._missing) >= REMEMBERED_FRAMES:
            stranger = (stamp for stamp in self._missing if stamp not in self._followed)
            del self._missing[next(stranger, next(iter(self._missing)))]
            self._lost += 1

    def is_complete(self, stamp: int) -> bool:
        """Return whether a frame of the newest take is one of the latest complete ones."""
        return stamp in self._latest

    def time(self, stamp: int) -> int:
        """Return the time in the bag [ns] of a message of the current take with a stamp [ns]."""
        return stamp + self._offset

    def written(self, topic: str, stamp: int) -> bool:
        """Note that a message was written; return whether its frame is complete with it."""
        self._newest = max(self._newest, self.time(stamp))
        if topic not in self._every_frame or self._missing[stamp]:
            return False
        del self._missing[stamp]
        self._latest[stamp] = None
        if len(self._latest) > REMEMBERED_FRAMES:
            self._latest.popitem(last=False)
        self.complete += 1
        self.in_take += not self.takes or self._followed.get(stamp, False)
        return True

    def lacking(self) -> tuple[int, set[str]] | None:
        """Return (stamp [ns], missing topics) of the first frame after the last complete one."""
        last = next(reversed(self._latest), -1)
        stamp = min((stamp for stamp in self._missing if stamp > last), default=None)
        return None if stamp is None or self.has_all_frames else (stamp, self._missing[stamp])
