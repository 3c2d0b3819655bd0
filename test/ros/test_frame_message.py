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

"""Frames on the wire, as ParameterEvents, and back."""
from flag_sim.protocol.frames import FrameId
from flag_sim.ros.frame_message import as_oldest, FrameMessage, read_parameters
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message, serialize_message
from support.frames import parameters_message

FRAME = FrameId(stamp=1_500_000_001, take=7, index=45, oldest=43)


def test_parameters_come_back():
    """A frame, its wind and keyed values survive the wire."""
    keyed = {'physics.stiffness': 12.5, 'renderer.width': 320, 'renderer.pole.visible': False,
             'renderer.shading': 'flat'}
    message = parameters_message('/wind', FRAME, np.array([1.0, -2.0, 0.5]), keyed)
    frame, wind, values = read_parameters(message)
    assert (frame, values) == (FRAME, keyed)
    assert np.array_equal(wind, [1.0, -2.0, 0.5])


def test_one_message_carries_one_frame_after_another():
    """Also when the keyed parameters are others than before, and when a frame is sent again."""
    message_of = FrameMessage('/wind')
    first = {'physics.stiffness': 12.5, 'renderer.shading': 'flat'}
    for frame, wind, keyed in (
            (FRAME, [1.0, 0.0, 0.0], first),
            (FRAME._replace(index=48, stamp=1), [2.0, 0.0, 0.0], {**first, 'renderer.width': 7}),
            (FRAME._replace(index=49), [3.0, 0.0, 0.0], {'renderer.outline': True}),
            (FRAME._replace(oldest=45), [1.0, 0.0, 0.0], first)):
        message = message_of.fill(frame, wind, keyed)
        found, blowing, values = read_parameters(deserialize_message(
            serialize_message(message), ParameterEvent))
        assert (found, values) == (frame, keyed)
        assert np.array_equal(blowing, wind)


@pytest.mark.parametrize('wind', [[1.0, 2.0], [1.0, 2.0, float('nan')], [], [float('inf')] * 3])
def test_an_invalid_wind_is_refused(wind):
    """It must be three finite numbers."""
    with pytest.raises(ValueError, match='wind must be'):
        read_parameters(parameters_message('/wind', FRAME, wind, {}))


def test_an_invalid_type_is_refused():
    """The number of the type is named."""
    message = parameters_message('/wind', FRAME, np.zeros(3), {})
    message.changed_parameters[0].value.type = 77
    with pytest.raises(ValueError, match='77'):
        read_parameters(message)


def test_an_invalid_place_in_the_take_is_refused():
    """The oldest frame in flight cannot be younger than the frame."""
    message = parameters_message('/wind', FRAME._replace(oldest=46), np.zeros(3), {})
    with pytest.raises(ValueError, match='frame.oldest 46'):
        read_parameters(message)


def test_a_frame_can_be_made_the_oldest_that_is_waited_for():
    """Nothing else of its bytes changes; what is no frame stays as it is."""
    data = serialize_message(parameters_message('/wind', FRAME, np.ones(3), {'a.b': 2.5}))
    expected = serialize_message(parameters_message(
        '/wind', FRAME._replace(oldest=FRAME.index), np.ones(3), {'a.b': 2.5}))
    assert as_oldest(data) == expected
    by_hand = ParameterEvent()
    for other in (b'\x00\x01\x00\x00', serialize_message(by_hand)):
        assert as_oldest(other) == other
