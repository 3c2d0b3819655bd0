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
import importlib
import inspect

from flag_sim.declarations.nodes import NODES
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.in_flight import FramesInFlight
from flag_sim.ros.delivery import check_delivery
import pytest


def frame(index):
    """Return a frame."""
    return FrameId(index * 100, 1, index, 0)


def test_a_frame_is_done_when_all_say_so():
    """Each consumer counts once, strangers not at all."""
    in_flight = FramesInFlight()
    in_flight.send(frame(0), 'message', ['a', 'b'], 0.0)
    assert not in_flight.done(0, 'a')
    assert not in_flight.done(0, 'a')
    assert not in_flight.done(0, 'stranger')
    assert len(in_flight) == 1
    assert in_flight.done(0, 'b')
    assert len(in_flight) == 0
    assert not in_flight.done(0, 'b')


def test_the_oldest_is_overdue_first():
    """A frame is overdue since it was last sent."""
    in_flight = FramesInFlight()
    for index in range(3):
        in_flight.send(frame(index), 'message', ['a'], float(index))
    assert in_flight.overdue(1.0, 1.5) is None
    assert in_flight.overdue(2.0, 1.5).frame.index == 0
    in_flight.oldest.last_time = 2.0
    assert in_flight.overdue(2.0, 1.5) is None
    in_flight.done(0, 'a')
    assert in_flight.oldest.frame.index == 1


def test_nobody_to_wait_for():
    """Then a frame is done as soon as it is sent."""
    in_flight = FramesInFlight()
    in_flight.send(frame(0), 'message', [], 0.0)
    assert len(in_flight) == 0


def test_others_can_be_waited_for_while_frames_are_in_flight():
    """A name with a wrong spelling does not hold them up for ever."""
    in_flight = FramesInFlight()
    for index in range(2):
        in_flight.send(frame(index), 'message', ['rendrer'], 0.0)
    in_flight.wait_for(['renderer', 'recorder'])
    assert not in_flight.done(0, 'rendrer') and not in_flight.done(0, 'renderer')
    assert in_flight.done(0, 'recorder')
    assert in_flight.oldest.waiting_for == {'renderer', 'recorder'}
    in_flight.wait_for([])
    assert len(in_flight) == 0


@pytest.mark.parametrize('node', NODES)
def test_only_nodes_that_say_frame_done_are_waited_for(node):
    """The others of the package are refused by name."""
    source = inspect.getsource(importlib.import_module(f'flag_sim.nodes.{node}'))
    values = {'pace': 'realtime', 'wait_for': ['mine', node]}
    if "publish(self, 'frame_done')" in source:
        check_delivery(values)
    else:
        with pytest.raises(ValueError, match=f'recorder or your own; {node} sends none'):
            check_delivery(values)


@pytest.mark.parametrize('pace, wait_for, rule', [
    ('lockstep', [], 'needs at least one node in wait_for'),
    ('realtime', [''], "by letters, digits and _, without their namespace, not ''"),
    ('realtime', ['/film/renderer'], "not '/film/renderer'"),
])
def test_what_can_never_be_done_is_refused(pace, wait_for, rule):
    """The message names the rule and the value."""
    with pytest.raises(ValueError, match=rule):
        check_delivery({'pace': pace, 'wait_for': wait_for})
