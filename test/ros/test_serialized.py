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

"""Messages that are made as bytes are those that rclpy would serialise, but for the padding."""
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from flag_sim.drawing.camera import Camera
from flag_sim.ros import messages, serialized
from geometry_msgs.msg import Point, PoseStamped
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterValue
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

STAMPS = 0, 1_500_000_001, messages.LATEST


def is_same(data, message):
    """Return whether bytes are a message; rclpy leaves what it pads with to chance."""
    return (len(data) == len(serialize_message(message))
            and deserialize_message(data, type(message)) == message)


@pytest.mark.parametrize('stamp', STAMPS)
@pytest.mark.parametrize('shape', [(2, 2), (3, 5), (21, 31)])
def test_arrays_give_the_same_bytes(stamp, shape):
    """Images of colours, depths, labels and flow, and a cloud."""
    random = np.random.default_rng(1)
    colour = random.integers(0, 256, (*shape, 3), np.uint8)
    depth = random.random(shape, np.float32)
    positions, normals = random.random((2, *shape, 3))
    points = np.concatenate([positions, normals], axis=2, dtype=np.float32)
    labels, flow = np.uint8(depth * 200), random.random((*shape, 2), np.float32)
    for pixels in (colour, depth, labels, flow):
        assert is_same(serialized.image(pixels, 'left').at(stamp, pixels),
                       messages.image_message(stamp, pixels, 'left'))
    assert is_same(serialized.cloud(*shape).at(stamp, points),
                   messages.cloud_message(stamp, positions, normals))


@pytest.mark.parametrize('stamp', STAMPS)
def test_what_is_the_same_but_for_its_stamp_gives_the_same_bytes(stamp):
    """Headers by whatever name, and the camera_info of both projections."""
    for name in ('', 'renderer', 'a_recorder'):
        assert is_same(serialized.header(name).at(stamp),
                       messages.header(stamp, name))
    for camera in (Camera(), Camera(width=33, projection='orthographic')):
        assert is_same(serialized.camera_info(camera).at(stamp),
                       messages.camera_info_message(stamp, camera))


def means_nothing(place, data, message, capfd):
    """Return whether a message is read the same whatever stands at a place of its bytes."""
    capfd.readouterr()
    for value in (b'\x00', b'\xff'):
        try:
            read = deserialize_message(data[:place] + value + data[place + 1:], type(message))
        except (RuntimeError, UnicodeDecodeError):
            return False
        if read != message or capfd.readouterr().err:  # it was too long to be read
            return False
    return True


@pytest.mark.parametrize('message', [
    messages.image_message(7, np.zeros((2, 3, 3), np.uint8)),
    messages.cloud_message(7, *np.ones((2, 2, 3, 3))),
    messages.camera_info_message(7, Camera()),
    Marker(ns='flag', points=[Point(x=1.0), Point(y=2.0)], colors=[ColorRGBA(r=0.5)], text='abc'),
    PoseStamped(header=messages.header(7, 'world')),
    CompressedImage(format='png', data=bytes(5)),
    ParameterEvent(node='/wind', changed_parameters=[
        Parameter(name='ab', value=ParameterValue(type=8, double_array_value=[0.5, 1.5])),
        Parameter(name='c', value=ParameterValue(type=9, string_array_value=['d', 'efg']))]),
    DiagnosticArray(status=[DiagnosticStatus(name='a', values=[KeyValue(key='b', value='cd')])]),
], ids=lambda message: type(message).__name__)
def test_what_pads_a_message_is_always_zero(message, monkeypatch, capfd):
    """All bytes that mean nothing to rclpy, which leaves there what was in the memory before."""
    data = serialize_message(message)
    places = {place for place in range(serialized.STAMP.start, len(data))
              if means_nothing(place, data, message, capfd)}
    assert places
    made = set()
    for left in (0x00, 0x55, 0xFF):
        def serialize(one, left=left):
            return bytes(left if place in places else byte for place, byte in enumerate(data))
        monkeypatch.setattr(serialized, 'serialize_message', serialize)
        made.add(serialized.without_padding(message))
    assert len(made) == 1
    assert is_same(made.pop(), message)


def test_making_messages_says_nothing(capfd):
    """A library below that reads bytes which are no message would write to the terminal."""
    serialized.camera_info.cache_clear()
    serialized.header.cache_clear()
    serialized.camera_info(Camera())
    serialized.header('a_node')
    assert capfd.readouterr() == ('', '')
