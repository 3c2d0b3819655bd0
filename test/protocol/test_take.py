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

"""A take: its frames, what is skipped, and its end."""
from flag_sim.protocol.clock import FrameClock
from flag_sim.protocol.in_flight import FramesInFlight
from flag_sim.protocol.take import Take

LATEST = 2**31 * 10**9 - 1


def make(length=0, start=0, rate=10.0):
    """Return a take."""
    return Take(7, FrameClock(rate, start), length, LATEST)


def test_frames_follow_one_another():
    """In lockstep each says which is the oldest that may be waited for."""
    take = make(start=5 * 10**9)
    assert take.next_id() == (5 * 10**9, 7, 0, 0) and take.previous < 0
    take.sent()
    assert take.next_id(0) == (5 * 10**9 + 10**8, 7, 1, 0) and take.previous == 0
    take.sent()
    assert take.previous == 10**8


def test_what_is_due_and_was_not_sent_is_skipped():
    """But never the last frame, which ends the shot."""
    take = make(length=5)
    assert take.skip_to(100.0) == 0
    take.sent()
    assert take.skip_to(100.32) == 2 and take.next_id().index == 3
    assert take.skip_to(200.0) == 1 and not take.is_over
    take.sent()
    assert take.is_over and not take.is_beyond


def test_no_stamp_is_beyond_what_a_message_holds():
    """The take is over before."""
    take = make(start=LATEST - 10**8)
    take.sent()
    assert not take.is_beyond
    take.sent()
    assert take.is_beyond and take.is_over


def test_in_lockstep_a_window_is_filled_once_somebody_has_answered():
    """Until then the first frame goes alone; the oldest in flight is the window's begin."""
    take, in_flight = make(), FramesInFlight()

    def fill():
        """Send what may leave; return the indices."""
        sent = []
        while take.has_room(in_flight, 3):
            sent.append(take.clock.index)
            in_flight.send(take.next_id(take.oldest_index(in_flight)), None, ['a'], 0.0)
            take.sent()
        return sent
    assert fill() == [0] and take.oldest_index(in_flight) == 0
    in_flight.done(0, 'a', 1.0)
    assert fill() == [1, 2, 3]
    in_flight.done(2 * 10**8, 'a', 1.0)
    assert fill() == [] and take.oldest_index(in_flight) == 1
    in_flight.done(10**8, 'a', 1.0)
    assert fill() == [4, 5]
    take.length = 7
    in_flight.clear()
    assert fill() == [6] and take.is_over
