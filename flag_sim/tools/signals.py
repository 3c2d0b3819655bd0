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

"""Signals that ask a program to end, noted while it has processes that it has to end first."""
from collections.abc import Iterator
import contextlib
import signal


@contextlib.contextmanager
def noted_signals() -> Iterator[list[int]]:
    """
    Yield a list to which SIGINT and SIGTERM are added, instead of what they do else.

    What they would raise could come while a process is being started, which nobody would then
    know of. To be used in the main thread.
    """
    noted = []
    before = {number: signal.signal(number, lambda number, _: noted.append(number))
              for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield noted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
