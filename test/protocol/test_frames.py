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

"""Frames are served once and in order, whatever arrives."""
import random
import time

from flag_sim.protocol.frames import Arrival, FrameId, FrameOrder, next_take
import pytest


def frame(index, oldest=0, take=1):
    """Return a frame of a 10 Hz shot."""
    return FrameId(index * 10**8, take, index, oldest)


def served(order):
    """Return the indices of all frames that can be served now."""
    return [frame.index for frame in iter(order.next_frame, None)]


def test_a_lost_frame_is_waited_for():
    """Later frames wait until a frame that is owed has come."""
    order = FrameOrder()
    order.arrive(frame(0))
    assert served(order) == [0]
    order.arrive(frame(2))
    assert served(order) == []
    order.arrive(frame(1))
    assert served(order) == [1, 2]


def test_in_real_time_a_gap_is_passed_over():
    """Where nothing is owed, a frame is served without the ones before it."""
    order = FrameOrder()
    for index in (0, 3, 7):
        order.arrive(frame(index, oldest=index))
    assert served(order) == [0, 3, 7]


def test_copies_are_told_from_new_frames():
    """A frame that was served and comes again is a copy; one far behind alone begins nothing."""
    order = FrameOrder()
    for index in range(100):
        assert order.arrive(frame(index, index), 'a') in (Arrival.NEW, Arrival.RESTART)
        assert served(order) == [index]
    assert order.arrive(frame(99, 99), 'a') is Arrival.AGAIN
    for late in (0, 50):
        assert order.arrive(frame(late), 'a') is Arrival.STALE
        assert order.arrive(frame(99, 99), 'a') is Arrival.AGAIN
    assert served(order) == []


def rounds(order, frames, times):
    """Return the indices that are served of frames that one sender plays again and again."""
    out = []
    for frame in times * frames:
        order.arrive(frame, 'player')
        out += served(order)
    return out


@pytest.mark.parametrize('frames, window', [
    (3, 1), (6, 1), (40, 1), (300, 1), (5, 3), (9, 3), (40, 3), (10, 8), (40, 8)])
def test_a_looped_bag_is_played_in_every_round(frames, window):
    """By the same publisher, of the same take, however many may still have been asked for."""
    bag = [frame(index, max(index - window + 1, 0)) for index in range(frames)]
    assert rounds(FrameOrder(), bag, 3) == 3 * list(range(frames))


def test_a_looped_bag_of_two_takes_is_played_in_every_round():
    """The first take is older than the last one that was played, by the same publisher."""
    bag = [frame(index, index, take) for take in (1, 2) for index in range(20)]
    assert rounds(FrameOrder(), bag, 3) == 6 * list(range(20))


def test_a_looped_bag_without_its_first_frames_is_played_in_every_round():
    """As one has them whose recording began later, or that was played from the middle on."""
    bag = [frame(index, index - 2) for index in range(12, 40)]
    assert rounds(FrameOrder(), bag, 3) == 3 * list(range(12, 40))


def test_a_frame_that_is_asked_for_again_after_a_jump_back_begins_a_round():
    """A sender that waits for it sends nothing else."""
    order = FrameOrder()
    rounds(order, [frame(index) for index in range(40)], 1)
    order.arrive(frame(0, take=0), 'player')
    assert served(order) == []
    order.arrive(frame(0, take=0), 'player')
    assert served(order) == [0]


def test_frames_that_were_never_sent_hold_up_nobody():
    """A recording that lost some says by later frames that nobody waits for them any more."""
    order = FrameOrder()
    bag = [frame(index, max(index - 2, 0)) for index in range(20) if index not in (7, 8)]
    assert rounds(order, bag, 1) == [i for i in range(20) if i not in (7, 8)]


def test_a_later_take_begins_anew_and_an_earlier_one_is_stale():
    """A greater take restarts; what is left of the one before is ignored."""
    order = FrameOrder()
    order.arrive(frame(0), 'a')
    order.arrive(frame(0, take=2), 'a')
    assert served(order) == [0]
    assert order.arrive(frame(1, take=1), 'a') is Arrival.STALE
    assert served(order) == []


def test_a_take_has_a_greater_number_than_the_one_before(monkeypatch):
    """Also where the wall clock has been set back, and across restarts where it has not."""
    now = time.time_ns()
    monkeypatch.setattr(time, 'time_ns', lambda: now)
    assert next_take(0) == now
    assert next_take(now - 5) == now
    assert next_take(now) == now + 1
    assert next_take(now + 3600 * 10**9) == now + 3600 * 10**9 + 1


def test_a_new_publisher_may_play_an_old_take():
    """A bag that is played twice is served twice."""
    order = FrameOrder()
    for sender in ('first', 'second'):
        assert order.arrive(frame(0), sender) is Arrival.RESTART
        order.arrive(frame(1), sender)
        assert served(order) == [0, 1]


def test_without_a_take_time_that_jumps_back_restarts():
    """Messages typed by hand are ordered by their stamps alone."""
    def typed(stamp):
        return FrameId(stamp, None, stamp, stamp)

    order = FrameOrder()
    assert order.arrive(typed(5)) is Arrival.RESTART
    assert served(order) == [5]
    assert order.arrive(typed(9)) is Arrival.NEW
    assert served(order) == [9]
    assert order.arrive(typed(9)) is Arrival.AGAIN
    assert order.arrive(typed(4)) is Arrival.RESTART
    assert served(order) == [4]


def test_a_newcomer_begins_with_the_frame_that_is_owed():
    """A node that joins late waits for the oldest frame in flight."""
    order = FrameOrder()
    order.arrive(frame(12, oldest=11))
    assert served(order) == []
    order.arrive(frame(11, oldest=11))
    assert served(order) == [11, 12]


def test_a_frame_that_is_not_ready_holds_up_lockstep_only():
    """In real time the newest ready frame goes ahead of one that is still incomplete."""
    for oldest, expected in ((0, None), (2, 2)):
        order = FrameOrder()
        order.arrive(frame(0))
        order.next_frame()
        order.arrive(frame(1, oldest=min(1, oldest)))
        order.arrive(frame(2, oldest=oldest))
        following = order.next_frame(lambda ready: ready.index == 2)
        assert (following and following.index) == expected


@pytest.mark.parametrize('seed', range(50))
def test_any_disorder_gives_every_frame_once_in_order(seed):
    """A window of frames, shuffled and doubled, comes out sorted and single."""
    source = random.Random(seed)
    messages = []
    for begin in range(0, 60, 3):
        window = [frame(begin + i, oldest=begin) for i in range(3)] * 2
        source.shuffle(window)
        messages += window
    order, out = FrameOrder(), []
    for message in messages:
        order.arrive(message)
        out += served(order)
    assert out == list(range(60))
