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

"""What is kept or left out to save time changes no bit: flat tiles, rows, planes and maps."""
import dataclasses

from flag_sim.drawing import Camera, flag_scene, Light, Materials, Picture, Style, Texture
from flag_sim.drawing.flat_tiles import NOT_FLAT
from flag_sim.drawing.scene import LastFrame

import numpy as np

import pytest

from support.flags import wave

CAMERA = Camera(320, 240, distance=6.0)


def fields(height, width):
    """Return a picture of large fields of one colour, thin lines, and a part that is none."""
    image = np.zeros((height, width, 3), np.uint8)
    image[:] = 12, 200, 90
    image[height // 3:, :width // 2] = 255, 0, 1
    image[height // 2] = 3
    image[:, width // 3] = 250
    part = image[2 * height // 3:, 2 * width // 3:]
    part[:] = np.random.default_rng(1).integers(0, 256, part.shape)
    return image


@pytest.mark.parametrize('size', [(256, 384), (301, 77), (64, 33)])
@pytest.mark.parametrize('distance', [2.0, 6.0, 15.0, 60.0])  # texels larger and smaller
def test_flat_tiles_are_what_looking_up_all_texels_gives(size, distance):
    quick, slow = (Texture(fields(*size)) for _ in range(2))
    slow.flats = np.empty(0, np.uint32)
    assert 0.3 < np.mean(quick.flats != NOT_FLAT) < 1.0
    camera = dataclasses.replace(CAMERA, distance=distance, target=(1.2, 0.0, 8.2))
    shown, expected = (Picture().draw(wave(), camera=camera,
                                      materials=Materials(flag_image=texture)).colour
                       for texture in (quick, slow))
    np.testing.assert_array_equal(shown, expected)


def test_where_hardly_any_tile_is_flat_none_is_asked_for():
    noise = np.random.default_rng(1).integers(0, 256, (64, 64, 3), np.uint8)
    assert Texture(noise).flats.size == 0


def test_flat_tiles_of_several_textures_are_told_apart():
    """Two flags, of which one has no flat tiles at all, beside each other."""
    noise = Texture(np.random.default_rng(2).integers(0, 256, (50, 40, 3), np.uint8))
    one, other = Texture(fields(60, 90)), Texture(fields(90, 60)[::-1])
    for textures in ((one, noise, other), (noise, other, one)):
        drawn = []
        for is_quick in (True, False):
            objects = []
            for k, texture in enumerate(textures):
                copy = texture if is_quick else Texture.__new__(Texture)
                if not is_quick:
                    copy.size, copy.texels, copy.levels, copy.flats = (
                        texture.size, texture.texels, texture.levels, np.empty(0, np.uint32))
                flag = wave() * 0.3 + np.array([0.8 * k - 0.5, 0.0, 6.0])
                objects.append(flag_scene(flag, camera=CAMERA,
                                          materials=Materials(flag_image=copy))[0])
            drawn.append(Picture().draw_scene(objects, CAMERA).colour)
        np.testing.assert_array_equal(*drawn)


def test_channels_of_a_kept_picture_are_those_of_a_fresh_one():
    """Also where the flag has left, other channels were asked for, or something was reset."""
    kept, channels = Picture(), ['normals', 'labels', 'texture_coordinates', 'flow']
    for turn, names in enumerate((channels, channels[:2], channels, ['labels'], channels[2:],
                                  [], channels, [*channels, 'visibility'])):
        camera = dataclasses.replace(CAMERA, target=(1.2 - 0.7 * (turn % 3), 0.0, 8.2 - turn % 2))
        last = LastFrame(wave(phase=turn), camera) if turn != 4 else None
        objects = flag_scene(wave(phase=turn + 0.2), None, camera, last=last)
        shown, expected = (picture.draw_scene(objects, camera, channels=names)
                           for picture in (kept, Picture()))
        for name in ('colour', *names):
            if name != 'visibility':
                np.testing.assert_array_equal(getattr(shown, name), getattr(expected, name))


def test_a_kept_shadow_map_is_a_fresh_one():
    kept = Picture()
    for turn in range(5):
        light = Light(azimuth=-1.9 + 0.3 * (turn % 2), elevation=0.5)
        flag = wave(phase=turn) * (1.0, 1.0, 1.0 - 0.02 * turn)
        shown, expected = (
            picture.draw(flag, camera=CAMERA, light=light, style=Style(shadows=turn != 2)).colour
            for picture in (kept, Picture()))
        np.testing.assert_array_equal(shown, expected)
