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

"""Hysteresis: a condition is reported when it begins and when it has ended, not in between."""


class Hysteresis:
    """
    A condition that may come and go with every frame.

    It is on from the first frame in which it is met until it has not been met for `calm` seconds
    of simulated time; what comes back before that is the same occurrence.
    """

    def __init__(self, calm: float):
        self._calm = calm
        self._absent = 0.0  # how long it has not been met [s]
        self.is_on = False

    def update(self, is_met: bool, dt: float) -> tuple[bool, bool]:
        """Return (begins, ends) for a frame of dt [s] in which the condition is met or not."""
        self._absent = 0.0 if is_met else self._absent + dt
        begins = is_met and not self.is_on
        ends = self.is_on and self._absent >= self._calm
        self.is_on = (self.is_on or is_met) and not ends
        return begins, ends
