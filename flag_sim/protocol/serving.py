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

"""Serving frames: what arrives waits for its turn, is worked on once, and is answered."""
from collections.abc import Callable, Hashable
from typing import Generic, NamedTuple, TypeVar

from flag_sim.protocol.frames import Arrival, FrameId, FrameOrder

Input = TypeVar('Input')
Answer = TypeVar('Answer')


class Handlers(NamedTuple):
    """
    What whoever serves frames does with them.

    is_ready(frame): whether all that it needs has come. work(frame, input): makes its answer.
    answer(stamp, answer): publishes it, for the first time or again. restart(frame): another take
    or round begins with this frame.
    """

    is_ready: Callable[[FrameId], bool]
    work: Callable[[FrameId, Input], Answer]
    answer: Callable[[int, Answer], None]
    restart: Callable[[FrameId], None]


class FrameServer(Generic[Input, Answer]):
    """
    Serves every frame once, in its turn, and a frame that comes again with the answer it kept.

    order: of the frames. inputs: what came with those that may yet be served. Both are bounded,
    and so are the answers that are kept.
    """

    def __init__(self, handlers: Handlers):
        self.order = FrameOrder()
        self.inputs: dict[FrameId, Input] = {}
        self._handlers = handlers
        self._answers: dict[int, tuple[int, Answer]] = {}  # (index, answer) by stamp

    def __len__(self) -> int:
        """Return how many answers are kept."""
        return len(self._answers)

    def take_frame(self, frame: FrameId, came_with: Input, sender: Hashable) -> None:
        """
        Put a frame where its turn will find it, and serve whatever can be served.

        came_with: what `work` needs of it; sender: whatever tells one publisher from another.
        """
        arrival = self.order.arrive(frame, sender)
        if arrival is Arrival.AGAIN:
            if self.answer_again(frame.stamp) or not self.order.is_insisted(frame):
                return
            arrival = Arrival.RESTART
        self.inputs[frame] = came_with
        self.inputs = {kept: self.inputs[kept] for kept in self.order.kept}
        if arrival is Arrival.STALE:
            return
        if arrival is Arrival.RESTART:
            self._answers.clear()
            self._handlers.restart(min(self.order.waiting.values()))
        self._answers = {stamp: kept for stamp, kept in self._answers.items()
                         if kept[0] >= frame.oldest}
        self.serve()

    def serve(self) -> None:
        """Serve the frames whose turn it is."""
        while (frame := self.order.next_frame(self._handlers.is_ready)) is not None:
            answer = self._handlers.work(frame, self.inputs.pop(frame))
            self._answers[frame.stamp] = frame.index, answer
            if len(self._answers) > FrameOrder.LONGEST_QUEUE:
                del self._answers[next(iter(self._answers))]
            self._handlers.answer(frame.stamp, answer)

    def is_served(self, stamp: int) -> bool:
        """Return whether the answer to the frame at `stamp` [ns] is kept."""
        return stamp in self._answers

    def answer_again(self, stamp: int) -> bool:
        """Publish the answer to a frame that was served; return whether it is still kept."""
        kept = self._answers.get(stamp)
        if kept is not None:
            self._handlers.answer(stamp, kept[1])
        return kept is not None
