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

"""Geometry: what is drawn, as arrays for the kernels, and its vertices taken to the screen."""
from typing import NamedTuple

from flag_sim.drawing.clipping import INSIDE, outcode
from flag_sim.jit.kernels import kernel

import numpy as np

# Along a pixel's side: vertices are snapped to them, so that what is covered can be told exactly.
SUBPIXEL_BITS = 8
SUBPIXELS = 2 ** SUBPIXEL_BITS


class Lens(NamedTuple):
    """
    How points get to the screen.

    matrix: (4, 4) world to the optical frame, x and y scaled to pixels at depth 1; cu, cv: the
    principal point [pixel]; near: [m], nothing nearer is drawn; is_perspective.
    """

    matrix: np.ndarray
    cu: float
    cv: float
    near: float
    is_perspective: bool


class Vertices(NamedTuple):
    """
    Vertices where the camera sees them.

    seen: (n, 3) float64: X, Y, z of the optical frame, X and Y in pixels at depth 1; outcodes:
    (n,) int32, see clipping; of those that are INSIDE, u, v: (n,) int32 [subpixel] and
    reversed_z: (n,) float64, greater where nearer: 1 / z in perspective, -z in orthographic
    projection. Both are affine on the screen and exact for planes.
    """

    seen: np.ndarray
    u: np.ndarray
    v: np.ndarray
    reversed_z: np.ndarray
    outcodes: np.ndarray


class Geometry(NamedTuple):
    """
    All triangles of a scene.

    triangles: (m, 3) int32, numbers of vertices; is_closed: (m,) uint8, 1 where the triangle is
    of a closed body, whose backs nobody sees; sizes: (m,) uint8, see culling.
    """

    triangles: np.ndarray
    is_closed: np.ndarray
    sizes: np.ndarray
    vertices: Vertices
    lens: Lens


@kernel
def project(points, lens, vertices):
    """Take points (n, 3) [m] to the screen: write `vertices`."""
    matrix, cu, cv, near, is_perspective = lens
    seen, u, v, reversed_z, outcodes = vertices
    m00, m01, m02, m03 = matrix[0, 0], matrix[0, 1], matrix[0, 2], matrix[0, 3]
    m10, m11, m12, m13 = matrix[1, 0], matrix[1, 1], matrix[1, 2], matrix[1, 3]
    m20, m21, m22, m23 = matrix[2, 0], matrix[2, 1], matrix[2, 2], matrix[2, 3]
    for i in range(points.shape[0]):
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        x = m00 * px + m01 * py + m02 * pz + m03
        y = m10 * px + m11 * py + m12 * pz + m13
        z = m20 * px + m21 * py + m22 * pz + m23
        seen[i, 0], seen[i, 1], seen[i, 2] = x, y, z
        outcodes[i] = outcode(x, y, z, near, is_perspective)
        if outcodes[i] == INSIDE:
            u[i], v[i], reversed_z[i] = to_screen(x, y, z, cu, cv, is_perspective)


@kernel
def next_centre(coordinate):
    """Return the first pixel whose centre is not before a coordinate [subpixel]."""
    return np.int32((coordinate + (SUBPIXELS - 1)) >> SUBPIXEL_BITS)


@kernel
def to_screen(x, y, z, cu, cv, is_perspective):
    """Project a point: u, v, snapped [subpixel], and reversed Z."""
    near = 1.0 / z if is_perspective else -z
    scale = near if is_perspective else 1.0
    return _snap(cu + x * scale), _snap(cv + y * scale), near


@kernel
def _snap(value):
    return np.int32(np.floor(value * SUBPIXELS + 0.5))
