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

"""Programs of others read what is published: nobody needs a script of ours."""
from array import array

from flag_sim.declarations.nodes import defaults
from flag_sim.drawing import Camera, Picture
from flag_sim.ros import camera_messages, messages
from flag_sim.ros.bag import Bag
from flag_sim.ros.topics import TOPICS
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from support.film import Film, FRAME, frame, pixels_of
from support.flags import wave
from support.frames import parameters_message

CHANNELS = ('depth', 'normals', 'labels', 'texture_coordinates', 'flow')
FROM_ROS = 'no wheel has it: installed where ROS is'
CORNER, ALONG, DOWN = np.array([[0.05, 0.0, 8.9], [2.0, 0.9, -0.3], [0.1, -0.2, -1.5]])


@pytest.fixture
def film(domain):
    """Return a Film."""
    film = Film(domain)
    yield film
    film.close()


def plane(rows=11, columns=16):
    """Return a flag (rows, columns, 3) [m] that is a parallelogram."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    return CORNER + u[..., None] * ALONG + v[..., None] * DOWN


def seen(shot, number=200):
    """Return of some pixels of the flag: (n, 2) where, (n,) depth [m], (n, 3) where in world."""
    labels, depth, texture = (pixels_of(shot[f'camera/{name}/image_raw'])
                              for name in ('labels', 'depth', 'texture_coordinates'))
    y, x = np.nonzero(labels == 1)
    some = np.random.default_rng(1).choice(len(x), number, replace=False)
    y, x = y[some], x[some]
    u, v = np.float64(texture[y, x]).T
    return (np.stack([x, y], axis=-1), depth[y, x],
            CORNER + u[:, None] * ALONG + v[:, None] * DOWN)


def to_optical(shot, points):
    """Take points (n, 3) of the world to the frame of the pose that was published [m]."""
    pose = shot['camera/pose'].pose
    x, y, z, w = (getattr(pose.orientation, name) for name in 'xyzw')
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    return (points - [pose.position.x, pose.position.y, pose.position.z]) @ turn


def call(model, name):
    """Return a method by its name of today, or by that of image_geometry before 2024."""
    first, *words = name.split('_')
    return getattr(model, name, None) or getattr(
        model, first + ''.join(word[0].upper() + word[1:] for word in words))


def test_image_geometry_finds_the_surface_by_depth_and_camera_info(film):
    """The ray through a pixel, as long as its depth, ends where its texture coordinates are."""
    models = pytest.importorskip('image_geometry', reason=FROM_ROS)
    shot = film.shoot(frame(0), plane(), elevation=0.2, roll=0.3)
    for info in ('camera/camera_info', 'camera/depth/camera_info'):
        model = models.PinholeCameraModel()
        call(model, 'from_camera_info')(shot[info])
        pixels, depth, points = seen(shot)
        rays = np.array([call(model, 'project_pixel_to_3d_ray')(pixel) for pixel in pixels])
        found = rays / rays[:, 2:] * depth[:, None]
        np.testing.assert_allclose(found, to_optical(shot, points), atol=1e-4)


def test_image_geometry_takes_the_pair_as_a_stereo_camera(film):
    """What the right camera sees at a pixel is where the left frame and P say."""
    models = pytest.importorskip('image_geometry', reason=FROM_ROS)
    left = film.shoot(frame(0), plane())
    right = film.shoot(frame(1), plane(), baseline=0.12)
    model = models.StereoCameraModel()
    call(model, 'from_camera_info')(left['camera/camera_info'], right['camera/camera_info'])
    pixels, depth, points = seen(right)
    for pixel, point, z in zip(pixels, to_optical(left, points), depth):
        at_left, at_right = map(np.array, call(model, 'project_3d_to_pixel')(point))
        np.testing.assert_allclose(at_right, pixel, atol=0.01)
        assert at_left[0] - at_right[0] == pytest.approx(
            call(model, 'get_disparity')(z), rel=1e-4)


def test_message_filters_match_all_that_belongs_to_a_frame(film):
    filters = pytest.importorskip('message_filters', reason=FROM_ROS)
    names = [name for name in film.heard if name != '/tf'] + ['vertices']
    ends = [filters.Subscriber(film.watcher.node, TOPICS[name].message, name) for name in names
            if name != 'marker']
    matched = []
    filters.TimeSynchronizer(ends, 4).registerCallback(
        lambda *all_of_it: matched.append({messages.to_stamp(one.header.stamp)
                                           for one in all_of_it}))
    for index in range(3):
        film.shoot(frame(index), wave(phase=0.1 * index))
    film.wait(lambda: len(matched) == 3)
    assert matched == [{index * FRAME} for index in range(3)]


def test_sensor_msgs_py_reads_the_vertices():
    points = pytest.importorskip('sensor_msgs_py.point_cloud2', reason=FROM_ROS)
    flag, normals = wave(), np.roll(wave(), 1, axis=0)
    message = messages.cloud_message(FRAME, flag, normals)
    for names, wanted in ((['x', 'y', 'z'], flag),
                          (['normal_x', 'normal_y', 'normal_z'], normals)):
        read = points.read_points_numpy(message, names, reshape_organized_cloud=True)
        np.testing.assert_array_equal(read.reshape(flag.shape), np.float32(wanted))


def fields(message):
    """Return a message's content as dictionaries, lists and bytes, whoever made its class."""
    if isinstance(message, (array, bytes, bytearray, memoryview, np.ndarray)):
        view = memoryview(message)
        return view.tobytes() if view.format == 'B' and view.nbytes else view.tolist()
    if isinstance(message, (list, tuple)):
        return [fields(one) for one in message]
    if isinstance(message, (str, int, float)):
        return message
    names = (message.get_fields_and_field_types() if hasattr(
        message, 'get_fields_and_field_types') else message.__slots__)
    return {name: fields(getattr(message, name)) for name in names}


def test_mcap_ros2_reads_every_topic_of_a_bag(tmp_path):
    """It decodes by the definitions that stand in the file, without any ROS."""
    reader = pytest.importorskip('mcap.reader', reason='mcap-ros2-support is not installed')
    decoder = pytest.importorskip('mcap_ros2.decoder', reason='it is not installed')
    flag, camera, values = np.float32(wave()), Camera(width=64, height=48), defaults('renderer')
    drawn = Picture().draw(flag, camera=camera, channels=CHANNELS)
    shot = camera_messages.Shot(FRAME, camera, 'eye', drawn, flag, values)
    published = {name: camera_messages.TOPICS[name].message(shot)
                 for name in camera_messages.available()}
    published['vertices'] = messages.cloud_message(FRAME, flag, flag)
    published['parameters'] = parameters_message('wind', frame(1), [1.0, 0.0, 0.0], {})
    bag = Bag(tmp_path / 'bag', 'mcap', 'zstd')
    written = {}
    for name, message in published.items():
        written[name] = message if isinstance(message, bytes) else serialize_message(message)
        bag.add_topic(name, TOPICS[name].message)
        bag.write(name, FRAME, written[name])
    bag.close()
    with next((tmp_path / 'bag').glob('*.mcap')).open('rb') as file:
        for _, channel, record, read in reader.make_reader(
                file, decoder_factories=[decoder.DecoderFactory()]).iter_decoded_messages():
            wanted = deserialize_message(written.pop(channel.topic), TOPICS[channel.topic].message)
            assert record.log_time == FRAME
            assert fields(read) == fields(wanted), channel.topic
    assert not written
