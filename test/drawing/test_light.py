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

"""Light against Lambert's law written by hand."""
import math

from flag_sim.drawing import Camera, Light, Surface
from flag_sim.drawing.shading import DIM_BELOW, shade as shade_into

import numpy as np

import pytest

FAR_ABOVE = (0.0, 0.0, 1.0, 0.0)


def shade(normals, material, light, points=None, viewpoint=FAR_ABOVE):
    """Return the colours of both sides: (2, n, 3)."""
    points = np.zeros_like(normals) if points is None else points
    colours = np.full((len(normals), 2, 3), np.nan)
    shade_into(points, normals, np.array(viewpoint), material, light, colours)
    return colours.swapaxes(0, 1)


def test_direction():
    assert Light(azimuth=0.0, elevation=0.0).direction == pytest.approx((1, 0, 0))
    assert Light(azimuth=math.pi / 2, elevation=0.0).direction == pytest.approx((0, 1, 0))
    assert Light(elevation=math.pi / 2).direction == pytest.approx((0, 0, 1))


def test_lamberts_law_on_both_sides():
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(500, 3))
    light = Light(azimuth=0.4, elevation=0.6, intensity=0.7, ambient=0.2)
    material = Surface((200, 100, 50), diffuse=0.9)
    cosine = (normals / np.linalg.norm(normals, axis=1)[:, None]) @ light.direction
    level = 0.2 + 0.7 * 0.9 * np.maximum([cosine, -cosine], 0.0)
    expected = level[:, :, None] * np.array([200, 100, 50])
    np.testing.assert_allclose(shade(normals, material, light), expected, rtol=1e-12)


def test_the_length_of_a_normal_does_not_matter():
    normals = np.array([[0.0, 0.0, 1e-9], [0.0, 0.0, 1.0], [0.0, 0.0, 1e9]])
    colours = shade(normals, Surface(), Light())[0]
    np.testing.assert_allclose(colours - colours[0], 0.0, atol=1e-9)


def test_bright_colours_stop_at_255():
    colours = shade(np.array([[0.0, 0.0, 1.0]]), Surface((255, 128, 1)),
                    Light(elevation=math.pi / 2, intensity=10.0))
    np.testing.assert_array_equal(colours[0, 0, :2], [255, 255])
    assert colours[0, 0, 2] == pytest.approx(10.35)


def test_a_sun_below_the_ground_leaves_ambient_light():
    normals = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
    light = Light(azimuth=0.0, elevation=-0.1, intensity=5.0, ambient=0.5)
    np.testing.assert_allclose(shade(normals, Surface((100, 100, 100)), light), 50.0)


def test_the_sun_rises_without_a_step():
    """In a thousandth of its dimmed way no level changes by one; above that it shines in full."""
    elevations = np.linspace(-0.01, DIM_BELOW, 1101)
    levels = [shade(np.array([[1.0, 0.0, 0.0]]), Surface((255, 255, 255)),
                    Light(0.0, elevation, 0.8, 0.2))[0, 0, 0] for elevation in elevations]
    assert np.abs(np.diff(levels)).max() < 1.0
    assert levels[0] == 51.0
    assert levels[-1] == pytest.approx(255 * (0.2 + 0.8 * math.cos(DIM_BELOW)))
    assert Light(elevation=DIM_BELOW, intensity=3.0).sunlight == 3.0
    assert Light(elevation=math.pi / 2).sunlight == 0.8


@pytest.mark.parametrize('normal', [
    (0.0, 0.0, 0.0), (math.nan, 0.0, 1.0), (math.inf, 0.0, 0.0), (1e200, 1e200, 0.0)])
def test_invalid_normals_get_ambient_light(normal):
    colours = shade(np.array([normal]), Surface((100, 100, 100)), Light(ambient=0.5))
    np.testing.assert_allclose(colours, 50.0)


@pytest.mark.parametrize('viewpoint', [(3.0, -2.0, 5.0, 1.0), (0.6, 0.0, 0.8, 0.0)])
def test_blinns_reflection_on_both_sides(viewpoint):
    rng = np.random.default_rng(2)
    normals, points = rng.normal(size=(2, 500, 3))
    light, viewpoint = Light(azimuth=0.4, elevation=0.6, intensity=0.7, ambient=0.0), \
        np.array(viewpoint)
    material = Surface((0, 0, 0), specular=0.6, shininess=12.0)
    n = normals / np.linalg.norm(normals, axis=1)[:, None]
    eye = viewpoint[:3] - viewpoint[3] * points
    eye /= np.linalg.norm(eye, axis=1)[:, None]
    half = eye + light.direction
    half /= np.linalg.norm(half, axis=1)[:, None]
    expected = []
    for normal in (n, -n):
        is_lit = (normal @ light.direction > 0) & (np.sum(normal * eye, axis=1) > 0)
        cosine = np.maximum(np.sum(normal * half, axis=1), 0.0)
        expected.append(np.where(is_lit, 255 * 0.7 * 0.6 * cosine ** 12, 0.0))
    colours = shade(normals, material, light, points, viewpoint)
    assert np.max(expected) > 50
    for channel in range(3):
        np.testing.assert_allclose(colours[:, :, channel], expected, rtol=1e-9, atol=1e-9)


def test_a_reflection_does_not_wrap():
    colours = shade(np.array([[0.0, 0.0, 1.0]]), Surface((100, 255, 0), specular=10.0),
                    Light(elevation=math.pi / 2, intensity=10.0))
    np.testing.assert_array_equal(colours[0, 0], [255, 255, 255])


def test_the_sun_shines_through_to_the_other_side():
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8]])
    light = Light(elevation=math.pi / 2, intensity=0.5, ambient=0.1)
    lit, behind = shade(normals, Surface((200, 100, 50), 0.8, transmission=0.3), light)
    cosine = normals[:, 2:]
    colour = np.array([[200, 100, 50]])
    np.testing.assert_allclose(lit, colour * (0.1 + 0.5 * 0.8 * cosine), rtol=1e-12)
    np.testing.assert_allclose(behind, colour * (0.1 + 0.5 * 0.3 * cosine), rtol=1e-12)


def test_a_sun_below_the_ground_neither_mirrors_nor_shines_through():
    light = Light(elevation=-0.2, intensity=5.0, ambient=0.5)
    material = Surface((100, 100, 100), specular=1.0, transmission=1.0)
    np.testing.assert_allclose(shade(np.eye(3), material, light), 50.0)


@pytest.mark.parametrize('kind, name, value', [
    (Light, 'azimuth', math.nan), (Light, 'elevation', math.inf), (Light, 'intensity', -1.0),
    (Light, 'elevation', 45), (Light, 'elevation', -1.6), (Light, 'azimuth', 90),
    (Light, 'azimuth', '1'), (Surface, 'color', (1.0, 0, 0)), (Surface, 'color', (0, 0.5, 0.2)),
    (Surface, 'color', 'red'), (Surface, 'color', 255), (Surface, 'diffuse', '1'),
    (Light, 'ambient', -0.1), (Light, 'ambient', math.inf), (Surface, 'color', (1, 2)),
    (Surface, 'color', (0, 0, 256)), (Surface, 'color', (-1, 0, 0)),
    (Surface, 'color', (math.nan, 0, 0)), (Surface, 'diffuse', -1.0),
    (Surface, 'specular', -0.1), (Surface, 'shininess', math.inf),
    (Surface, 'transmission', math.nan)])
def test_invalid_values_are_refused_by_name(kind, name, value):
    with pytest.raises(ValueError, match=name):
        kind(**{name: value})


def test_limits_that_messages_print_are_allowed():
    assert Light(azimuth=-6.28319, elevation=1.5708).elevation == math.pi / 2
    assert Camera(azimuth=6.28319, elevation=-1.5708, roll=6.28319).roll == 2 * math.pi


def test_black_is_a_colour_and_so_is_what_is_not_quite_black():
    assert Surface((0, 0, 0)).color == (0.0, 0.0, 0.0)
    assert Surface((2, 1, 0)).color == (2.0, 1.0, 0.0)
