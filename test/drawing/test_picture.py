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

"""Whole frames: light, styles, sizes, backgrounds, and what stays from frame to frame."""
import math

from flag_sim.drawing import Camera, Dimensions, Light, Materials, Picture, Style, Surface

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

NOTHING = Dimensions(pole_visible=False, platform_visible=False)
WHITE = Materials(flag=Surface((255, 255, 255)))


def test_the_side_that_is_seen_is_lit():
    x, z = np.meshgrid([0.5, 1.5], [8.5, 7.5])
    square = np.stack([x, np.zeros((2, 2)), z], axis=-1)
    light = Light(azimuth=-math.pi / 2, elevation=0.1, intensity=0.5, ambient=0.25)
    for flag in (square, square[:, ::-1]):
        levels = []
        for azimuth in (-math.pi / 2, math.pi / 2):
            rgb = Picture().draw(flag, None, Camera(azimuth=azimuth, target=(1, 0, 8)), light,
                                 WHITE, NOTHING).colour
            levels.append(int(rgb[240, 320, 0]))
        # Sun and eye on one side: lit. Eye on the other side: in the shade.
        assert levels == [191, 64]


def test_flat_shading_gives_each_triangle_one_colour():
    camera, flag = Camera(width=300, height=200), wave(3, 4)
    flat, smooth = (
        Picture().draw(flag, None, camera, Light(-0.5, 0.2, 0.6, 0.2), WHITE, NOTHING,
                       Style(shading=shading)).colour for shading in ('flat', 'gouraud'))
    # Twelve triangles and the background.
    assert 5 < len(np.unique(flat.reshape(-1, 3), axis=0)) <= 13
    assert len(np.unique(smooth.reshape(-1, 3), axis=0)) > 13


def test_interpolations_differ_little_but_do():
    camera = Camera(distance=0.7, azimuth=-0.6)
    screen, perspective = (DepthPicture().draw(
        wave(5, 7), camera=camera, style=Style(interpolation=name)).colour.astype(int)
        for name in ('screen', 'perspective'))
    assert 0 < np.abs(screen - perspective).max() < 60


def test_given_normals_are_used_and_missing_ones_averaged():
    flag = wave()
    own = DepthPicture().draw(flag).colour
    along, down = np.gradient(flag, axis=1), np.gradient(flag, axis=0)
    given = DepthPicture().draw(flag, np.cross(along, down)).colour
    assert 0 < np.abs(own.astype(int) - given).max() < 25
    assert not np.array_equal(DepthPicture().draw(flag, np.zeros_like(flag)).colour, own)


@pytest.mark.parametrize('width, height', [(1, 1), (1, 50), (50, 1), (3, 7), (7680, 4320)])
def test_sizes(width, height):
    picture = DepthPicture()
    camera = Camera(width=width, height=height, target=(1.2, 0.3, 8.0), distance=3.0)
    rgb = picture.draw(wave(), camera=camera).colour
    assert rgb.shape == (height, width, 3)
    assert rgb.dtype == np.uint8 and rgb.flags.c_contiguous
    assert picture.frame.depth.shape == (height, width)
    assert picture.frame.depth.dtype == np.float32
    assert np.isfinite(picture.frame.depth[height // 2, width // 2])


def test_one_picture_serves_cameras_and_grids_of_changing_size():
    picture = DepthPicture()
    for width, rows in ((64, 5), (33, 9), (64, 5), (200, 2)):
        camera = Camera(width=width, height=48)
        np.testing.assert_array_equal(picture.draw(wave(rows, 7), camera=camera).colour,
                                      DepthPicture().draw(wave(rows, 7), camera=camera).colour)


def test_background_is_where_nothing_is():
    picture = DepthPicture()
    rgb = picture.draw(wave(), style=Style(background=(1, 2.6, 255))).colour
    nothing = np.isinf(picture.frame.depth)
    assert 0.2 < nothing.mean() < 0.95
    assert (rgb[nothing] == (1, 3, 255)).all()


def test_the_same_input_gives_the_same_picture():
    picture, flag = DepthPicture(), wave()
    first, depth = picture.draw(flag).colour.copy(), picture.frame.depth
    picture.draw(wave(phase=1.0), camera=Camera(projection='orthographic')).colour
    np.testing.assert_array_equal(picture.draw(flag).colour, first)
    np.testing.assert_array_equal(picture.frame.depth, depth)
    np.testing.assert_array_equal(DepthPicture().draw(flag.copy()).colour, first)


@pytest.mark.parametrize('width', [64, 61])
def test_nothing_of_earlier_frames_is_left(width):
    picture = DepthPicture()
    rng = np.random.default_rng(4)
    for number in range(60):
        camera = Camera(width=width, height=47, distance=rng.choice([0.0, 3.0, 9.0]),
                        azimuth=rng.uniform(-3, 3), elevation=rng.uniform(-1.5, 1.5))
        dimensions = Dimensions(pole_visible=number % 3 > 0, platform_visible=number % 4 > 1)
        style = Style(background=(number // 7, 0, 9))
        flag = wave(5, 7, phase=number) + rng.normal(size=3)
        fresh = DepthPicture()
        rgb = picture.draw(flag, camera=camera, dimensions=dimensions, style=style).colour
        np.testing.assert_array_equal(
            rgb, fresh.draw(flag, camera=camera, dimensions=dimensions, style=style).colour)
        np.testing.assert_array_equal(picture.frame.depth, fresh.frame.depth)


def test_the_frame_is_read_only():
    with pytest.raises(ValueError, match='read-only'):
        DepthPicture().draw(wave()).colour[0, 0] = 0


def test_float32_vertices_are_as_good():
    flag = wave().astype(np.float32)
    np.testing.assert_array_equal(Picture().draw(flag).colour,
                                  Picture().draw(flag.astype(float)).colour)


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf, 1e308])
def test_a_bad_vertex_takes_its_triangles_alone(bad):
    flag, picture = wave(), DepthPicture()
    good = picture.draw(flag, dimensions=NOTHING).colour.copy()
    flag[10, 15, 1] = bad
    holed = picture.draw(flag, dimensions=NOTHING).colour
    background = (180, 240, 240)
    gone = (holed == background).all(-1) & ~(good == background).all(-1)
    assert 100 < gone.sum() < 5000
    flag[:] = bad
    assert (picture.draw(flag, dimensions=NOTHING).colour == background).all()


def test_the_default_camera_shows_the_whole_flag_and_the_tip():
    camera = Camera()
    for turn in (0.0, 0.25, 0.5):
        s, z = np.meshgrid([0.0, 2.25], [8.9, 7.4])
        flag = np.stack([0.05 + s * math.cos(turn), s * math.sin(turn), z], axis=-1)
        picture = DepthPicture()
        picture.draw(flag, dimensions=NOTHING).colour
        v, u = np.nonzero(np.isfinite(picture.frame.depth))
        assert 20 < u.min() and u.max() < camera.width - 20
        assert 20 < v.min() and v.max() < camera.height - 20
        # Large, though there is room below for the flag when it hangs.
        assert len(u) > camera.width * camera.height / 6
    tip = camera.P @ camera.pose @ np.array([0.0, 0.0, 9.1, 1.0])
    assert 10 < tip[1] / tip[2] < camera.height / 2


def test_a_frame_holds_what_was_asked_for_and_copies_stay():
    picture = Picture()
    assert picture.draw(wave()).depth is None
    frame = picture.draw(wave(), channels=['depth'])
    kept = frame.copy()
    other = picture.draw(wave(phase=2.0), channels=['depth'])
    assert not np.array_equal(kept.colour, other.colour)
    again = Picture().draw(wave(), channels=['depth'])
    np.testing.assert_array_equal(kept.colour, again.colour)
    np.testing.assert_array_equal(kept.depth, again.depth)
    for array in (other.colour, other.depth):
        with pytest.raises(ValueError, match='read-only'):
            array[0, 0] = 0
