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

"""Frames in flight: who has done what, and what is overdue."""
from flag_sim.nodes.flight import Flight
from flag_sim.nodes.frames import Tag


def tag(index):
    """Return the tag of a frame."""
    return Tag(index * 100, 1, index, 0)


def test_a_frame_is_done_when_all_say_so():
    """Each consumer counts once, strangers not at all."""
    flight = Flight()
    flight.send(tag(0), 'message', ['a', 'b'], 0.0)
    assert not flight.done(0, 'a')
    assert not flight.done(0, 'a')
    assert not flight.done(0, 'stranger')
    assert len(flight) == 1
    assert flight.done(0, 'b')
    assert len(flight) == 0
    assert not flight.done(0, 'b')


def test_the_oldest_is_overdue_first():
    """A frame is overdue since it was last sent."""
    flight = Flight()
    for index in range(3):
        flight.send(tag(index), 'message', ['a'], float(index))
    assert flight.overdue(1.0, 1.5) is None
    assert flight.overdue(2.0, 1.5).tag.index == 0
    flight.oldest.last_time = 2.0
    assert flight.overdue(2.0, 1.5) is None
    flight.done(0, 'a')
    assert flight.oldest.tag.index == 1


def test_nobody_to_wait_for():
    """Then a frame is done as soon as it is sent."""
    flight = Flight()
    flight.send(tag(0), 'message', [], 0.0)
    assert len(flight) == 0
