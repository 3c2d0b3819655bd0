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

"""What the renderer tells of each pixel and of its camera, beside the picture."""
import io
import sys
import types

from flag_sim.declarations.factories import look_of
from flag_sim.declarations.nodes import defaults
from flag_sim.drawing import Camera, flag_scene, LastFrame, Picture
from flag_sim.drawing.mesh import grid_triangles
from flag_sim.ros import camera_messages, messages
from flag_sim.ros.parameter_node import BadParameter
import numpy as np
from PIL import Image
import pytest
import rclpy
from rclpy.serialization import serialize_message
from support.film import Film, FRAME, frame, pixels_of
from support.flags import wave

IMAGES = {'image_raw': 'colour', 'depth/image_raw': 'depth', 'normals/image_raw': 'normals',
          'labels/image_raw': 'labels', 'texture_coordinates/image_raw': 'texture_coordinates',
          'flow/image_raw': 'flow'}
ENCODINGS = {'image_raw': 'rgb8', 'depth/image_raw': '32FC1', 'normals/image_raw': '32FC3',
             'labels/image_raw': '8UC1', 'texture_coordinates/image_raw': '32FC2',
             'flow/image_raw': '32FC2'}


@pytest.fixture
def film(domain):
    """Return a Film."""
    film = Film(domain)
    yield film
    film.close()


def check(film, shot, stamp, flag, last, **keyed):
    """Check all images of a frame against the library; return the frame that it draws."""
    values = {**film.renderer.values, **{f'camera.{name}': one for name, one in keyed.items()}}
    camera, light, materials, dimensions, style = look_of(values)
    objects = flag_scene(np.float32(flag), np.float32(flag), camera, materials, dimensions, last)
    drawn = Picture().draw_scene(objects, camera, light, style, list(IMAGES.values())[1:],
                                 last and last.camera)
    for topic, channel in IMAGES.items():
        message = shot[f'camera/{topic}']
        assert messages.to_stamp(message.header.stamp) == stamp
        assert message.header.frame_id == 'left_eye'
        assert message.encoding == ENCODINGS[topic]
        np.testing.assert_array_equal(pixels_of(message), getattr(drawn, channel))
    return drawn, LastFrame(np.float32(flag), camera, dimensions)


def test_every_image_is_the_librarys_and_keys_reach_a_renderer_of_any_name(film):
    """Flow by both frames' vertices and cameras; none after a gap, a reset or another grid."""
    last = None
    for index, azimuth in enumerate((-1.5, -1.45, -1.4)):
        flag = wave(phase=0.2 * index)
        shot = film.shoot(frame(index), flag, azimuth=azimuth)
        drawn, last = check(film, shot, index * FRAME, flag, last, azimuth=azimuth)
        assert np.isnan(drawn.flow).all() == (index == 0)
    for what, id_, flag in (('a gap', frame(7), wave()), ('a take', frame(0, 2), wave(phase=1.0)),
                            ('a grid', frame(1, 2), wave(11, 16))):
        shot = film.shoot(id_, flag, azimuth=-1.4)
        drawn, last = check(film, shot, id_.stamp, flag, last if what == 'a grid' else None,
                            azimuth=-1.4)
        assert np.isnan(drawn.flow[drawn.labels == 1]).all()
    assert {message.frame_id for message in film.done} == {'left'}


def test_infos_pose_marker_and_jpeg_are_of_the_same_frame(film):
    """The pose takes points of the optical frame to the world, where the vertices are."""
    flag = wave()
    shot = film.shoot(frame(0), flag, elevation=0.3, roll=0.4)
    camera = look_of({**film.renderer.values, 'camera.elevation': 0.3, 'camera.roll': 0.4}).camera
    for topic in ('camera/camera_info', 'camera/depth/camera_info'):
        np.testing.assert_array_equal(shot[topic].p, camera.P.ravel())
        assert shot[topic].header.frame_id == 'left_eye'
    pose = shot['camera/pose'].pose
    assert shot['camera/pose'].header.frame_id == 'world'
    x, y, z, w = (getattr(pose.orientation, name) for name in 'xyzw')
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    np.testing.assert_allclose(turn, camera.pose[:3, :3].T, atol=1e-12)
    np.testing.assert_allclose([pose.position.x, pose.position.y, pose.position.z],
                               camera.position)

    marker = shot['marker']
    assert (marker.type, marker.action) == (marker.TRIANGLE_LIST, marker.ADD)
    assert marker.ns == 'flag_sim'
    assert marker.header.frame_id == 'world' and marker.pose.orientation.w == 1.0
    np.testing.assert_allclose([marker.color.r, marker.color.g, marker.color.b, marker.color.a],
                               np.array([205, 35, 40, 255]) / 255, rtol=1e-6)
    np.testing.assert_array_equal(
        [(point.x, point.y, point.z) for point in marker.points],
        np.float32(flag).reshape(-1, 3)[grid_triangles(21, 31)].reshape(-1, 3))
    # As ROS itself would have sent it, but for the bytes between its fields, which mean nothing.
    assert len(serialize_message(marker)) == len(camera_messages.marker_message(
        camera_messages.Shot(0, camera, '', None, flag, film.renderer.values)))

    rgb = pixels_of(shot['camera/image_raw'])
    compressed = shot['camera/image_raw/compressed']
    assert compressed.format == 'rgb8; jpeg compressed bgr8'
    with Image.open(io.BytesIO(compressed.data)) as jpeg:
        assert jpeg.format == 'JPEG'
        assert np.abs(np.asarray(jpeg).astype(float) - rgb).mean() < 2.0
    assert film.renderer.values['compressed.jpeg_quality'] == 95


def test_png_keeps_every_bit(domain):
    film = Film(domain, '-p', 'compressed.format:=png')
    try:
        shot = film.shoot(frame(0), wave())
        with Image.open(io.BytesIO(shot['camera/image_raw/compressed'].data)) as png:
            assert png.format == 'PNG'
            np.testing.assert_array_equal(np.asarray(png), pixels_of(shot['camera/image_raw']))
    finally:
        film.close()


@pytest.mark.parametrize('name', ["''", "'  '"])
def test_a_frame_without_a_name_is_refused(domain, name):
    with pytest.raises(BadParameter, match='camera.frame_id must not be empty'):
        Film(domain, '-p', f'camera.frame_id:={name}')
    rclpy.shutdown()


def test_a_stereo_pair_has_its_baseline_in_P():
    """Both matrices take a point of the left frame to where each camera sees it."""
    values = {'camera.baseline': 0.12, 'camera.roll': 0.3}
    left = look_of({**defaults('renderer'), **values, 'camera.baseline': 0.0}).camera
    right = look_of({**defaults('renderer'), **values}).camera
    point = np.array([0.4, -0.2, 6.0, 1.0])
    world = np.linalg.inv(left.pose) @ point
    u, v, w = right.P @ point
    x, y, z, _ = right.pose @ world
    assert (u / w, v / w) == pytest.approx((right.focal * x / z + right.centre[0],
                                            right.focal * y / z + right.centre[1]))
    assert right.P[0, 3] == pytest.approx(-right.focal * 0.12) and left.P[0, 3] == 0.0


def test_one_frame_has_one_place_on_tf(monkeypatch):
    """That of the left camera, of which the right one has the name; tf2_msgs has no wheel."""
    module = types.SimpleNamespace(TFMessage=lambda transforms=(): types.SimpleNamespace(
        transforms=list(transforms)))
    monkeypatch.setitem(sys.modules, 'tf2_msgs', types.SimpleNamespace(msg=module))
    monkeypatch.setitem(sys.modules, 'tf2_msgs.msg', module)
    for baseline, number in ((0.0, 1), (0.12, 0)):
        camera = Camera(azimuth=0.4, baseline=baseline)
        told = camera_messages.tf_message(camera_messages.Shot(
            7, camera, 'left_eye', None, wave(), {})).transforms
        assert len(told) == number
        for one in told:
            assert (one.header.frame_id, one.child_frame_id) == ('world', 'left_eye')
            place = one.transform.translation
            np.testing.assert_allclose([place.x, place.y, place.z], camera.position)
