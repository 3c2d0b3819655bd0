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

"""The clock of a take: exact stamps, whatever the rate, and frames that are due."""
from fractions import Fraction

from flag_sim.protocol.clock import FrameClock
from hypothesis import example, given, strategies as st

TEN_MINUTES = 600.0  # [s]
RATES = st.floats(0.01, 1000.0)  # the range of the parameter


def is_nearest(stamp, exact):
    """Return whether a whole number of nanoseconds is the nearest to an exact time [ns]."""
    return abs(stamp - exact) <= Fraction(1, 2)


@given(RATES, st.floats(0.0, TEN_MINUTES))
@example(60.0, TEN_MINUTES)
@example(29.97, TEN_MINUTES)
@example(1000.0 / 3.0, TEN_MINUTES)
def test_frame_k_has_the_stamp_k_over_rate(rate, time):
    """To the nanosecond, ten minutes on, by exact arithmetic."""
    clock = FrameClock(rate)
    clock.index = int(time * rate)
    assert is_nearest(clock.stamp, Fraction(10**9 * clock.index) / Fraction(rate))


@given(st.lists(st.tuples(st.integers(0, 100_000), RATES), min_size=1, max_size=20), RATES)
def test_a_rate_that_is_changed_counts_from_the_next_frame(changes, rate):
    """That frame keeps its stamp, and the k-th after it is k / rate later, to the nanosecond."""
    clock = FrameClock(rate)
    for frames, other in changes:
        first, stamp = clock.index, clock.stamp
        clock.index += frames
        assert is_nearest(clock.stamp - stamp, Fraction(10**9 * frames) / Fraction(rate))
        kept = clock.stamp
        clock.change_rate(other)
        assert (clock.stamp, clock.index - first) == (kept, frames)
        rate = other


@given(RATES, st.integers(0, 10**18), st.integers(0, 100_000))
def test_stamps_begin_anywhere_and_keep_their_distances(rate, start, index):
    """To the nanosecond, also where seconds as floats have none left."""
    clock, moved = FrameClock(rate), FrameClock(rate, 1_796_000_000 * 10**9 + start)
    clock.index = moved.index = index
    assert moved.time == clock.time == clock.stamp
    assert moved.stamp - clock.stamp == 1_796_000_000 * 10**9 + start


def test_stamps_by_the_wall_clock_meet_it_wherever_real_time_begins():
    """At the first frame and after a pause; a clock that was set back takes none back."""
    wall = [1_796_000_000 * 10**9]
    clock = FrameClock(50.0, wall=lambda: wall[0])
    assert clock.due(100.0) == 0
    assert clock.stamp == wall[0]
    clock.index, wall[0] = 1, wall[0] + 33_000_000
    assert clock.due(100.036) == 2 and clock.stamp - wall[0] == 20_000_000 - 33_000_000
    clock.wait()
    wall[0] += 10 * 10**9
    assert clock.due(110.033) == 1
    assert (clock.stamp, clock.time) == (wall[0], 20_000_000)
    clock.wait()
    stamp, wall[0] = clock.stamp, 0
    clock.due(111.0)
    assert clock.stamp == stamp


def test_a_frame_is_due_at_its_time():
    """The first at once; then one a period, those that time has passed over are not made up."""
    clock = FrameClock(50.0)
    assert clock.due(100.0) == 0
    clock.index = 1
    for late in (-0.001, 0.014):  # [s]; a machine that is busy for so long loses no frame
        assert clock.due(100.02 + late) == 1
    assert clock.due(100.036) == 2
    assert clock.due(100.0 + TEN_MINUTES) == 30_000
    clock.index = 30_001
    assert clock.due(100.0 + TEN_MINUTES) == 30_001  # a timer that is early sends the next one


def test_a_clock_that_waits_loses_no_frame():
    """After a pause, or at another rate, the next frame is due at once."""
    clock = FrameClock(50.0)
    clock.due(100.0)
    clock.index = 7
    clock.wait()
    assert clock.due(500.0) == 7
    clock.change_rate(10.0)
    assert clock.due(900.0) == 7
    assert clock.due(900.2) == 9
