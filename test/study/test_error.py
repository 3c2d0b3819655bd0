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


def test_rms_and_distances():
    """Of a 3-4-5 triangle and of zero."""
    assert summary.rms([3.0, 4.0]) == pytest.approx(math.sqrt(12.5))
    assert errors.distances(np.array([[[3.0, 4.0, 0.0]]]), np.zeros((1, 1, 3)))[0, 0] == 5.0


def test_psnr_by_its_definition():
    """All colours off by d: 20 log10(255 / d)."""
    image = np.full((8, 9, 3), 100, np.uint8)
    assert errors.psnr(image + np.uint8(5), image) == pytest.approx(20.0 * math.log10(51.0))
    assert errors.psnr(image, image) == math.inf


def ssim_of_definition(x, y):
    """Return SSIM as the paper defines it: window by window, with weights that sum to one."""
    at = np.arange(11) - 5
    weights = np.exp(-(at[:, None]**2 + at[None]**2) / (2.0 * 1.5**2))
    weights /= weights.sum()
    c1, c2 = (0.01 * 255)**2, (0.03 * 255)**2
    values = []
    for row in range(x.shape[0] - 10):
        for column in range(x.shape[1] - 10):
            a, b = (image[row:row + 11, column:column + 11] for image in (x, y))
            mean_a, mean_b = (weights * a).sum(), (weights * b).sum()
            var_a = (weights * (a - mean_a)**2).sum()
            var_b = (weights * (b - mean_b)**2).sum()
            both = (weights * (a - mean_a) * (b - mean_b)).sum()
            values.append((2 * mean_a * mean_b + c1) * (2 * both + c2)
                          / ((mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2)))
    return np.mean(values)


def test_ssim_by_its_definition():
    """Two pictures of noise, one of them partly the other."""
    source = np.random.default_rng(2)
    x = source.integers(0, 256, (16, 19, 3)).astype(np.uint8)
    y = (0.7 * x + 0.3 * source.integers(0, 256, x.shape)).astype(np.uint8)
    grey_x, grey_y = (image @ np.array([0.299, 0.587, 0.114]) for image in (x, y))
    # The variances are differences of numbers of 1e4 that agree to 1e-15: 1e-9 is far above.
    assert errors.ssim(y, x) == pytest.approx(ssim_of_definition(grey_x, grey_y), abs=1e-9)
    assert errors.ssim(x, x) == pytest.approx(1.0, abs=1e-9)


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
