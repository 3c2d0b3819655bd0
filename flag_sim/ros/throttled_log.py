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

"""What a node says about what it waits for, and about messages that it cannot use."""
import re
import time

LOOK_AGAIN = 0.5  # between looks at what is missing [s]
PATIENCE = 2.0  # that nothing is said about: frames come late while others start [s]
WARN_EVERY = 5.0  # between warnings of one kind [s]
MOST_KINDS = 8  # of warnings within that time: a broken sender must not fill the log


class Waiting:
    """
    Says what a node waits for once it has waited for PATIENCE, and once more when that ends.

    missing(): returns in words what the node waits for, or '' if for nothing; served(): how many
    frames it has served: with every frame its patience begins anew.
    """

    def __init__(self, node, missing, served):
        self._logger = node.get_logger()
        self._missing = missing
        self._served = served
        self._since = None  # steady time at which the present wait began [s]
        self._frames = 0
        self._has_said = False
        node.create_timer(LOOK_AGAIN, self._look)

    def _look(self):
        now = time.monotonic()
        has_served, self._frames = self._served() != self._frames, self._served()
        missing = self._missing()
        if has_served or not missing:
            if self._has_said:
                ends = 'frames are served again' if has_served else 'nothing is waited for now'
                self._logger.info(f'{ends}, after {now - self._since:.1f} s')
            self._since, self._has_said = None, False
        if missing and self._since is None:
            self._since = now
        elif missing and not self._has_said and now - self._since >= PATIENCE:
            self._logger.warning(f'waiting for {now - self._since:.1f} s for {missing}')
            self._has_said = True


class Refusals:
    """
    Tells which refusals to log: a reason that is new at once, the same again only now and then.

    Reasons that differ in their numbers alone are the same.
    """

    def __init__(self):
        self._said = {}  # steady time [s] at which a reason was logged last

    def is_worth_saying(self, reason, now):
        """Return whether to log a reason at steady time `now` [s]; it then counts as logged."""
        reason = re.sub(r'[\d.]+', '', reason)
        self._said = {r: at for r, at in self._said.items() if now - at < WARN_EVERY}
        if reason in self._said or len(self._said) >= MOST_KINDS:
            return False
        self._said[reason] = now
        return True
