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

"""Frames in flight: who has done what, what is overdue, and who can be waited for."""
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.in_flight import FramesInFlight, MOST_GIVEN_UP


def frame(index):
    """Return a frame."""
    return FrameId(index * 100, 1, index, 0)


def test_a_frame_is_done_when_all_say_so():
    """Each consumer counts once, strangers not at all."""
    in_flight = FramesInFlight()
    in_flight.send(frame(0), 'message', ['a', 'b'], 0.0)
    assert not in_flight.done(0, 'a', 1.0)
    assert not in_flight.done(0, 'a', 1.0)
    assert not in_flight.done(0, 'stranger', 1.0)
    assert len(in_flight) == 1
    assert in_flight.done(0, 'b', 1.0)
    assert len(in_flight) == 0
    assert not in_flight.done(0, 'b', 1.0)


def test_the_oldest_is_overdue_first():
    """A frame is overdue since it was last sent."""
    in_flight = FramesInFlight()
    for index in range(3):
        in_flight.send(frame(index), 'message', ['a'], float(index))
    assert in_flight.overdue(1.0, 1.5) is None
    assert in_flight.overdue(2.0, 1.5).frame.index == 0
    in_flight.oldest.last_time = 2.0
    assert in_flight.overdue(2.0, 1.5) is None
    in_flight.done(0, 'a', 1.0)
    assert in_flight.oldest.frame.index == 1


def test_nobody_to_wait_for():
    """Then a frame is done as soon as it is sent."""
    in_flight = FramesInFlight()
    in_flight.send(frame(0), 'message', [], 0.0)
    assert len(in_flight) == 0


def test_others_can_be_waited_for_while_frames_are_in_flight():
    """A name with a wrong spelling does not hold them up forever."""
    in_flight = FramesInFlight()
    for index in range(2):
        in_flight.send(frame(index), 'message', ['rendrer'], 0.0)
    in_flight.wait_for(['renderer', 'recorder'])
    assert not in_flight.done(0, 'rendrer', 1.0) and not in_flight.done(0, 'renderer', 1.0)
    assert in_flight.done(0, 'recorder', 1.0)
    assert in_flight.oldest.waiting_for == {'renderer', 'recorder'}
    in_flight.wait_for([])
    assert len(in_flight) == 0


def test_a_frame_is_sent_again_when_it_is_overdue():
    """Soon, while nobody has answered yet; later after `after`."""
    in_flight = FramesInFlight()
    in_flight.send(frame(0), 'message', ['a'], 0.0)
    assert in_flight.resend(0.1, 1.0) is None
    assert in_flight.resend(0.3, 1.0).frame.index == 0 and in_flight.resent == 1
    assert in_flight.resend(0.4, 1.0) is None
    in_flight.done(0, 'a', 0.5)
    assert in_flight.answered
    in_flight.send(frame(1), 'message', ['a'], 1.0)
    assert in_flight.resend(1.9, 1.0) is None
    assert in_flight.resend(2.1, 1.0).frame.index == 1 and in_flight.resent == 2


def test_who_is_late_has_answered_no_frame_for_long():
    """Frames that left while another one was waited for are not late for that."""
    in_flight = FramesInFlight()
    assert in_flight.late(9.0, 1.0) == []
    for index in range(3):
        in_flight.send(frame(index), 'message', ['b', 'a'], 0.0)
    assert in_flight.late(0.9, 1.0) == [] and in_flight.late(1.1, 1.0) == ['a', 'b']
    in_flight.done(0, 'a', 2.0)
    assert in_flight.late(2.1, 1.0) == ['b']
    in_flight.done(0, 'b', 3.0)
    assert in_flight.late(3.9, 1.0) == [] and in_flight.late(4.1, 1.0) == ['a', 'b']
    in_flight.give_up()
    in_flight.done(100, 'a', 5.0)  # late, but there
    assert in_flight.late(5.9, 1.0) == []
    in_flight.clear()
    in_flight.send(frame(9), 'message', ['a'], 20.0)
    assert in_flight.late(20.9, 1.0) == []


def test_room_is_made_for_the_newest_frame():
    """What was given up counts as not done in time only if there is anybody to do it."""
    in_flight = FramesInFlight()
    for index in range(5):
        in_flight.send(frame(index), 'message', ['a'], 0.0)
    assert in_flight.make_room(3) == 0 and len(in_flight) == 2
    in_flight.done(300, 'a', 1.0)
    assert in_flight.make_room(3) == 0 and len(in_flight) == 1
    assert in_flight.make_room(1) == 1 and len(in_flight) == 0


def test_answers_that_nobody_asked_for_hide_nobody():
    """A stranger's, to frames that were never sent; a late one to a frame given up counts."""
    in_flight = FramesInFlight()
    in_flight.send(frame(1), 'message', ['a'], 0.0)
    for stamp, name in ((0, 'a'), (999, 'a'), (100, 'stranger')):
        assert not in_flight.done(stamp, name, 5.0)
    assert in_flight.late(5.0, 1.0) == ['a']
    in_flight.send(frame(2), 'message', ['a'], 5.0)
    in_flight.give_up()
    assert not in_flight.done(100, 'stranger', 6.0)
    assert in_flight.late(6.0, 1.0) == ['a']
    assert not in_flight.done(100, 'a', 6.0)
    assert in_flight.late(6.0, 1.0) == []


def test_no_more_than_the_latest_frames_given_up_are_remembered():
    """However long nobody answers in real time."""
    in_flight = FramesInFlight()
    for index in range(3 * MOST_GIVEN_UP):
        in_flight.make_room(3)
        in_flight.send(frame(index), 'message', ['a'], 0.0)
    assert len(in_flight) == 3 and len(in_flight._given_up) == MOST_GIVEN_UP
