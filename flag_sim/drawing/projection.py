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

"""Vertices to the screen, and the part of the image that they can cover."""
from flag_sim.drawing.clipping import INSIDE, OUTSIDE, whereabouts
from flag_sim.kernels import kernel

import numpy as np

# Vertices are snapped to this many places a pixel, which makes the edges' arithmetic exact.
PLACES = 256.0


@kernel
def project(vertices, matrix, cu, cv, near, is_perspective, view, screen, where):
    """
    Take vertices (n, 3) [m] to the screen.

    matrix: (4, 4) world to the optical frame, x and y scaled to pixels at depth 1; cu, cv: the
    principal point [pixel]. Writes view (n, 3): X, Y, z of that frame; screen (n, 3): u, v
    [pixel], snapped, and nearness, for vertices that are INSIDE; where (n,): see clipping.
    """
    for i in range(vertices.shape[0]):
        px, py, pz = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        x = matrix[0, 0] * px + matrix[0, 1] * py + matrix[0, 2] * pz + matrix[0, 3]
        y = matrix[1, 0] * px + matrix[1, 1] * py + matrix[1, 2] * pz + matrix[1, 3]
        z = matrix[2, 0] * px + matrix[2, 1] * py + matrix[2, 2] * pz + matrix[2, 3]
        view[i, 0], view[i, 1], view[i, 2] = x, y, z
        where[i] = whereabouts(x, y, z, near, is_perspective)
        if where[i] == INSIDE:
            screen[i, 0], screen[i, 1], screen[i, 2] = to_screen(x, y, z, cu, cv, is_perspective)


@kernel
def bounds(screen, where, width, height, margin):
    """
    Bound the pixels that a mesh can cover: rows top .. bottom - 1, columns left .. right - 1.

    margin: [pixel] more to all sides. A mesh with a vertex OUTSIDE can cover all of the image;
    one that is not seen gets no rows.
    """
    left, right, top, bottom = float(width), -1.0, float(height), -1.0
    for i in range(screen.shape[0]):
        if where[i] == OUTSIDE:
            return 0, height, 0, width
        if where[i] == INSIDE:
            left, right = min(left, screen[i, 0]), max(right, screen[i, 0])
            top, bottom = min(top, screen[i, 1]), max(bottom, screen[i, 1])
    left, right = max(np.ceil(left) - margin, 0.0), \
        min(np.floor(right) + 1.0 + margin, float(width))
    top, bottom = max(np.ceil(top) - margin, 0.0), \
        min(np.floor(bottom) + 1.0 + margin, float(height))
    if left >= right or top >= bottom:
        return 0, 0, 0, 0
    return int(top), int(bottom), int(left), int(right)


@kernel
def to_screen(x, y, z, cu, cv, is_perspective):
    """Project a point: u, v, snapped, and nearness."""
    if is_perspective:
        near = 1.0 / z
        return _snap(cu + x * near), _snap(cv + y * near), near
    return _snap(cu + x), _snap(cv + y), -z


@kernel
def _snap(value):
    return np.floor(value * PLACES + 0.5) / PLACES
