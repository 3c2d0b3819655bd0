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

"""Any number of threads makes the same picture."""
from flag_sim.drawing import Camera, Style
from flag_sim.drawing.bands import BAND
from flag_sim.drawing.multisample import TILE
from flag_sim.drawing.picture import WORTH_SHARING

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

STYLES = {
    'plain': Style(), 'samples': Style(samples=4), 'outline': Style(outline=True, samples=8),
    'painter': Style(hidden_surface='painter', shading='flat'),
    'perspective': Style(interpolation='perspective')}


@pytest.mark.parametrize('name', STYLES)
@pytest.mark.parametrize('width, height', [(640, 480), (61, 47), (3, 100), (50, 1)])
def test_the_same_picture_to_the_bit(name, width, height):
    one = DepthPicture(threads=1)
    others = [DepthPicture(threads) for threads in (0, 2, 3, 7)]
    for phase in range(4):
        look = {'camera': Camera(width, height, elevation=0.2 * phase), 'style': STYLES[name]}
        rgb = one.draw(wave(phase=phase), **look).colour
        for other in others:
            np.testing.assert_array_equal(other.draw(wave(phase=phase), **look).colour, rgb)
            np.testing.assert_array_equal(other.frame.depth, one.frame.depth)


def test_the_same_picture_where_vertices_are_shared_too():
    # More pieces of points and of triangles than are worth sharing.
    for style in (STYLES['plain'], STYLES['painter']):
        one, two = DepthPicture(1), DepthPicture(2)
        for phase in range(3):
            flag = wave(rows=150, columns=301, phase=phase)
            np.testing.assert_array_equal(two.draw(flag, style=style).colour,
                                          one.draw(flag, style=style).colour)
        assert sum(map(len, one._scene.chunks)) > WORTH_SHARING


def test_bands_hold_whole_tiles():
    # Or else a tile would be drawn by two bands, one part in each.
    assert BAND % TILE == 0
