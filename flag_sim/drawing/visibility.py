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

While triangles are drawn, a pixel only stores which face it sees; from that and its depth any
attribute follows (see planes and attributes) without another look at the rasterizer, as with
nvdiffrast's rasterize and interpolate (Laine et al., 2020).

A face is a side of one of the scene's triangles, also where clipping leaves a part of it.
"""
from typing import NamedTuple

from flag_sim.drawing.planes import at_pixel
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# What pixels hold where nothing is drawn.
NO_FACE = np.uint32(0)
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


@late_inner_kernel
def face_mark(face):
    """Return what pixels hold that see a face: twice the triangle's index, plus 1 on its back."""
    return np.uint32(face) + np.uint32(1)


@late_inner_kernel
def triangle_of(mark):
    """Return the index of the triangle that a pixel sees; of a pixel that sees nothing, 0."""
    mark = np.uint32(mark & ~OUTLINE)
    return np.uint32(max(mark, np.uint32(1)) - np.uint32(1)) >> np.uint32(1)


@late_inner_kernel
def is_back(mark):
    """Return whether a pixel that sees something sees the back of a triangle."""
    return (mark & np.uint32(1)) == 0


@late_kernel
def write_faces(faces, region, image):
    """Write the faces of a Region of a band's buffers into an image (height, width)."""
    for row in range(region.first, region.first + region.rows):
        source, target = np.uint64(row * region.stride), np.uint64(region.top + row)
        for i in range(np.uint64(region.left), np.uint64(region.right)):
            image[target, i] = faces[source + i]


@late_kernel
def write_visibility(area, marks, depth, attributes, images):
    """
    Resolve what pixels of a row see.

    area: the row, their first column and the end; marks, depth: of the row; attributes: see
    channels; images: triangles, is_back and weights of a Visibility.
    """
    triangles, are_back, weights = images
    row, left, right = area
    planes, is_perspective, v = attributes.weights, attributes.is_perspective, np.float64(row)
    for i in range(left, right):
        mark, u = marks[i], np.float64(i)
        t = triangle_of(mark)
        is_seen = mark != NO_FACE
        z = np.float64(depth[i]) if is_perspective else 1.0
        weight_b = z * at_pixel(planes, 0, t, u, v)
        weight_c = z * at_pixel(planes, 1, t, u, v)
        weight_b = min(max(weight_b, 0.0), 1.0) if is_seen else 0.0
        weight_c = min(max(weight_c, 0.0), 1.0 - weight_b) if is_seen else 0.0
        triangles[row, i] = np.int32(t) if is_seen else np.int32(-1)
        are_back[row, i] = is_seen & is_back(mark)
        weights[row, i, 0], weights[row, i, 1] = weight_b, weight_c


@late_inner_kernel
def weights_of(weights, row, column):
    """Return the weights of the three vertices at a pixel, of a Visibility's weights."""
    of_b, of_c = float(weights[row, column, 0]), float(weights[row, column, 1])
    return 1.0 - of_b - of_c, of_b, of_c
