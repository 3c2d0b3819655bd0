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

"""
The order of frames: each served once and in turn, whatever the network does to their messages.

A frame is known by its take (one run of the shot), its index in it, and the oldest frame of the
take that a node may still be waiting for when it was sent. In lockstep no frame from `oldest` on
may be skipped: they are served one after another, and one that was lost is waited for, because it
is sent again. In real time any frame may be skipped (`oldest` is the frame itself).

A frame that is sent although its sender said before that no node waits for it any more is played
again: a looped bag is played in rounds, and no frame of a round is a copy of the round before.
"""
from collections.abc import Callable, Hashable
import enum
import time
from typing import NamedTuple


class FrameId(NamedTuple):
    """What identifies a frame on the wire."""

    stamp: int        # simulation time [ns]
    take: int | None  # later takes have greater numbers; None: unknown, ordered by stamp alone
    index: int        # 0 is the first frame of the take
    oldest: int       # index of the oldest frame that may still be waited for


def next_take(take: int) -> int:
    """
    Return the number of a new take that follows `take`, 0 for the first.

    It is the wall clock's time [ns], so that it also grows across restarts of the sender, unless
    that clock was set back meanwhile.
    """
    return max(take + 1, time.time_ns())


class Arrival(enum.Enum):
    """What a message that has arrived means to its receiver."""

    NEW = enum.auto()      # a frame not seen before: it waits for its turn
    AGAIN = enum.auto()    # a copy of a frame that was served: answer it again
    STALE = enum.auto()    # far behind: a late copy, or the first of a round: the next one decides
    RESTART = enum.auto()  # the first of another take or round: forget everything, then as NEW


def _follows(frame: FrameId, behind: FrameId) -> bool:
    """Return whether a frame comes right after another one, or is the same once more."""
    if frame.take != behind.take:
        return frame.take > behind.take
    # Frames between them may be left out only in real time.
    is_lockstep = any(each.oldest < each.index for each in (behind, frame))
    return behind.index <= frame.index <= (behind.index + 1 if is_lockstep else frame.index)


class FrameOrder:
    """Keeps frames until it is their turn; `arrive` classifies each, `next_frame` returns it."""

    LONGEST_QUEUE = 64  # more than any window; only a broken sender fills it
    LARGEST_WINDOW = 8  # of any sender [frames]; copies of frames farther behind are not asked for
    INSISTENT = 3  # copies in a row of a frame without an answer: its sender waits for it

    def __init__(self):
        self._take = None
        self._sender = None
        self._first = -1  # index of the first frame of this round
        self._last = -1   # index of the last frame that was served
        self._oldest = 0  # index that may still be waited for, as the sender said last
        self._behind = None  # the frame far behind that came last, if none came after it
        self._in_vain = None, 0  # a frame that was asked for in vain, and how often in a row
        self._waiting: dict[int, FrameId] = {}

    def arrive(self, frame: FrameId, sender: Hashable = None) -> Arrival:
        """
        Note a frame that has arrived; return what it is.

        sender: identifies the publisher, or None. A new publisher may play an
        old take again (a bag that is played twice); the same publisher's older frames are copies
        or, where two that are far behind come in a row, the beginning of another round. One alone
        decides nothing: a network that delays messages delivers such copies.
        """
        changed = sender != self._sender
        self._sender = sender
        if frame[:3] != self._in_vain[0]:
            self._in_vain = None, 0
        behind, self._behind = self._behind, None
        if frame.take is None or self._take is None:
            # Without takes, time that jumps back begins anew, as it does everywhere in ROS.
            if frame.take != self._take or self._last < 0 or frame.index < self._last:
                return self._restart(frame)
        elif frame.take > self._take:
            return self._restart(frame)
        elif changed and frame.take < self._take:
            return self._restart(frame)
        elif not changed and self._is_behind(frame, behind):
            if behind is not None and _follows(frame, behind):
                return self._restart(behind, frame)
            self._behind = frame
            return Arrival.STALE
        if frame.index <= self._last:
            self._oldest = max(self._oldest, frame.oldest)
            return self._restart(frame) if changed else Arrival.AGAIN
        self._wait(frame)
        return Arrival.NEW

    def is_insisted(self, frame: FrameId) -> bool:
        """
        Return whether to begin anew with a frame that came AGAIN and has no answer; then it waits.

        It was passed over, or its answer was dropped, because of what somebody else sent under
        the same sender's name. A sender that waits for it sends nothing else, and would for ever.
        """
        _, times = self._in_vain
        self._in_vain = frame[:3], times + 1
        if times + 1 < self.INSISTENT:
            return False
        self._restart(frame)
        return True

    @property
    def has_takes(self) -> bool:
        """Return whether the frames that come tell their take."""
        return self._take is not None

    @property
    def due(self) -> FrameId | None:
        """Return the first frame whose turn it is, ready or not, or None."""
        return next((self._waiting[index] for index in sorted(self._waiting)
                     if self._is_due(self._waiting[index])), None)

    @property
    def waiting(self) -> dict[int, FrameId]:
        """Return {index: frame} of the frames whose turn has not come."""
        return self._waiting

    @property
    def kept(self) -> list[FrameId]:
        """Return all frames that may yet be served: waiting, or far behind."""
        return [*self._waiting.values(), *([self._behind] if self._behind else [])]

    def next_frame(self, is_ready: Callable[[FrameId], bool] = lambda frame: True
                   ) -> FrameId | None:
        """
        Return the next frame whose turn it is and that `is_ready`, or None.

        The frame counts as served from here on; earlier ones that no node waits for are dropped.
        """
        for index in sorted(self._waiting):
            frame = self._waiting[index]
            if is_ready(frame) and self._is_due(frame):
                self._last = index
                self._waiting = {i: t for i, t in self._waiting.items() if i > index}
                return frame
        return None

    def _is_due(self, frame):
        return max(self._oldest, frame.oldest, self._last + 1) >= frame.index

    def _is_behind(self, frame, behind):
        """Return whether a frame cannot be a copy that the take's sender was asked for."""
        if frame.take < self._take:
            return True
        # Rounds that are shorter than a window are known by their first frame.
        is_early = self._first in (frame.index, behind.index if behind is not None else None)
        return frame.index < self._oldest and (
            is_early or frame.index < self._last - self.LARGEST_WINDOW)

    def _restart(self, *frames):
        """Begin a round with the last of `frames`, and those before it of the same take."""
        self._take = frames[-1].take
        self._last, self._oldest, self._waiting = -1, 0, {}
        for frame in frames:
            if frame.take == self._take:
                self._wait(frame)
        self._first = min(self._waiting)
        return Arrival.RESTART

    def _wait(self, frame):
        self._oldest = max(self._oldest, frame.oldest)
        # In the order of arrival: what is dropped is what nobody has sent again for longest.
        known = self._waiting.pop(frame.index, frame)
        self._waiting[frame.index] = (
            known if known.stamp == frame.stamp and known.oldest > frame.oldest else frame)
        if len(self._waiting) > self.LONGEST_QUEUE:
            del self._waiting[next(iter(self._waiting))]
