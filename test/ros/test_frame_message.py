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
from flag_sim.ros import frame_message
from flag_sim.ros.frame_message import (
    as_oldest, FRAME_NAMES, FrameMessage, FrameReader, NoMessage, read_parameters)
from flag_sim.ros.parameter_node import to_parameter
from hypothesis import given, strategies as st
import numpy as np
import pytest
from rcl_interfaces.msg import ParameterEvent
from rclpy.serialization import deserialize_message, serialize_message
from support.frames import parameters_message
from support.fuzz import CHANGES

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


def read_alike(reader, data):
    """Return whether a reader makes of bytes what rclpy does; both may refuse them."""
    try:
        message = deserialize_message(data, ParameterEvent)
    except RuntimeError:
        with pytest.raises(NoMessage):
            reader.read(data)
        return True
    try:
        frame, wind, values = read_parameters(message)
    except ValueError as refused:
        with pytest.raises(ValueError) as said:
            reader.read(data)
        return str(said.value) == str(refused)
    found, blowing, read = reader.read(data)
    return (found, repr(read)) == (frame, repr(values)) and np.array_equal(blowing, wind)


def test_frames_are_read_from_bytes_as_from_messages():
    """One after another, of two senders, with keyed values of all types, and others."""
    keyed = {'a.double': 2.5, 'a.whole': 3, 'a.bool': True, 'a.text': 'flat', 'a.list': [1.0, 2.0],
             'a.empty': [], 'a.texts': ['x', 'yz'], 'a.bools': [True, False]}
    reader = FrameReader()
    for index in range(6):
        changed = {**keyed, 'a.double': 0.1 * index, 'a.whole': -index,
                   'a.list': [index * 1.0] * 2}
        for name, values in (('/wind', changed), ('/w', {}), ('/wind', changed),
                             ('/wind', {**changed, 'a.text': 'gouraud', 'a.list': [1.0]})):
            parameters = [to_parameter(name, value).to_parameter_msg() for name, value in {
                'wind': [1.0, 1.0 * index, 0.5], **dict(zip(FRAME_NAMES, (7, index, index))),
                **values}.items()]
            message = ParameterEvent(node=name, changed_parameters=parameters)
            message.stamp.nanosec = index
            assert read_alike(reader, serialize_message(message))


def test_numbers_are_found_without_reading_the_whole_message(monkeypatch):
    """All but the first frame of a sender, although the bytes that pad it are others."""
    messages = [serialize_message(parameters_message(
        '/wind', FRAME._replace(index=index), [1.0, 2.0, 3.0], {'physics.gravity': 0.5 * index}))
        for index in range(45, 50)]
    reader = FrameReader()
    reader.read(messages[0])
    monkeypatch.setattr(frame_message, 'deserialize_message', None)
    for index, data in enumerate(messages[1:], 46):
        assert reader.read(data)[2] == {'physics.gravity': 0.5 * index}


@given(changes=CHANGES, keyed=st.booleans())
def test_mutilated_frames_are_read_as_rclpy_reads_them(changes, keyed):
    """Before and after a good one of the same length."""
    good = serialize_message(parameters_message(
        '/wind', FRAME, np.ones(3), {'a.b': 2.5, 'a.c': 'text', 'a.d': [1.0]} if keyed else {}))
    bad = bytearray(good)
    for part, byte in changes:
        bad[4 + int(part * (len(bad) - 4))] = byte
    reader = FrameReader()
    for data in (bytes(bad), good, bytes(bad), good, good[:len(good) // 2]):
        assert read_alike(reader, data)
