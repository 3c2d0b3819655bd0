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

"""A throttled log of a node: the same reason is not written with every message."""
import collections
from collections.abc import Callable
import time

from flag_sim.protocol.throttled_log import Entry, RateLimit, Refusals, shortened, Waiting
from rclpy.node import Node

POLL_PERIOD = 0.5
"""How often to check what a node waits for [s]."""


class NodeLog:
    """
    Writes to the log of `node` the entries that protocol.throttled_log lets pass, shortened.

    Each source, a word of the caller's own code such as a topic's name, is throttled by itself:
    whoever fills one silences no other.
    """

    def __init__(self, node: Node):
        self._node = node
        self._logger = node.get_logger()
        self._refusals = collections.defaultdict(Refusals)
        self._limits = collections.defaultdict(RateLimit)

    def write(self, entry: Entry) -> None:
        """Write a line."""
        text = shortened(entry.text)
        # From a line of code of its own each: rclpy lets none change its level.
        if entry.level == 'error':
            self._logger.error(text)
        elif entry.level == 'warning':
            self._logger.warning(text)
        else:
            self._logger.info(text)

    def write_once(self, entry: Entry, source: str = '') -> bool:
        """Write a line, unless the same was written a while ago; return whether it was."""
        is_worth = self._refusals[source].is_worth_logging(entry.text, time.monotonic())
        if is_worth:
            self.write(entry)
        return is_worth

    def write_end(self, entry: Entry, source: str = '') -> None:
        """Write that something is over, of which a source was told; it may be told again soon."""
        self._refusals[source].end_silence()
        self.write(entry)

    def write_few(self, entry: Entry, source: str = '') -> None:
        """Write a line that is new each time, unless there were many a moment ago."""
        if self._limits[source].allows(time.monotonic()):
            self.write(entry)

    def warn(self, reason: str, source: str = '') -> None:
        """Write a warning, unless the same was written a while ago."""
        self.write_once(Entry('warning', reason), source)

    def error(self, reason: str, source: str = '') -> None:
        """Write an error, unless the same was written a while ago."""
        self.write_once(Entry('error', reason), source)

    def watch(self, missing: Callable[[], str], served: Callable[[], int]) -> None:
        """
        Write what the node waits for when that takes long, from now on.

        missing(): what it is, in words, '' for nothing; served(): how many frames it has served.
        """
        waiting = Waiting()

        def look():
            entry = waiting.look(missing(), served(), time.monotonic())
            if entry is not None:
                self.write(entry)
        self._node.create_timer(POLL_PERIOD, look)
