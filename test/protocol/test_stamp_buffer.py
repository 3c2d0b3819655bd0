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

"""What waits for its frame, by stamp."""
from flag_sim.protocol.stamp_buffer import StampBuffer


def test_the_latest_arrivals_are_kept():
    """Whatever their stamps are; what comes again replaces, and is new."""
    buffer = StampBuffer(3)
    for stamp in (50, 60, 0, 50, 10):
        buffer.put(stamp, f'at {stamp}')
    assert list(buffer) == [0, 10, 50] and len(buffer) == 3
    assert 60 not in buffer


def test_what_is_older_is_forgotten_with_what_is_taken():
    """Its turn does not come any more."""
    buffer = StampBuffer(8)
    for stamp in range(5):
        buffer.put(stamp, stamp)
    assert buffer.take(2) == 2 and list(buffer) == [3, 4]
    buffer.keep({4, 9})
    assert list(buffer) == [4]
