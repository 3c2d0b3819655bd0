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

"""Samples at edges against the mean of many shifted frames, and their patterns by theory."""
import dataclasses
import math

from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style, Surface
from flag_sim.drawing.multisample import PATTERNS

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture


@dataclasses.dataclass(frozen=True)
class ShiftedCamera(Camera):
    """A camera whose pixels' centres are moved by `shift` [pixel]."""

    shift: tuple = (0.0, 0.0)

    @property
    def centre(self):
        u, v = super().centre
        return u - self.shift[0], v - self.shift[1]


def mean_of_many(width, height):
    """
    Average 233 frames that look through other points of the pixels, a Fibonacci lattice.

    It is within 75 dB of the mean of 4096 at 640 x 480, where that of 64, a tenth of the error of
    8 samples away, is within 67.6: against one or another lattice of 64, 8 have 54.8 to 55.1.
    """
    # Sums of 233 bytes fit in 16 bits, and are exact.
    total, picture = np.zeros((height, width, 3), np.uint16), Picture()
    for k in range(233):
        shift = (k + 0.5) / 233 - 0.5, (144 * k % 233 + 0.5) / 233 - 0.5
        camera = ShiftedCamera(width, height, shift=shift)
        total += picture.draw(wave(), camera=camera).colour
    return total / 233


def noise(rgb, reference):
    """Return the peak signal-to-noise ratio [dB]."""
    return 10.0 * math.log10(255.0 ** 2 / np.mean((rgb - reference) ** 2))


@pytest.mark.parametrize('width, height', [(640, 480), (1280, 720)])
def test_quality_against_many_samples(width, height):
    reference = mean_of_many(width, height)
    quality = [noise(Picture().draw(wave(), camera=Camera(width, height),
                                    style=Style(samples=samples)).colour, reference)
               for samples in (1, 4, 8, 16)]
    # One sample shows that the measure tells them apart; 4 and 8 reach what the readers of the
    # README are told; 16 is better still. In the smaller image, where more of the pixels lie on
    # edges, it is 37.9, 50.8, 55.1 and 59.2 dB.
    assert quality[0] < 45.0
    assert quality[1] >= 48.5
    assert quality[2] >= 55.0
    assert quality[3] >= quality[2] + 2.0


@pytest.mark.parametrize('samples', [4, 8, 16])
def test_patterns_are_rooks_about_the_centre(samples):
    pattern = PATTERNS[samples]
    assert len(pattern) == samples + 1
    np.testing.assert_array_equal(pattern[0], 0.0)
    np.testing.assert_array_equal(pattern.mean(axis=0), 0.0)
    assert np.abs(pattern).max() < 0.5
    # Whole subpixels, so that the arithmetic of edges stays exact.
    np.testing.assert_array_equal(pattern * 256, np.round(pattern * 256))
    for axis in range(2):
        cells = np.floor((pattern[:, axis] + 0.5) * len(pattern))
        assert len(set(cells)) == len(pattern)


def missed_area(pattern, angle):
    """Average over its offset the squared error of a straight edge's coverage of a pixel."""
    offsets = np.linspace(-0.75, 0.75, 1501)
    long, short = sorted(np.abs([math.cos(angle), math.sin(angle)]), reverse=True)
    # The pixel's corners, seen along the edge, bound the quadratic pieces of its covered area.
    area = sum(sign * np.maximum(offsets - (i * long + j * short) / 2.0, 0.0) ** 2
               for i, j, sign in ((-1, -1, 1), (-1, 1, -1), (1, -1, -1), (1, 1, 1)))
    area /= 2.0 * long * short
    places = pattern @ [math.cos(angle), math.sin(angle)]
    share = np.mean(places < offsets[:, None], axis=1)
    return np.sum((area - share) ** 2) * (offsets[1] - offsets[0])


# Of Direct3D 11.1 (functional specification, 19.2.4.1) [1 / 16 pixel]; 16 moved to the centre.
STANDARD = {
    4: [(-2, -6), (6, -2), (-6, 2), (2, 6)],
    8: [(1, -3), (-1, 3), (5, 1), (-3, -5), (-5, 5), (-7, -1), (3, 7), (7, -7)],
    16: np.add([(1, 1), (-1, -3), (-3, 2), (4, -1), (-5, -2), (2, 5), (5, 3), (3, -5), (-2, 6),
                (0, -7), (-4, -6), (-6, 4), (-8, 0), (7, -4), (6, 7), (-7, -8)], 0.5)}


@pytest.mark.parametrize('samples, most', [(4, 0.71), (8, 0.79), (16, 0.82)])
def test_patterns_miss_less_than_the_standard_ones(samples, most):
    angles = np.radians(np.arange(0.5, 180.0))
    ours, standard = (
        np.array([missed_area(np.asarray(pattern), angle) for angle in angles])
        for pattern in (PATTERNS[samples], np.array(STANDARD[samples]) / 16.0))
    # 30, 22 and 19 % less, for the sample at the centre, that costs nothing, and for where the
    # others lie: a lattice of 9 without further thought has 7 %. In the worst of all directions
    # 16 miss a tenth more.
    assert ours.mean() <= most * standard.mean()
    assert ours.max() <= 1.1 * standard.max()


def test_a_straight_edge_has_the_coverage_of_its_samples():
    # An upright edge at u = 20 + part of an orthographic image with one metre a pixel.
    camera = Camera(41, 31, 'orthographic', scale=31.0, target=(0, 0, 0), elevation=0.0)
    nothing = Dimensions(pole_visible=False, platform_visible=False)
    black, white = (0.0, 0.0, 0.0), (255.0, 255.0, 255.0)
    for samples in (4, 8, 16):
        for part in (-0.47, -0.2, 0.03, 0.31):
            x, z = np.meshgrid([-30.0, part], [30.0, -30.0])
            flag = np.stack([x, np.zeros_like(x), z], axis=-1)
            rgb = Picture().draw(flag, None, camera, Light(ambient=1.0, intensity=0.0),
                                 Materials(flag=Surface(white)), nothing,
                                 Style(black, samples=samples)).colour
            share = np.mean(PATTERNS[samples][:, 0] < part)
            np.testing.assert_array_equal(rgb[:, :20], 255)
            np.testing.assert_allclose(rgb[:, 20], 255 * share, atol=0.5)
            np.testing.assert_array_equal(rgb[:, 21:], 0)


def test_what_is_smooth_and_the_depth_are_those_of_one_sample():
    one, four = DepthPicture(), DepthPicture()
    flag = wave()
    plain, smooth = one.draw(flag).colour, four.draw(flag, style=Style(samples=4)).colour
    np.testing.assert_array_equal(one.frame.depth, four.frame.depth)
    changed = np.any(plain != smooth, axis=-1)
    assert 0.002 < changed.mean() < 0.1


@pytest.mark.parametrize('width, height', [(1, 1), (1, 50), (50, 1), (9, 17)])
@pytest.mark.parametrize('samples', [4, 16])
def test_sizes(width, height, samples):
    camera = Camera(width, height, target=(1.2, 0.3, 8.0), distance=3.0)
    picture = Picture()
    for _ in range(2):
        rgb = picture.draw(wave(), camera=camera, style=Style(samples=samples)).colour
    assert rgb.shape == (height, width, 3)
    np.testing.assert_array_equal(rgb, Picture().draw(
        wave(), camera=camera, style=Style(samples=samples)).colour)


def test_nothing_of_earlier_frames_is_left():
    picture, rng = Picture(), np.random.default_rng(4)
    for number in range(40):
        look = {'camera': Camera(61, 47, distance=rng.choice([0.0, 3.0, 9.0]),
                                 azimuth=rng.uniform(-3, 3), elevation=rng.uniform(-1.5, 1.5)),
                'dimensions': Dimensions(pole_visible=number % 3 > 0,
                                         platform_visible=number % 4 > 1),
                'style': Style(samples=(1, 4, 8)[number % 3], outline=number % 5 == 0)}
        flag = wave(5, 7, phase=number) + rng.normal(size=3)
        np.testing.assert_array_equal(picture.draw(flag, **look).colour,
                                      Picture().draw(flag, **look).colour)
