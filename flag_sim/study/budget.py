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

"""The user's minutes, shared among the parts of a study."""
import sys
import time


class Budget:
    """
    The time that one part of a study has.

    seconds: of it. A part measures its rows in the order of their importance, each only while
    `allows`; so a shorter study has the first rows of a longer one.
    """

    def __init__(self, name, seconds, clock=time.monotonic, out=None):
        self.name = name
        self._clock = clock
        self._end = clock() + seconds
        self._out = out

    def left(self):
        """Return the seconds that are left, negative when overdrawn."""
        return self._end - self._clock()

    def allows(self, seconds=0.0):
        """Return whether something that takes some seconds may still begin."""
        return self.left() > seconds

    def say(self, text):
        """Print how far the part has come."""
        print(f'{self.name} ({max(self.left(), 0.0):.0f} s left): {text}',
              file=self._out or sys.stderr, flush=True)


def share(seconds, parts):
    """
    Yield (part, Budget) for parts [(part, name, share)] that run one after the other.

    Each gets its share of what is then left, so that what one does not use is of use to the next.
    """
    end = time.monotonic() + seconds
    shares = [size for _, _, size in parts]
    for number, (part, name, size) in enumerate(parts):
        yield part, Budget(name, (end - time.monotonic()) * size / sum(shares[number:]))
