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

"""What hands do to the camera, by the camera itself."""
import dataclasses
import math

from flag_sim.drawing import Camera
from flag_sim.viewer.camera_moves import shift, turn, zoom
import numpy as np
import pytest

CAMERAS = [Camera(), Camera(roll=0.7, azimuth=1.0, elevation=0.5),
           Camera(projection='orthographic', azimuth=2.0, elevation=-1.2, roll=-2.0)]


def read_of(camera):
    """Return what reads a camera's values by the names of parameters."""
    return lambda name: getattr(camera, name.removeprefix('camera.'))


def moved(camera, changes):
    """Return the camera with changes of parameters."""
    return dataclasses.replace(camera, **{
        name.removeprefix('camera.'): tuple(value) if isinstance(value, list) else value
        for name, value in changes.items()})


def seen(camera, point):
    """Return where the camera sees a point, in pixels (u, v)."""
    u, v, w = camera.P @ camera.pose @ np.append(point, 1.0)
    return np.array([u / w, v / w])


@pytest.mark.parametrize('camera', CAMERAS)
def test_a_shift_moves_the_picture_by_parts_of_its_height(camera):
    """The view goes right and up, so what is seen goes left and down."""
    for right, up in ((0.1, 0.0), (0.0, 0.1), (-0.2, 0.3)):
        after = moved(camera, shift(read_of(camera), right, up))
        way = seen(after, camera.target) - seen(camera, camera.target)
        np.testing.assert_allclose(way, [-right * camera.height, up * camera.height], atol=1e-6)


@pytest.mark.parametrize('camera', CAMERAS)
def test_the_wheel_brings_nearer_and_back(camera):
    near = moved(camera, zoom(read_of(camera), 2.0))
    assert near.pixels_per_metre(near.distance) == pytest.approx(
        1.1 ** 2 * camera.pixels_per_metre(camera.distance))
    assert moved(near, zoom(read_of(near), -2.0)) == pytest.approx(camera)


def test_a_drag_takes_along_what_is_under_the_hand():
    """To the right and down: the side that is near goes there."""
    camera = Camera()
    towards = np.array(camera.target) + 0.3 * (camera.position - np.array(camera.target))
    after = moved(camera, turn(read_of(camera), 10.0, 5.0))
    way = seen(after, towards) - seen(camera, towards)
    assert way[0] > 0.0 and way[1] > 0.0


def test_turns_stay_in_their_range():
    camera = Camera(azimuth=6.2, elevation=1.5)
    after = turn(read_of(camera), -1000.0, 1000.0)
    assert abs(after['camera.azimuth']) <= math.pi
    assert after['camera.elevation'] == 0.5 * math.pi


def test_a_renderer_without_a_camera_is_not_moved():
    assert [shift(lambda _: None, 1, 1), zoom(lambda _: None, 1), turn(lambda _: None, 1, 1)] == [
        {}, {}, {}]
