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

"""The messages of a bag grouped into frames by their stamps, whenever they were received."""
from collections.abc import Collection, Iterable, Iterator
import dataclasses

from flag_sim.protocol.cdr import serialized_stamp

LOOKAHEAD = 32
"""
Frames that are read ahead for what belongs to the first of them.

That is more than wait on their way from the wind to an image, in the queues of physics and
renderer and in their hands.
"""


@dataclasses.dataclass
class RecordedFrame:
    """
    The messages of one frame [(name, serialised)], in the bag's order, which are sent together.

    stamp: the frame's [ns]; None: messages that belong to no frame. missing: names of topics whose
    message has not been read yet; lost: of those that the bag does not hold. trouble: why the
    message cannot be put into a frame, or ''.
    """

    stamp: int | None
    messages: list[tuple[str, bytes]]
    missing: set[str] = dataclasses.field(default_factory=set)
    lost: set[str] = dataclasses.field(default_factory=set)
    trouble: str = ''


def recorded_frames(messages: Iterable[tuple[str, int, bytes]],
                    every_frame: Collection[str]) -> Iterator[RecordedFrame]:
    """
    Yield the RecordedFrames of (name, time in the bag, serialised message), in the bag's order.

    every_frame: the topics among those that are read that have a message for every frame. Topics
    of one frame may be far apart and in any order, as a recorder that knows nothing of frames
    receives them; takes may follow one another. Copies of messages, sent again because an answer
    was late, are frames of their own. What belongs to no frame goes with the one before it.
    Raises ValueError where `messages` do, once all that was read before is yielded.
    """
    ahead: list[RecordedFrame] = []
    failure = None
    try:
        for name, _, data in messages:
            _put(ahead, set(every_frame), name, data)
            while ahead and (not ahead[0].missing or len(ahead) > LOOKAHEAD):
                yield _closed(ahead.pop(0))
    except ValueError as error:
        failure = error
    yield from map(_closed, ahead)
    if failure is not None:
        raise failure


def _put(ahead, every_frame, name, data):
    """Put a message into the frame that it belongs to, or begin another one."""
    if name not in every_frame:
        if not ahead:
            ahead.append(RecordedFrame(None, []))
        ahead[-1].messages.append((name, data))
        return
    try:
        stamp = serialized_stamp(data)
    except ValueError as error:
        ahead.append(RecordedFrame(None, [(name, data)],
                                   trouble=f'a message on {name} belongs to no frame: {error}'))
        return
    place = next((place for place, frame in enumerate(ahead)
                  if frame.stamp == stamp and name in frame.missing), len(ahead))
    if place == len(ahead):
        ahead.append(RecordedFrame(stamp, [], set(every_frame)))
    ahead[place].messages.append((name, data))
    ahead[place].missing.discard(name)
    for frame in ahead[:place]:  # the topic has gone past them; a copy of an older one has not
        if name in frame.missing and stamp > frame.stamp:
            frame.missing.discard(name)
            frame.lost.add(name)


def _closed(frame):
    frame.lost |= frame.missing
    frame.missing = set()
    return frame
