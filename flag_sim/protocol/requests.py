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

"""What people have asked of a wind that has to wait for frames in flight: a reset, steps."""


class Requests:
    """
    The reset and the single steps that were asked for and are not done yet.

    steps: how many. In lockstep they leave as the window has room, as all frames do.
    """

    def __init__(self):
        self.steps = 0
        self._reset_since = None  # steady time at which a reset was asked for [s]

    @property
    def is_reset_asked(self) -> bool:
        """Return whether a reset waits."""
        return self._reset_since is not None

    def reset(self, now: float) -> None:
        """
        Ask for a reset at steady time `now` [s], which replaces what was asked for before.

        A further one before the first is done does not put it off.
        """
        self.steps = 0
        if self._reset_since is None:
            self._reset_since = now

    def begins_take(self, is_idle: bool, now: float, patience: float) -> bool:
        """
        Return whether a reset that was asked for is done now; it then is.

        is_idle: whether nothing is in flight; patience: the longest wait for that [s].
        """
        if self._reset_since is None or not (is_idle or now - self._reset_since > patience):
            return False
        self._reset_since = None
        return True
