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

"""
Affine maps as 4x4 matrices for column vectors: the source's equations 2.1 to 2.5.

Its words for them: shift, scale about a point, turn about the axes.

Maps compose by ``@``, the one applied first standing rightmost: ``rotate_z(a) @ translate(d)``
moves, then turns. Angles are in radians and turn right-handed: seen against the axis,
counterclockwise.
"""
import math

import numpy as np

ORIGIN = (0.0, 0.0, 0.0)


def translate(offset):
    """Shift by `offset` (3,) [m] (2.1)."""
    matrix = np.eye(4)
    matrix[:3, 3] = offset
    return matrix


def scale(factors, centre=ORIGIN):
    """Stretch by `factors` (3,), one an axis, about the point `centre` (3,) [m] (2.2)."""
    return _about(centre, np.diag([*factors, 1.0]))


def rotate_x(angle, centre=ORIGIN):
    """Turn by `angle` [rad] about the line along X through `centre` (3,) [m] (2.3)."""
    return _about(centre, _rotate(angle, 1, 2))


def rotate_y(angle, centre=ORIGIN):
    """Turn by `angle` [rad] about the line along Y through `centre` (3,) [m] (2.4)."""
    return _about(centre, _rotate(angle, 2, 0))


def rotate_z(angle, centre=ORIGIN):
    """Turn by `angle` [rad] about the line along Z through `centre` (3,) [m] (2.5)."""
    return _about(centre, _rotate(angle, 0, 1))


def apply(matrix, points):
    """Map `points` (..., 3) [m] by the affine `matrix` (4, 4); the shape is kept."""
    return np.asarray(points) @ matrix[:3, :3].T + matrix[:3, 3]


def _rotate(angle, first, second):
    """Turn the axis numbered `first` towards the axis numbered `second`."""
    matrix = np.eye(4)
    matrix[first, first] = matrix[second, second] = math.cos(angle)
    matrix[second, first] = math.sin(angle)
    matrix[first, second] = -math.sin(angle)
    return matrix


def _about(centre, matrix):
    """Apply `matrix` with `centre` in the part of the origin."""
    return translate(centre) @ matrix @ translate(np.negative(centre))
