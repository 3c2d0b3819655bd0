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

"""What is told when it begins and when it is over, not each time that it comes and goes."""


class Hysteresis:
    """
    A condition that may come and go with every frame.

    It lasts from the first frame in which it holds until it has not held for `calm` seconds of
    simulated time; what comes back before that is told no second time.
    """

    def __init__(self, calm):
        self._calm = calm
        self._absent = 0.0
        self.lasts = False

    def see(self, holds, dt):
        """Return (begins, ends) for a frame of dt [s] in which it holds or does not."""
        self._absent = 0.0 if holds else self._absent + dt
        begins = holds and not self.lasts
        ends = self.lasts and self._absent >= self._calm
        self.lasts = (self.lasts or holds) and not ends
        return begins, ends
