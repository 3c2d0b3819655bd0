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

"""The affine maps against points whose images are known."""
import math

from flag_sim.drawing import transforms

import numpy as np

import pytest

QUARTER = math.pi / 2.0


def test_shift_moves():
    assert transforms.apply(transforms.translate((1, 2, 3)), (10, 20, 30)) == pytest.approx(
        (11, 22, 33))


def test_scale_keeps_its_centre_and_stretches_each_axis():
    matrix = transforms.scale((2, 3, 4), centre=(1, 1, 1))
    assert transforms.apply(matrix, (1, 1, 1)) == pytest.approx((1, 1, 1))
    assert transforms.apply(matrix, (2, 2, 2)) == pytest.approx((3, 4, 5))


@pytest.mark.parametrize('turn, point, image', [
    (transforms.rotate_x, (0, 1, 0), (0, 0, 1)),
    (transforms.rotate_y, (0, 0, 1), (1, 0, 0)),
    (transforms.rotate_z, (1, 0, 0), (0, 1, 0)),
])
def test_a_quarter_turn_is_right_handed(turn, point, image):
    assert transforms.apply(turn(QUARTER), point) == pytest.approx(image, abs=1e-15)


@pytest.mark.parametrize('turn, axis', [
    (transforms.rotate_x, 0), (transforms.rotate_y, 1), (transforms.rotate_z, 2)])
def test_a_turn_keeps_its_axis_lengths_and_has_an_inverse(turn, axis):
    centre = np.array([3.0, -2.0, 5.0])
    matrix = turn(0.7, centre)
    on_axis = centre.copy()
    on_axis[axis] += 4.0
    assert transforms.apply(matrix, on_axis) == pytest.approx(on_axis)
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    assert matrix @ turn(-0.7, centre) == pytest.approx(np.eye(4), abs=1e-14)


def test_maps_compose_from_right_to_left():
    matrix = transforms.rotate_z(QUARTER) @ transforms.translate((1, 0, 0))
    assert transforms.apply(matrix, (0, 0, 0)) == pytest.approx((0, 1, 0), abs=1e-15)


def test_apply_keeps_the_shape():
    assert transforms.apply(np.eye(4), np.zeros((4, 5, 3))).shape == (4, 5, 3)
