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
from flag_sim.drawing.camera import Camera
from flag_sim.ros import messages, serialized
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message

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
