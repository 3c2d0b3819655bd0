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

"""Geometry: a scene's triangles as arrays for the kernels, and its vertices on the screen."""
import functools
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.clipping import INSIDE, outcode
from flag_sim.drawing.depth import to_reversed_z
from flag_sim.jit.kernels import late_kernel

import numpy as np

# Vertices are snapped to this grid within a pixel, which makes coverage exact (see coverage).
SUBPIXEL_BITS = 8
SUBPIXELS = 2 ** SUBPIXEL_BITS


class ViewTransform(NamedTuple):
    """
    How points get to the screen.

    matrix: (4, 4) from the world to the optical frame, x and y scaled to pixels at depth 1;
    centre_u, centre_v: the principal point [pixel]; near: depth of the near plane [m];
    is_perspective: whether x and y are divided by the depth.
    """

    matrix: np.ndarray
    centre_u: float
    centre_v: float
    near: float
    is_perspective: bool


class Vertices(NamedTuple):
    """
    Vertices as the camera sees them.

    view_space: (n, 3) float64, (X, Y, z) in the optical frame, X and Y in pixels at depth 1;
    u, v: (n,) int32 on the screen [subpixel]; reversed_z: (n,) float64, see depth; outcodes: (n,)
    int32, see clipping. u, v and reversed_z are only set for vertices that are INSIDE.
    """

    view_space: np.ndarray
    u: np.ndarray
    v: np.ndarray
    reversed_z: np.ndarray
    outcodes: np.ndarray


def new_vertices(count: int) -> Vertices:
    """Make the arrays for so many vertices."""
    return Vertices(np.empty((count, 3)), *np.empty((2, count), np.int32), np.empty(count),
                    np.empty(count, np.int32))


def part_of(vertices: Vertices, own: slice) -> Vertices:
    """Return some of the vertices, in the same memory."""
    return Vertices(*(array[own] for array in vertices))


@functools.lru_cache(maxsize=8)
def view_transform(camera: Camera) -> ViewTransform:
    """Return a camera for the kernels."""
    matrix = np.diag([camera.focal, camera.focal, 1.0, 1.0]) @ camera.pose
    return ViewTransform(matrix, *map(float, camera.centre), camera.near, camera.is_perspective)


class Geometry(NamedTuple):
    """
    All triangles of a scene.

    triangles: (m, 3) int32, indices of vertices; is_closed: (m,) uint8, 1 where the triangle is
    of a closed body, whose back faces are culled; sizes: (m,) uint8, see culling.
    """

    triangles: np.ndarray
    is_closed: np.ndarray
    sizes: np.ndarray
    vertices: Vertices
    transform: ViewTransform


@late_kernel
def project(positions, transform, vertices):
    """Take points (n, 3) [m] to the screen: write `vertices`."""
    matrix, centre_u, centre_v, near, is_perspective = transform
    view_space, u, v, reversed_z, outcodes = vertices
    m00, m01, m02, m03 = matrix[0, 0], matrix[0, 1], matrix[0, 2], matrix[0, 3]
    m10, m11, m12, m13 = matrix[1, 0], matrix[1, 1], matrix[1, 2], matrix[1, 3]
    m20, m21, m22, m23 = matrix[2, 0], matrix[2, 1], matrix[2, 2], matrix[2, 3]
    for i in range(positions.shape[0]):
        px, py, pz = positions[i, 0], positions[i, 1], positions[i, 2]
        x = m00 * px + m01 * py + m02 * pz + m03
        y = m10 * px + m11 * py + m12 * pz + m13
        z = m20 * px + m21 * py + m22 * pz + m23
        view_space[i, 0], view_space[i, 1], view_space[i, 2] = x, y, z
        outcodes[i] = outcode(x, y, z, near, is_perspective)
        if outcodes[i] == INSIDE:
            u[i], v[i], reversed_z[i] = to_screen(x, y, z, centre_u, centre_v, is_perspective)


@late_kernel
def to_screen(x, y, z, centre_u, centre_v, is_perspective):
    """Project a point of the optical frame: u and v, snapped [subpixel], and reversed Z."""
    s = to_reversed_z(z, is_perspective)
    scale = s if is_perspective else 1.0
    return _snap(centre_u + x * scale), _snap(centre_v + y * scale), s


@late_kernel
def next_centre(coordinate):
    """Return the first pixel whose centre is not before a coordinate [subpixel]."""
    return np.int32((coordinate + (SUBPIXELS - 1)) >> SUBPIXEL_BITS)


@late_kernel
def _snap(value):
    return np.int32(np.floor(value * SUBPIXELS + 0.5))
