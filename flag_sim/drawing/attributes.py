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
Attributes: whatever a pixel shows of the triangle that it sees, interpolated between vertices.

Visibility leaves in each pixel the triangle that it sees, and here its barycentric weights become
known: from these any values of vertices or triangles follow, of any number of channels, without
another look at the rasterizer (as in nvdiffrast's rasterize and interpolate, Laine et al., 2020).
"""
from typing import NamedTuple

from flag_sim.drawing import ranges
from flag_sim.jit.kernels import inner_kernel, kernel
from flag_sim.parameters import checks

import numpy as np

INTERPOLATIONS = ('screen', 'perspective')
# The slot that pixels hold where nothing is.
NOTHING = np.uint32(0)


class Visibility(NamedTuple):
    """
    What each pixel's centre sees.

    triangles: (height, width) int32, numbers of the scene's triangles, in the order of its
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


def interpolate(visibility: Visibility, values, at='vertices', interpolation='perspective',
                nothing=np.nan) -> np.ndarray:
    """
    Return what pixels show of an attribute: (height, width, channels) float32.

    values: a list of arrays, one for each object of the scene, or one array for all: (n, channels)
    at vertices or, where `at` is 'triangles', (m, channels) of these; where the two sides have
    others, (n, 2, channels), the front first. interpolation: 'perspective' is
    linear in space, 'screen' from pixel to pixel, but where a triangle reaches behind the eye.
    nothing: what pixels show where nothing is. No value leaves the range of its triangle's
    vertices. Raises ValueError for other words, shapes and types.
    """
    checks.choice('at', at, ('vertices', 'triangles'))
    checks.choice('interpolation', interpolation, INTERPOLATIONS)
    parts = values if isinstance(values, (list, tuple)) else [values]
    parts = [_two_sided(f'values[{number}]', part) for number, part in enumerate(parts)]
    checks.require(len({part.shape[2] for part in parts}) == 1, 'values',
                   'of as many channels for each object', [part.shape[2] for part in parts])
    numbers = np.concatenate(parts)
    count = len(visibility.depths if at == 'vertices' else visibility.corners)
    checks.require(len(numbers) == count, 'values', f'for all {count} {at} of the scene',
                   len(numbers))
    image = np.empty((*visibility.triangles.shape, numbers.shape[2]), np.float32)
    _interpolate(visibility, numbers, at == 'triangles', interpolation == 'screen', nothing, image)
    return image


def _two_sided(name, values):
    """Return values as (n, 2, channels) float64."""
    array = np.asarray(values)
    array = ranges.points(name, array, (None, 2, None) if array.ndim == 3 else (None, None))
    array = array if array.ndim == 3 else np.repeat(array[:, None], 2, axis=1)
    return np.ascontiguousarray(array, dtype=np.float64)


@kernel
def _interpolate(visibility, values, at_triangles, is_on_screen, nothing, image):
    triangles, is_back, weights, corners, depths = visibility
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            t = triangles[row, column]
            if t < 0:
                image[row, column] = nothing
                continue
            side = 1 if is_back[row, column] else 0
            a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
            of_b, of_c = float(weights[row, column, 0]), float(weights[row, column, 1])
            of_a = 1.0 - of_b - of_c
            if is_on_screen and min(depths[a], depths[b], depths[c]) > 0.0:
                # Weights in space are those on the screen over depth, brought to a sum of 1.
                of_a, of_b, of_c = of_a * depths[a], of_b * depths[b], of_c * depths[c]
                whole = of_a + of_b + of_c
                of_a, of_b, of_c = of_a / whole, of_b / whole, of_c / whole
            for channel in range(image.shape[2]):
                if at_triangles:
                    image[row, column, channel] = values[t, side, channel]
                else:
                    at_a, at_b = values[a, side, channel], values[b, side, channel]
                    at_c = values[c, side, channel]
                    value = of_a * at_a + of_b * at_b + of_c * at_c
                    least, most = min(at_a, at_b, at_c), max(at_a, at_b, at_c)
                    image[row, column, channel] = min(max(value, least), most)


class Slots(NamedTuple):
    """
    What pixels see, by the slot that they hold; of size 0 if nobody wants to know.

    faces: (slots,) int32, twice the triangle's number, one more if its back is seen; planes:
    (slots, 6): of the weights of its second and third vertex, times reversed Z in perspective,
    each at column 0 and row 0 of the image, and their changes a column and a row.
    """

    faces: np.ndarray
    planes: np.ndarray


def new_slots(count: int) -> Slots:
    """Make arrays for so many slots."""
    return Slots(np.empty(count, np.int32), np.empty((count, 6)))


@inner_kernel
def keep_slot(slots, slot, face, of_b, of_c, where):
    """
    Write a slot.

    of_b, of_c: planes: a value at column and row `where`, its changes a column and a row.
    """
    u, v = where
    slots.faces[slot] = face
    planes = slots.planes
    planes[slot, 0] = of_b[0] - of_b[1] * u - of_b[2] * v
    planes[slot, 1], planes[slot, 2] = of_b[1], of_b[2]
    planes[slot, 3] = of_c[0] - of_c[1] * u - of_c[2] * v
    planes[slot, 4], planes[slot, 5] = of_c[1], of_c[2]


@kernel
def write_visibility(numbers, depths, area, is_perspective, slots, images):
    """
    Write what an Area's pixels see.

    numbers, depths: the slot and depth buffers; images: triangles, is_back and weights.
    """
    triangles, is_back, weights = images
    faces, planes = slots
    for row in range(area.first, area.first + area.rows):
        v = area.top + row
        for u in range(area.left, area.right):
            slot = numbers[row * area.stride + u]
            if slot == NOTHING:
                triangles[v, u] = -1
                is_back[v, u] = False
                weights[v, u, 0] = weights[v, u, 1] = 0.0
                continue
            triangles[v, u], is_back[v, u] = faces[slot] >> 1, (faces[slot] & 1) == 1
            divisor = float(depths[row * area.stride + u]) if is_perspective else 1.0
            of_b = (planes[slot, 0] + planes[slot, 1] * u + planes[slot, 2] * v) / divisor
            of_c = (planes[slot, 3] + planes[slot, 4] * u + planes[slot, 5] * v) / divisor
            of_b = min(max(of_b, 0.0), 1.0)
            weights[v, u, 0] = of_b
            weights[v, u, 1] = min(max(of_c, 0.0), 1.0 - of_b)


class Area(NamedTuple):
    """
    Pixels of a band: columns left .. right - 1 of `rows` rows from row `first` of its buffers on.

    Buffers have `stride` pixels a row; their row 0 is row `top` of the image.
    """

    top: int
    first: int
    rows: int
    left: int
    right: int
    stride: int
