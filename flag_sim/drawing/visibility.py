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
Visibility: which triangle each pixel sees, and where in the triangle (Burns and Hunt, 2013).

While triangles are drawn, a pixel only stores the ID of the primitive that it sees; when the band
is done, that is resolved to the scene's triangle and barycentric weights. From these any
attribute can be interpolated (see attributes) without another look at the rasterizer, as with
nvdiffrast's rasterize and interpolate (Laine et al., 2020).

A primitive is a triangle as it is drawn: one of the scene's, or one of those in which clipping
leaves it.
"""
from typing import NamedTuple

from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# The ID that pixels hold where nothing is drawn.
NO_PRIMITIVE = np.uint32(0)
# What is added to it where the pixel sees a line of the triangle's outline.
OUTLINE = np.uint32(2 ** 31)


class Visibility(NamedTuple):
    """
    What each pixel's centre sees.

    triangles: (height, width) int32, indices of the scene's triangles, in the order of its
    objects, -1 where nothing is; is_back: (height, width) bool, whether their backs are seen;
    weights: (height, width, 2) float32, barycentric weights in space of the second and the third
    vertex, none below 0, both together at most 1; corners: (m, 3) int32, the triangles' vertices;
    depths: (n,) of the vertices along the optical axis [m].
    """

    triangles: np.ndarray
    is_back: np.ndarray
    weights: np.ndarray
    corners: np.ndarray
    depths: np.ndarray


class Primitives(NamedTuple):
    """
    The primitives of a band by their IDs; of size 0 if they are not wanted.

    faces: (n,) int32, twice the triangle's index, one more if its back is seen; planes: (n, 6):
    the weights of its second and third vertex, times reversed Z in perspective: each at column 0
    and row 0 of the image, and its changes a column and a row.
    """

    faces: np.ndarray
    planes: np.ndarray


def new_primitives(count: int) -> Primitives:
    """Make the arrays for so many primitives."""
    return Primitives(np.empty(count, np.int32), np.empty((count, 6)))


@late_inner_kernel
def store_primitive(primitives, primitive_id, face, weight_b, weight_c, origin):
    """
    Write a primitive.

    weight_b, weight_c: a weight's value at the column and row `origin`, and its changes a column
    and a row.
    """
    u, v = origin
    primitives.faces[primitive_id] = face
    planes = primitives.planes
    planes[primitive_id, 0] = weight_b[0] - weight_b[1] * u - weight_b[2] * v
    planes[primitive_id, 1], planes[primitive_id, 2] = weight_b[1], weight_b[2]
    planes[primitive_id, 3] = weight_c[0] - weight_c[1] * u - weight_c[2] * v
    planes[primitive_id, 4], planes[primitive_id, 5] = weight_c[1], weight_c[2]


@late_kernel
def write_visibility(primitive_ids, depth, region, is_perspective, primitives, images):
    """
    Resolve what the pixels of a Region see.

    primitive_ids, depth: a band's buffers; images: triangles, is_back and weights of a
    Visibility.
    """
    triangles, is_back, weights = images
    faces, planes = primitives
    for row in range(region.first, region.first + region.rows):
        v = region.top + row
        for u in range(region.left, region.right):
            p = primitive_ids[row * region.stride + u] & ~OUTLINE
            if p == NO_PRIMITIVE:
                triangles[v, u] = -1
                is_back[v, u] = False
                weights[v, u, 0] = weights[v, u, 1] = 0.0
                continue
            triangles[v, u], is_back[v, u] = faces[p] >> 1, (faces[p] & 1) == 1
            divisor = float(depth[row * region.stride + u]) if is_perspective else 1.0
            weight_b = (planes[p, 0] + planes[p, 1] * u + planes[p, 2] * v) / divisor
            weight_c = (planes[p, 3] + planes[p, 4] * u + planes[p, 5] * v) / divisor
            weight_b = min(max(weight_b, 0.0), 1.0)
            weights[v, u, 0] = weight_b
            weights[v, u, 1] = min(max(weight_c, 0.0), 1.0 - weight_b)


@late_inner_kernel
def weights_of(weights, row, column):
    """Return the weights of the three vertices at a pixel, of a Visibility's weights."""
    of_b, of_c = float(weights[row, column, 0]), float(weights[row, column, 1])
    return 1.0 - of_b - of_c, of_b, of_c
