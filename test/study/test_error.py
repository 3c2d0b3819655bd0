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

"""Errors are measured as they are defined."""
import math

from flag_sim.drawing import Camera
from flag_sim.study.measures import errors, summary
import numpy as np
import pytest


@pytest.mark.parametrize('projection', ['perspective', 'orthographic'])
def test_a_known_shift_is_so_many_pixels(projection):
    """Across the view, f dx / z in perspective; along an orthographic one nothing."""
    camera = Camera(projection=projection, elevation=0.0, distance=5.0, target=(1.0, 0.0, 8.0))
    sheet = np.zeros((3, 4, 3)) + np.array([1.0, 0.0, 8.0])
    pixels = errors.pixel_distances(sheet + [0.01, 0.0, 0.0], sheet, camera)
    expected = camera.focal * 0.01 / (5.0 if projection == 'perspective' else 1.0)
    # Differences of coordinates of hundreds of pixels in float64: 1e-13 relative to these.
    assert pixels == pytest.approx(np.full(12, expected), rel=1e-9)
    if projection == 'orthographic':
        along = errors.pixel_distances(sheet + [0.0, 0.5, 0.0], sheet, camera)
        assert along == pytest.approx(np.zeros(12), abs=1e-9)


def test_the_picture_agrees_with_where_vertices_are_said_to_be():
    """A point projected by the intrinsic matrix of CameraInfo is the same point."""
    camera = Camera(roll=0.3)
    points = np.random.default_rng(1).normal([1.1, 0.0, 7.8], 0.3, (50, 3))
    at, seen = errors.on_screen(points, camera)
    in_camera = (camera.pose @ np.column_stack([points, np.ones(50)]).T)[:3]
    u, v, w = camera.K @ in_camera
    assert at == pytest.approx(np.column_stack([u / w, v / w]), abs=1e-9)
    assert seen.all()


def test_nodes_outside_the_picture_do_not_count():
    """What nobody sees is no error in the picture; a flag that nobody sees is refused."""
    camera = Camera()
    sheet = np.tile([1.1, 0.0, 7.85], (1, 2, 1))
    sheet[0, 1] = [500.0, 0.0, 7.85]
    assert errors.pixel_distances(sheet + [0.0, 0.0, 0.01], sheet, camera).shape == (1,)
    with pytest.raises(ValueError, match='does not see the flag'):
        errors.pixel_distances(sheet, sheet - [0.0, 50.0, 0.0], camera)  # behind the camera


def test_rms():
    """The root of the mean of squares."""
    assert summary.rms([3.0, 4.0]) == pytest.approx(math.sqrt(12.5))


def test_resized_pictures():
    """Twice the size and back is the same picture; a linear slope stays one."""
    source = np.random.default_rng(3)
    image = source.integers(0, 256, (6, 8, 3)).astype(np.uint8)
    assert np.array_equal(errors.resized(image.repeat(2, 0).repeat(2, 1), 6, 8), image)
    slope = np.broadcast_to(np.arange(0, 80, 10, np.uint8)[None, :, None], (6, 8, 3))
    wide = errors.resized(slope, 6, 16)[0, :, 0].astype(int)
    # Centres of the doubled pixels lie a quarter of a pixel (2.5 levels) beside the old ones.
    inner = (5.0 * np.arange(16) - 2.5)[1:-1]
    assert np.abs(wide[1:-1] - inner).max() <= 0.5  # rounding to whole levels
