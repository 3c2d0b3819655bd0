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

The source calls them shift, scaling about a point, and turns about the axes.

Maps compose by ``@``, the one applied first standing rightmost: ``rotate_z(a) @ translate(d)``
moves, then turns. Angles are in radians and turn right-handed: seen against the axis,
counterclockwise. All functions raise ValueError for other
shapes and types, and for numbers that are not finite, but for points to be mapped.
"""
from collections.abc import Sequence
import math

from flag_sim.drawing import ranges
from flag_sim.parameters import checks

import numpy as np

ORIGIN = (0.0, 0.0, 0.0)


def translate(offset: Sequence[float]) -> np.ndarray:
    """Return the translation by `offset` (3,) [m]: (4, 4) (eq. 2.1)."""
    matrix = np.eye(4)
    matrix[:3, 3] = _vector('offset', offset)
    return matrix


def scale(factors: Sequence[float], centre: Sequence[float] = ORIGIN) -> np.ndarray:
    """Return the map that scales the axes by `factors` (3,) about `centre` (3,) [m] (eq. 2.2)."""
    return _about(centre, np.diag([*_vector('factors', factors), 1.0]))


def rotate_x(angle: float, centre: Sequence[float] = ORIGIN) -> np.ndarray:
    """Return the rotation by `angle` [rad] about X, through `centre` (3,) [m] (eq. 2.3)."""
    return _about(centre, _rotate(angle, 1, 2))


def rotate_y(angle: float, centre: Sequence[float] = ORIGIN) -> np.ndarray:
    """Return the rotation by `angle` [rad] about Y, through `centre` (3,) [m] (eq. 2.4)."""
    return _about(centre, _rotate(angle, 2, 0))


def rotate_z(angle: float, centre: Sequence[float] = ORIGIN) -> np.ndarray:
    """Return the rotation by `angle` [rad] about Z, through `centre` (3,) [m] (eq. 2.5)."""
    return _about(centre, _rotate(angle, 0, 1))


def apply(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """
    Map `points` (..., 3) [m] by the affine `matrix` (4, 4); the shape is kept.

    Points that are not finite stay so.
    """
    matrix, points = checks.array('matrix', matrix, (4, 4)), ranges.numbers('points', points)
    checks.require(points.ndim > 0 and points.shape[-1] == 3, 'points', 'of shape (..., 3)',
                   points.shape)
    with np.errstate(invalid='ignore'):  # of infinite points no sum may be left
        return points @ matrix[:3, :3].T + matrix[:3, 3]


def quaternion(matrix: np.ndarray) -> tuple[float, float, float, float]:
    """
    Return the rotation of a map (4, 4) as a unit quaternion: x, y, z and w, which is not below 0.

    Of its four squares, which the diagonal gives, the greatest is divided by (Shepperd, 1978).
    """
    m = checks.array('matrix', matrix, (4, 4))
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    products = np.array([  # of each pair of x, y, z, w, times four
        [1.0 + 2.0 * m[0, 0] - trace, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]],
        [m[0, 1] + m[1, 0], 1.0 + 2.0 * m[1, 1] - trace, m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]],
        [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 1.0 + 2.0 * m[2, 2] - trace, m[1, 0] - m[0, 1]],
        [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1.0 + trace]])
    found = products[np.argmax(np.diag(products))]
    found = found / math.copysign(np.linalg.norm(found), found[3])
    return tuple(map(float, found))


def _rotate(angle, first, second):
    """Turn the axis numbered `first` towards the axis numbered `second`."""
    angle = checks.finite('angle', angle)
    matrix = np.eye(4)
    matrix[first, first] = matrix[second, second] = math.cos(angle)
    matrix[second, first] = math.sin(angle)
    matrix[first, second] = -math.sin(angle)
    return matrix


def _vector(name, value):
    """Return three finite numbers as float64."""
    vector = ranges.points(name, value, (3,)).astype(np.float64)
    checks.require(np.isfinite(vector).all(), name, 'finite', vector.tolist())
    return vector


def _about(centre, matrix):
    """Apply `matrix` with `centre` in place of the origin."""
    centre = _vector('centre', centre)
    return translate(centre) @ matrix @ translate(-centre)
