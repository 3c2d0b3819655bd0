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

"""Frames that lack something are held as long as a node may wait for them."""
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.holding import Holding


def frame(index, oldest, take=1):
    """Return a frame whose sender waits for those from `oldest` on."""
    return FrameId(index * 10, take, index, oldest)


def test_in_lockstep_all_are_held():
    """Also where the first that came is not the oldest, or one comes again."""
    holding = Holding()
    assert not any(holding.may_pass(frame(index, oldest))
                   for index, oldest in ((5, 4), (4, 4), (6, 4), (4, 4), (5, 5)))


def test_in_real_time_the_first_is_held_and_the_next_ones_pass():
    """That nobody waits for the first is known by the next."""
    holding = Holding()
    assert [holding.may_pass(frame(n, n)) for n in (4, 5, 5, 7)] == [False, True, True, True]


def test_another_take_is_held_anew():
    """It may be in lockstep; so may be what comes after an end."""
    holding = Holding()
    for n in (4, 5):
        holding.may_pass(frame(n, n))
    assert [holding.may_pass(frame(n, n, take=2)) for n in (0, 1)] == [False, True]
    holding.end()
    assert [holding.may_pass(frame(n, n, take=2)) for n in (2, 3)] == [False, True]


def test_a_change_of_pace_holds_again():
    """The first frame of lockstep passes, as it looks like one of real time; no other does."""
    holding = Holding()
    for n in (4, 5, 6):
        holding.may_pass(frame(n, n))
    assert [holding.may_pass(frame(index, oldest)) for index, oldest in (
        (7, 7), (8, 7), (9, 7), (8, 8), (9, 8), (10, 8), (9, 9))] == [True] + 6 * [False]
    assert holding.may_pass(frame(11, 11))  # in real time again
