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

"""Outlines against Bresenham's own algorithm, and hidden ones."""
from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style, Surface

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

NOTHING = Dimensions(pole_visible=False, platform_visible=False)
LIGHT = Light(intensity=0.0, ambient=1.0)
# One metre a pixel; the origin is the centre of pixel (20, 15).
CAMERA = Camera(41, 31, 'orthographic', scale=31.0, target=(0, 0, 0), elevation=0.0)
RED, DARK = (240, 120, 60), (200, 100, 50)  # DARK = RED / 1.2


def bresenham(u, v, u_end, v_end):
    """Walk from pixel to pixel with a running error: {(u, v)}; ties go to the greater one."""
    is_steep = abs(v_end - v) > abs(u_end - u)
    if is_steep:
        u, v, u_end, v_end = v, u, v_end, u_end
    length, rise = abs(u_end - u), abs(v_end - v)
    way, up = (1 if u_end >= u else -1), (1 if v_end >= v else -1)
    pixels, error = set(), length
    for _ in range(length + 1):
        pixels.add((v, u) if is_steep else (u, v))
        u += way
        error += 2 * rise
        # A tie steps upwards, but not yet downwards.
        while error >= 2 * length > 0 if up > 0 else error > 2 * length > 0:
            v += up
            error -= 2 * length
    return pixels


def draw(corners, **options):
    """Draw a triangle of whole pixels (3, 2), as a flag of two rows and columns."""
    (au, av), (bu, bv), (cu, cv) = corners
    u, v = np.array([[au, bu], [cu, cu]]), np.array([[av, bv], [cv, cv]])
    flag = np.stack([u - 20.0, np.zeros((2, 2)), 15.0 - v], axis=-1)
    return Picture().draw(flag, None, CAMERA, LIGHT, Materials(Surface(RED)), NOTHING,
                          Style(outline=True, **options)).colour


@pytest.mark.parametrize('hidden_surface', ['zbuffer', 'painter'])
def test_edges_are_bresenhams_lines(hidden_surface):
    rng = np.random.default_rng(9)
    for number in range(200):
        reach = (0, 41) if number % 2 else (-30, 70)
        corners = rng.integers(*reach, (3, 2))
        (au, av), (bu, bv), (cu, cv) = corners
        if (bu - au) * (cv - av) == (cu - au) * (bv - av):
            continue
        expected = set()
        for begin, end in ((0, 1), (1, 2), (2, 0)):
            # Always from left to right, so that the triangles of an edge share its pixels.
            expected |= bresenham(*(int(x) for p in sorted([tuple(corners[begin]),
                                                           tuple(corners[end])]) for x in p))
        v, u = np.nonzero((draw(corners, hidden_surface=hidden_surface) == DARK).all(-1))
        assert set(zip(u.tolist(), v.tolist())) == {
            (u, v) for u, v in expected if 0 <= u < 41 and 0 <= v < 31}


@pytest.mark.parametrize('order', [1, -1])
def test_hidden_edges_stay_hidden(order):
    camera = Camera()
    flag, wall = wave(), wave()
    wall[..., 1] = -1.0  # a sheet that stands before the other one, joined at the lower edge
    wall = wall[::-1]
    both = np.concatenate([flag, wall])
    # The hidden sheet is drawn before the other one, and after it.
    wall, both = wall[::order], both[::order]
    alone, hidden = (Picture().draw(cloth, None, camera, LIGHT, Materials(Surface(RED)), NOTHING,
                                    Style(outline=True)).colour for cloth in (wall, both))
    picture = DepthPicture()
    picture.draw(wall, camera=camera, dimensions=NOTHING).colour
    v, u = np.nonzero(np.isfinite(picture.frame.depth))
    inside = np.zeros(alone.shape[:2], bool)
    inside[v, u] = True
    # Beside its rim the sheet's own lines stand alone; within, nothing shines through.
    np.testing.assert_array_equal(hidden[inside], alone[inside])


def test_every_triangle_shows_its_edges():
    camera = Camera(1280, 720)
    rgb = Picture().draw(wave(9, 13), None, camera, LIGHT, Materials(Surface(RED)), NOTHING,
                         Style(outline=True)).colour
    points = wave(9, 13) @ camera.pose[:3, :3].T + camera.pose[:3, 3]
    image = points @ camera.K.T
    u, v = np.round(image[..., :2] / image[..., 2:]).astype(int).transpose(2, 0, 1)
    assert (rgb[v, u] == DARK).all(-1).mean() > 0.9
    centres = (image[:-1, :-1] + image[:-1, 1:] + image[1:, :-1]) / 3
    u, v = np.round(centres[..., :2] / centres[..., 2:]).astype(int).transpose(2, 0, 1)
    assert (rgb[v, u] == RED).all()


def test_perspective_correct_lines_are_as_dark():
    rgb = draw([(3, 3), (35, 8), (10, 28)], interpolation='perspective')
    assert {tuple(colour) for colour in rgb.reshape(-1, 3)} == {RED, DARK, (180, 240, 240)}
    rgb = Picture().draw(wave(9, 13), None, Camera(), LIGHT, Materials(Surface(RED)), NOTHING,
                         Style(outline=True, interpolation='perspective')).colour
    assert {tuple(colour) for colour in rgb.reshape(-1, 3)} == {RED, DARK, (180, 240, 240)}
