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

"""How much memory Python code keeps, as tracemalloc sees it."""
import tracemalloc

OTHERS = ('*/execnet/*', '*/xdist/*', tracemalloc.__file__)
"""Files of the tests' own runner, whose other thread is sent work at any time."""


def traced() -> int:
    """Return what was allocated since tracemalloc was started, and is kept [bytes]."""
    snapshot = tracemalloc.take_snapshot().filter_traces(
        [tracemalloc.Filter(False, name) for name in OTHERS])
    return sum(one.size for one in snapshot.statistics('filename'))
