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

"""A node's stopwatch: its figures are of the time from the first frame to the last."""
from flag_sim.protocol import stopwatch
from flag_sim.protocol.stopwatch import Stopwatch
import pytest


@pytest.fixture
def clock(monkeypatch):
    """Return a list that holds the time [s]."""
    now = [100.0]
    monkeypatch.setattr(stopwatch.time, 'perf_counter', lambda: now[0])
    return now


def spend(watch, clock, activity, seconds):
    """Spend some time [s] on an activity."""
    with watch.measure(activity):
        clock[0] += seconds


def test_what_comes_before_the_first_frame_does_not_count(clock):
    """As a part of it that waits for others, whose kernels compile, and the first work itself."""
    watch = Stopwatch()
    spend(watch, clock, 'work', 1.0)
    clock[0] += 90.0
    spend(watch, clock, 'work', 30.0)
    watch.frames += 1
    assert watch.figures() == {'frames': 1} and watch.summary() == 'served 1 frames'
    for _ in range(4):
        clock[0] += 0.25
        spend(watch, clock, 'work', 0.5)
        watch.frames += 1
        spend(watch, clock, 'publish', 0.25)
    assert watch.figures() == {'frames': 5, 'seconds': 4.0, 'wait': 25.0, 'work': 50.0,
                               'publish': 25.0}
    assert watch.lap() == pytest.approx((31.0 + 2.0) / 5)
