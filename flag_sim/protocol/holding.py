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

"""Which frames may go on without what they lack, as nobody waits for them."""
from flag_sim.protocol.frames import FrameId


class Holding:
    """
    Holds frames that lack something, until a later one shows that no node waits for them.

    In lockstep none does: the frames after the one that is held say that it may still be waited
    for, and all of them are held. In real time the next one says that it is not. Each frame is
    decided by the one before it, as the pace may change while something lacks.
    """

    def __init__(self):
        self._last: FrameId | None = None  # of those that were decided
        self._passed: FrameId | None = None

    def may_pass(self, frame: FrameId) -> bool:
        """Return whether a frame that lacks something shall be served without it."""
        if frame == self._passed:
            return True
        last = self._last if self._last is not None and self._last.take == frame.take else None
        passes = last is not None and frame.oldest > last.index
        if passes:
            self._passed = frame
        if last is None or frame.index > last.index:
            self._last = frame
        return passes

    def end(self) -> None:
        """Hold no frame any more: nothing lacks, or another take or round begins."""
        self._last = self._passed = None
