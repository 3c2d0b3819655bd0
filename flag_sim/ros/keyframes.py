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

"""Keys and events as messages on `keyframe`: each once, in their order."""
import collections

from flag_sim.animation.timeline import Timeline
from flag_sim.animation.tracks import TIME_TOLERANCE
from flag_sim.ros import messages
from flag_sim.ros.guard import GuardedPublisher

MAX_CROSSED = 4096
"""Keys and events that are announced with one frame; of more the latest."""


class Keyframes:
    """The keys and events that are to be announced; what could not be sent is kept."""

    def __init__(self):
        self._waiting = collections.deque(maxlen=MAX_CROSSED)

    def clear(self) -> None:
        """Forget those of the take before."""
        self._waiting.clear()

    def cross(self, timeline: Timeline, previous: int, at: int, offset: int) -> None:
        """
        Take note of what takes effect in the frame that is `at` [ns] in the take.

        previous: when the frame before was [ns]; offset: of stamps [ns]. A key at the frame's
        time gets exactly the frame's stamp, despite rounding. Raises ValueError for a frame in
        which there are too many.
        """
        for key, name in timeline.crossed(previous / 1e9, at / 1e9):
            is_now = key >= at / 1e9 - TIME_TOLERANCE
            self._waiting.append(messages.header(
                offset + (at if is_now else round(key * 1e9)), name))

    def publish(self, publisher: GuardedPublisher) -> None:
        """Send them; what cannot be sent leaves with the next frame."""
        while self._waiting and publisher.publish(self._waiting[0]):
            self._waiting.popleft()
