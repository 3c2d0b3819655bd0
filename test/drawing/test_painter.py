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

"""The painter's order, and how far its picture is from the Z-buffer's."""
from flag_sim.drawing import Camera, Dimensions, Style
from flag_sim.drawing.painter import far_to_near

import numpy as np

import pytest

from support.flags import wave
from support.pictures import DepthPicture

PAINTER = Style(hidden_surface='painter')


def test_the_farthest_is_first_and_equals_keep_their_order():
    # More than the few that any sorting puts in by insertion, which keeps their order anyway.
    depths = np.tile([2.0, 5.0, 2.0, 9.0], 50)
    view = np.zeros((600, 3))
    view[:, 2] = np.repeat(depths, 3)
    triangles = np.arange(600, dtype=np.int32).reshape(-1, 3)
    assert far_to_near(triangles, view).tolist() == sorted(range(200), key=lambda t: -depths[t])


def test_a_lone_sheet_is_the_same_picture():
    nothing = Dimensions(pole_visible=False, platform_visible=False)
    flag = wave()
    flag[..., 1] *= 0.2  # no part of it hides another
    pictures = DepthPicture(), DepthPicture()
    np.testing.assert_array_equal(pictures[0].draw(flag, dimensions=nothing).colour,
                                  pictures[1].draw(flag, dimensions=nothing, style=PAINTER).colour)
    np.testing.assert_array_equal(pictures[0].frame.depth, pictures[1].frame.depth)


@pytest.mark.parametrize('projection', ['perspective', 'orthographic'])
def test_some_pixels_are_wrong_but_few(projection):
    # The pole's triangles are long and the flag's short: their centres compare badly there.
    wrong = covered = 0
    for azimuth in np.linspace(-3.0, 3.0, 12):
        camera = Camera(azimuth=azimuth, projection=projection)
        picture = DepthPicture()
        right = picture.draw(wave(), camera=camera).colour
        covered += np.isfinite(picture.frame.depth).sum()
        painted = DepthPicture().draw(wave(), camera=camera, style=PAINTER).colour
        wrong += (right != painted).any(axis=-1).sum()
    assert 0.0 < wrong / covered < 0.02
