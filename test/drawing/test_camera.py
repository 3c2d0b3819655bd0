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

"""The camera against a projection written by hand."""
import dataclasses
import math

from flag_sim.drawing import Camera

import numpy as np

import pytest

POINTS = np.array([[0.0, 0.0, 9.0], [2.3, 0.4, 7.4], [1.0, -1.0, 8.0], [-3.0, 5.0, 0.0]])


def look_at(camera, up):
    """Project POINTS by cross products and similar triangles: u, v and depth, each (n,)."""
    along = np.array([math.cos(camera.elevation) * math.cos(camera.azimuth),
                      math.cos(camera.elevation) * math.sin(camera.azimuth),
                      math.sin(camera.elevation)])
    eye = np.array(camera.target) + camera.distance * along
    right = np.cross(-along, up)
    right /= np.linalg.norm(right)
    down = np.cross(-along, right)
    x, y, z = (POINTS - eye) @ right, (POINTS - eye) @ down, (POINTS - eye) @ -along
    half = camera.height / 2.0
    if camera.projection == 'perspective':
        x, y = x / (z * math.tan(camera.vertical_fov / 2.0)), \
            y / (z * math.tan(camera.vertical_fov / 2.0))
    else:
        x, y = x / (camera.scale / 2.0), y / (camera.scale / 2.0)
    # The image's corner is half a pixel from the first pixel's centre.
    return camera.width / 2.0 + half * x - 0.5, half + half * y - 0.5, z


def project(camera):
    """Project POINTS by the camera's own matrices."""
    points = np.column_stack([POINTS, np.ones(len(POINTS))]) @ camera.pose.T
    image = points @ camera.P.T
    return image[:, 0] / image[:, 2], image[:, 1] / image[:, 2], points[:, 2]


@pytest.mark.parametrize('projection', ['perspective', 'orthographic'])
@pytest.mark.parametrize('azimuth, elevation', [(-1.57, 0.1), (0.3, -0.8), (2.5, 1.2), (4.0, 0)])
def test_pose_and_projection(projection, azimuth, elevation):
    camera = Camera(width=321, height=200, projection=projection, azimuth=azimuth,
                    elevation=elevation, distance=12.0)
    np.testing.assert_allclose(project(camera), look_at(camera, (0, 0, 1)), atol=1e-9)


@pytest.mark.parametrize('elevation', [math.pi / 2.0, -math.pi / 2.0])
def test_straight_down_and_up(elevation):
    camera = Camera(azimuth=-math.pi / 2.0, elevation=elevation, distance=30.0)
    # Seen from above with the camera's back to -y, the picture's upper side is +y.
    up = (0, 1, 0) if elevation > 0 else (0, -1, 0)
    np.testing.assert_allclose(project(camera), look_at(camera, up), atol=1e-9)


def test_the_frame_is_that_of_rep_103():
    rows = Camera(elevation=0.0).pose[:3, :3]
    np.testing.assert_allclose(rows, [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)
    assert np.linalg.det(rows) == pytest.approx(1.0)


def test_roll_turns_the_camera_about_its_forward_axis():
    level, rolled = Camera(elevation=0.0), Camera(elevation=0.0, roll=math.pi / 2.0)
    np.testing.assert_allclose(rolled.pose[2], level.pose[2], atol=1e-15)
    # Rolled by a quarter, the camera's right is where its down was.
    np.testing.assert_allclose(rolled.pose[0, :3], level.pose[1, :3], atol=1e-15)


def test_distance_zero_stands_in_the_target():
    camera = Camera(distance=0.0, elevation=1.0)
    np.testing.assert_array_equal(camera.position, camera.target)
    assert np.isfinite(camera.pose).all()


def test_intrinsic_matrix_puts_pixel_centres_at_whole_numbers():
    camera = Camera(width=640, height=480, vertical_fov=math.pi / 2.0)
    np.testing.assert_allclose(camera.K, [[240, 0, 319.5], [0, 240, 239.5], [0, 0, 1]])
    np.testing.assert_array_equal(camera.P[:, :3], camera.K)


def test_an_orthographic_camera_says_that_it_is_not_a_pinhole():
    camera = Camera(projection='orthographic', scale=4.0, width=10, height=8)
    np.testing.assert_array_equal(camera.K, np.zeros((3, 3)))
    np.testing.assert_allclose(camera.P, [[2, 0, 0, 4.5], [0, 2, 0, 3.5], [0, 0, 0, 1]])


def test_cameras_compare_by_value():
    assert Camera(target=[1, 2, 3]) == Camera(target=np.array([1.0, 2.0, 3.0]))
    assert dataclasses.replace(Camera(), distance=1.0) != Camera()


@pytest.mark.parametrize('name, value', [
    ('width', 0), ('width', 1.5), ('height', -3), ('height', 100000), ('projection', 'fisheye'),
    ('vertical_fov', 0.0), ('vertical_fov', math.pi), ('vertical_fov', math.nan), ('scale', 0.0),
    ('near', 0.0), ('near', -1.0), ('distance', -1.0), ('distance', math.inf),
    ('azimuth', 90), ('elevation', 30), ('elevation', -1.6),
    ('roll', 360), ('width', '640'), ('target', 'flag'),
    ('azimuth', math.inf), ('elevation', math.nan), ('roll', 'left'), ('target', (1.0, 2.0)),
    ('target', (1.0, 2.0, math.nan))])
def test_invalid_values_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        Camera(**{name: value})
