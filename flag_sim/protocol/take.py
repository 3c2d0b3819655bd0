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

"""A take: one run of a shot, from its first frame to its last."""
from flag_sim.protocol.clock import FrameClock
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.in_flight import FramesInFlight


class Take:
    """
    The frames of a take, one after another.

    number: see frames.next_take. clock: of the take, which knows the next frame. length: of the
    take [frames], 0 for one without end; it may be changed. latest: stamp after which there can
    be none [ns]. previous: when in the take the last frame was [ns], below 0 before the first.
    """

    def __init__(self, number: int, clock: FrameClock, length: int, latest: int):
        self.number = number
        self.clock = clock
        self.length = length
        self._latest = latest
        self.previous = -10  # so that a key at 0 lies between it and frame 0

    @property
    def is_beyond(self) -> bool:
        """Return whether the next frame's stamp is later than a message can hold."""
        return self.clock.stamp > self._latest

    @property
    def is_over(self) -> bool:
        """Return whether the last frame was sent."""
        return 0 < self.length <= self.clock.index or self.is_beyond

    def skip_to(self, now: float) -> int:
        """Go on to the frame that is due at steady time `now` [s]; return how many are skipped."""
        due = self.clock.due(now)
        if self.length:
            due = min(due, self.length - 1)
        skipped = due - self.clock.index
        self.clock.index = due
        return skipped

    def oldest_index(self, in_flight: FramesInFlight) -> int:
        """Return the oldest frame that may be asked for again: in flight, or the next one."""
        sent = in_flight.oldest
        return self.clock.index if sent is None else sent.frame.index

    def has_room(self, in_flight: FramesInFlight, window: int) -> bool:
        """
        Return whether the next frame may leave in lockstep.

        window: frames from the oldest in flight on; 1 at first, because what is sent before the
        nodes have discovered one another may be lost.
        """
        window = window if in_flight.answered else 1
        return not self.is_over and self.clock.index - self.oldest_index(in_flight) < window

    def next_id(self, oldest: int | None = None) -> FrameId:
        """Return the next frame; oldest: the one that may still be waited for, itself if None."""
        index = self.clock.index
        return FrameId(self.clock.stamp, self.number, index, index if oldest is None else oldest)

    def sent(self) -> None:
        """Go on to the following frame, as the next one was sent."""
        self.previous = self.clock.time
        self.clock.index += 1
