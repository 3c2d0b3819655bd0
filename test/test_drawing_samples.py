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

"""Samples at edges against the mean of many shifted frames, and against one another."""
import dataclasses
import math

from flag_sim.drawing import Camera, Light, Material, Materials, Picture, Scene, Style
from flag_sim.drawing.tiles import PATTERNS

import numpy as np

import pytest

from support.flags import wave


@dataclasses.dataclass(frozen=True)
class ShiftedCamera(Camera):
    """A camera whose pixels' centres are moved by `shift` [pixel]."""

    shift: tuple = (0.0, 0.0)

    @property
    def centre(self):
        u, v = super().centre
        return u - self.shift[0], v - self.shift[1]


def mean_of_64():
    """Average 64 frames that look through other points of the pixels, rooks all of them."""
    total = 0.0
    for k in range(64):
        # Multiples of the golden section leave no direction with a gap (a Fibonacci lattice).
        shift = (k + 0.5) / 64 - 0.5, ((k * 0.6180339887) % 1.0) - 0.5
        total = total + Picture().draw(wave(), camera=ShiftedCamera(1280, 720, shift=shift))
    return total / 64


def noise(rgb, reference):
    """Give the peak signal-to-noise ratio [dB]."""
    return 10.0 * math.log10(255.0 ** 2 / np.mean((rgb - reference) ** 2))


def test_quality_against_64_samples():
    reference = mean_of_64()
    quality = [noise(Picture().draw(wave(), camera=Camera(1280, 720),
                                    style=Style(samples=samples)), reference)
               for samples in (1, 4, 8, 16)]
    # One sample shows that the measure tells them apart; 4 and 8 reach what the readers of the
    # README are told; 16 is better still. At 640 x 480 more of the pixels lie on edges: 48.8 dB
    # with 4, 54.1 with 8, where the mean of 8 whole frames has 54.2; none of the eight rooks'
    # patterns that follow edges best, in all directions or near the axes, was better.
    assert quality[0] < 45.0
    assert quality[1] >= 48.5
    assert quality[2] >= 55.0
    assert quality[3] >= quality[2] + 2.0


@pytest.mark.parametrize('samples', [4, 8, 16])
def test_patterns_are_rooks_about_the_centre(samples):
    pattern = PATTERNS[samples]
    np.testing.assert_array_equal(pattern.mean(axis=0), 0.0)
    assert np.abs(pattern).max() < 0.5
    # Whole places, so that the arithmetic of edges stays exact.
    np.testing.assert_array_equal(pattern * 256, np.round(pattern * 256))
    for axis in range(2):
        cells = np.floor((pattern[:, axis] + 0.5) * samples)
        assert len(set(cells)) == samples


def test_a_straight_edge_has_the_coverage_of_its_samples():
    # An upright edge at u = 20 + part of an orthographic image with one metre a pixel.
    camera = Camera(41, 31, 'orthographic', scale=31.0, target=(0, 0, 0), elevation=0.0)
    nothing = Scene(pole_visible=False, platform_visible=False)
    black, white = (0.0, 0.0, 0.0), (255.0, 255.0, 255.0)
    for samples in (4, 8, 16):
        for part in (-0.47, -0.2, 0.03, 0.31):
            x, z = np.meshgrid([-30.0, part], [30.0, -30.0])
            flag = np.stack([x, np.zeros_like(x), z], axis=-1)
            rgb = Picture().draw(flag, None, camera, Light(ambient=1.0, intensity=0.0),
                                 Materials(flag=Material(white)), nothing,
                                 Style(black, samples=samples))
            share = np.mean(PATTERNS[samples][:, 0] < part)
            np.testing.assert_array_equal(rgb[:, :20], 255)
            np.testing.assert_allclose(rgb[:, 20], 255 * share, atol=0.5)
            np.testing.assert_array_equal(rgb[:, 21:], 0)


def test_what_is_smooth_and_the_depth_are_those_of_one_sample():
    one, four = Picture(), Picture()
    flag = wave()
    plain, smooth = one.draw(flag), four.draw(flag, style=Style(samples=4))
    np.testing.assert_array_equal(one.depth(), four.depth())
    changed = np.any(plain != smooth, axis=-1)
    assert 0.002 < changed.mean() < 0.1


@pytest.mark.parametrize('width, height', [(1, 1), (1, 50), (50, 1), (9, 17)])
@pytest.mark.parametrize('samples', [4, 16])
def test_sizes(width, height, samples):
    camera = Camera(width, height, target=(1.2, 0.3, 8.0), distance=3.0)
    picture = Picture()
    for _ in range(2):
        rgb = picture.draw(wave(), camera=camera, style=Style(samples=samples))
    assert rgb.shape == (height, width, 3)
    np.testing.assert_array_equal(rgb, Picture().draw(
        wave(), camera=camera, style=Style(samples=samples)))


def test_nothing_of_earlier_frames_is_left():
    picture, rng = Picture(), np.random.default_rng(4)
    for number in range(40):
        look = {'camera': Camera(61, 47, distance=rng.choice([0.0, 3.0, 9.0]),
                                 azimuth=rng.uniform(-3, 3), elevation=rng.uniform(-1.5, 1.5)),
                'scene': Scene(pole_visible=number % 3 > 0, platform_visible=number % 4 > 1),
                'style': Style(samples=(1, 4, 8)[number % 3], outline=number % 5 == 0)}
        flag = wave(5, 7, phase=number) + rng.normal(size=3)
        np.testing.assert_array_equal(picture.draw(flag, **look), Picture().draw(flag, **look))
