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

"""Frames in flight: what was sent, who has said that it is done, and what is overdue."""
import collections
from collections.abc import Iterable
import dataclasses

from flag_sim.protocol.frames import FrameId

FIRST_RESEND = 0.2
"""Time until a frame is sent again while no node has ever answered (discovery is slow) [s]."""
MOST_GIVEN_UP = 64
"""Number of latest frames given up to which a late answer shows that a consumer is there."""


@dataclasses.dataclass
class Sent:
    """A frame that was sent."""

    frame: FrameId
    message: object
    waiting_for: set[str]  # consumers that have not said that it is done
    first_time: float      # of a steady clock [s]
    last_time: float


class FramesInFlight:
    """
    The frames in flight, oldest first.

    answered: whether a frame has ever been done; resent: how many were sent again. All times are
    of a steady clock [s].
    """

    def __init__(self):
        self.answered = False
        self.resent = 0
        self._frames: dict[int, Sent] = {}  # by stamp; a dict keeps the order of sending
        self._consumers: set[str] = set()  # who was waited for last
        # (stamp, consumers that had not answered) of the latest frames that were given up
        self._given_up = collections.deque(maxlen=MOST_GIVEN_UP)
        self._silent_since = None  # since when frames are in flight and none of them was done

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def oldest(self) -> Sent | None:
        """Return the oldest frame in flight, or None."""
        return next(iter(self._frames.values()), None)

    def send(self, frame: FrameId, message: object, consumers: Iterable[str],
             now: float) -> None:
        """
        Note that a frame was sent at `now` and is done when all `consumers` say so.

        A frame without consumers is done at once.
        """
        self._consumers = consumers = set(consumers)
        if not consumers:
            return
        self._frames[frame.stamp] = Sent(frame, message, set(consumers), now, now)
        if self._silent_since is None:
            self._silent_since = now

    def done(self, stamp: int, consumer: str, now: float) -> bool:
        """Note that `consumer` has served the frame; return whether that made it done."""
        if consumer not in self._consumers:
            return False  # anybody may say so, and nobody was asked
        sent = self._frames.get(stamp)
        if sent is not None:
            sent.waiting_for.discard(consumer)
            if sent.waiting_for:
                return False
            del self._frames[stamp]
            self.answered = True
        elif not any(stamp == known and consumer in names for known, names in self._given_up):
            return False  # no node was asked for that: it must not hide who is silent
        # A consumer is there, even if the frame was given up meanwhile.
        self._silent_since = now if self._frames else None
        return sent is not None

    def wait_for(self, consumers: Iterable[str]) -> None:
        """
        Let the frames in flight be done when all `consumers` say so, from now on.

        Consumers that have said so already are asked again with the frame's next copy.
        """
        self._consumers = consumers = set(consumers)
        for sent in self._frames.values():
            sent.waiting_for = set(consumers)
        if not consumers:
            self.clear()

    def overdue(self, now: float, after: float) -> Sent | None:
        """Return the oldest frame if it last left more than `after` [s] ago, or None."""
        sent = self.oldest
        return sent if sent is not None and now - sent.last_time > after else None

    def resend(self, now: float, after: float) -> Sent | None:
        """
        Return the oldest frame if it is to be sent again now, or None; it then counts as sent.

        That is when it last left more than `after` [s] ago, or FIRST_RESEND if that is less and
        no node has ever answered.
        """
        sent = self.overdue(now, after if self.answered else min(FIRST_RESEND, after))
        if sent is not None:
            sent.last_time = now
            self.resent += 1
        return sent

    def late(self, now: float, after: float) -> list[str]:
        """
        Return the consumers that the oldest frame waits for, if none was done for `after` [s].

        Frames sent while another one was waited for are not late because of that.
        """
        if self.oldest is None or now - self._silent_since <= after:
            return []
        return sorted(self.oldest.waiting_for)

    def give_up(self) -> None:
        """Forget the oldest frame."""
        sent = self.oldest
        self._given_up.append((sent.frame.stamp, frozenset(sent.waiting_for)))
        del self._frames[sent.frame.stamp]

    def make_room(self, window: int) -> int:
        """
        Give up the oldest frames until fewer than `window` are in flight; return their number.

        Frames that are given up while no node has ever answered are not counted.
        """
        surplus = max(len(self) - window + 1, 0)
        for _ in range(surplus):
            self.give_up()
        return surplus if self.answered else 0

    def clear(self) -> None:
        """Forget every frame."""
        self._frames.clear()
        self._silent_since = None
