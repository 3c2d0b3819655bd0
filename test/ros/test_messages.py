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

"""Arrays to messages and back."""
import array

from flag_sim.drawing.camera import Camera
from flag_sim.ros import messages
import numpy as np
import pytest
from sensor_msgs.msg import PointField

STAMP = 1_500_000_001  # [ns]


@pytest.fixture
def grid():
    """Return positions and normals of a 3 x 5 grid, exact in float32."""
    values = np.arange(3 * 5 * 6, dtype=np.float64).reshape(3, 5, 6) / 64
    return values[..., :3], values[..., 3:]


def test_a_cloud_is_organised_and_dense(grid):
    """Height is rows, width is columns, row 0 comes first."""
    message = messages.cloud_message(STAMP, *grid)
    assert (message.height, message.width, message.is_dense) == (3, 5, True)
    assert [field.name for field in message.fields] == list(messages.CLOUD_FIELDS)
    assert (message.header.frame_id, messages.to_stamp(message.header.stamp)) == (
        'world', STAMP)
    points = np.frombuffer(message.data, np.float32).reshape(3, 5, 6)
    assert np.array_equal(points[2, 1, :3], grid[0][2, 1])


def test_a_cloud_comes_back(grid):
    """Writing and reading give the same arrays."""
    positions, normals = messages.read_cloud(messages.cloud_message(0, *grid))
    assert np.array_equal(positions, grid[0])
    assert np.array_equal(normals, grid[1])


@pytest.mark.parametrize('kind', ['f4', 'f8'])
@pytest.mark.parametrize('order', ['<', '>'])
@pytest.mark.parametrize('padding', [0, 5])
def test_any_layout_is_read(grid, kind, order, padding):
    """Field types, byte order, padded points and padded rows make no difference."""
    size = np.dtype(kind).itemsize
    step = padding + 3 * size + padding
    message = messages.cloud_message(0, *grid)
    message.fields = [
        PointField(name=name, offset=padding + i * size, count=1,
                   datatype=PointField.FLOAT32 if size == 4 else PointField.FLOAT64)
        for i, name in enumerate('zxy')]
    message.is_bigendian = order == '>'
    message.point_step, message.row_step = step, 5 * step + padding
    data = np.zeros((3, message.row_step), np.uint8)
    for row, column, axis in np.ndindex(3, 5, 3):
        value = np.array(grid[0][row, column, 'xyz'.index('zxy'[axis])], order + kind)
        begin = column * step + padding + axis * size
        data[row, begin:begin + size] = np.frombuffer(value.tobytes(), np.uint8)
    message.data = data.tobytes()
    positions, normals = messages.read_cloud(message)
    assert np.array_equal(positions, grid[0])
    assert normals is None


@pytest.mark.parametrize('spoil, rule', [
    (lambda m: setattr(m, 'height', 1), 'at least 2 x 2 points, not 1 x 5'),
    (lambda m: setattr(m, 'row_step', 8), 'row_step 8 is less than'),
    (lambda m: setattr(m, 'height', 4), 'less than 4 rows'),
    (lambda m: setattr(m, 'point_step', 4), 'reaches beyond point_step 4'),
    (lambda m: setattr(m.fields[1], 'name', 'u'), "no field 'y'"),
    (lambda m: setattr(m.fields[0], 'datatype', PointField.INT16), 'FLOAT32 or FLOAT64'),
    (lambda m: setattr(m, 'data', b''), '0 bytes of data'),
])
def test_a_malformed_cloud_is_refused(grid, spoil, rule):
    """The message names what is wrong and the value."""
    message = messages.cloud_message(0, *grid)
    spoil(message)
    with pytest.raises(ValueError, match=rule):
        messages.read_cloud(message)


@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf])
def test_a_cloud_that_is_not_finite_is_refused(grid, value):
    """The message says which point it is."""
    grid[0][1, 3, 2] = value
    with pytest.raises(ValueError, match=r"'z' of point \(1, 3\) is"):
        messages.read_cloud(messages.cloud_message(0, *grid))


@pytest.mark.filterwarnings('error')
def test_a_signalling_nan_is_refused_like_every_other(grid):
    """Nothing else is told of it; numpy would warn of the cast."""
    message = messages.cloud_message(0, *grid)
    data = np.array(message.data, np.uint8)
    data[:4] = np.array([0x7fa00000], np.uint32).view(np.uint8)
    message.data = array.array('B', data.tobytes())
    with pytest.raises(ValueError, match=r"'x' of point \(0, 0\) is nan"):
        messages.read_cloud(message)


def test_images_hold_their_pixels():
    """Rows are whole and in order, in both encodings."""
    rgb = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
    image = messages.image_message(STAMP, rgb)
    assert (image.height, image.width, image.step, image.encoding) == (4, 6, 18, 'rgb8')
    assert np.array_equal(np.array(image.data).reshape(rgb.shape), rgb)
    depth = np.full((4, 6), np.inf, np.float32)
    image = messages.image_message(STAMP, depth)
    assert (image.step, image.encoding, image.header.frame_id) == (
        24, '32FC1', 'camera_optical_frame')
    assert np.array_equal(np.frombuffer(image.data, np.float32).reshape(4, 6), depth)


def test_camera_info_is_the_cameras():
    """K and P are the camera's own; an orthographic one is no pinhole."""
    camera = Camera(width=320, height=200)
    info = messages.camera_info_message(STAMP, camera)
    assert np.array_equal(info.k, camera.K.ravel())
    assert np.array_equal(info.p, camera.P.ravel())
    assert (info.width, info.height) == (320, 200)
    info = messages.camera_info_message(0, Camera(projection='orthographic', scale=2.0))
    assert not np.any(info.k)
    assert info.p[0] == 480 / 2.0
