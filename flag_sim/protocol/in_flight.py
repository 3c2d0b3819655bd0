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
import dataclasses


@dataclasses.dataclass
class Sent:
    """A frame that was sent: its place, its message, who has not done it yet, and when it left."""

    frame: object
    message: object
    waiting_for: set
    first_time: float  # of a steady clock [s]
    last_time: float


class FramesInFlight:
    """The frames in flight, oldest first."""

    def __init__(self):
        self._frames = {}  # by stamp; a dict keeps the order of sending

    def __len__(self):
        return len(self._frames)

    def __contains__(self, stamp):
        return stamp in self._frames

    @property
    def oldest(self):
        """Return the oldest frame in flight, or None."""
        return next(iter(self._frames.values()), None)

    def send(self, frame, message, consumers, now):
        """
        Note that a frame was sent at `now` [s] and is done when all `consumers` say so.

        A frame that nobody is waited for is done at once.
        """
        if consumers:
            self._frames[frame.stamp] = Sent(frame, message, set(consumers), now, now)

    def done(self, stamp, consumer):
        """Note that `consumer` has served the frame; return whether that made it done."""
        sent = self._frames.get(stamp)
        if sent is None:
            return False
        sent.waiting_for.discard(consumer)
        if sent.waiting_for:
            return False
        del self._frames[stamp]
        return True

    def wait_for(self, consumers):
        """
        Let the frames in flight be done when all `consumers` say so, from now on.

        Who has said so already is asked again with the frame's next copy.
        """
        for sent in self._frames.values():
            sent.waiting_for = set(consumers)
        if not consumers:
            self.clear()

    def overdue(self, now, after):
        """Return the oldest frame if it last left more than `after` s before `now`, or None."""
        sent = self.oldest
        return sent if sent is not None and now - sent.last_time > after else None

    def give_up(self):
        """Forget the oldest frame."""
        del self._frames[self.oldest.frame.stamp]

    def clear(self):
        """Forget every frame."""
        self._frames.clear()
