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

"""Polygons: what the near plane, the guard band and back-face culling leave of a triangle."""
from typing import NamedTuple

from flag_sim.drawing.clipping import clip, CORNER_FIELDS, INSIDE, MAX_CORNERS
from flag_sim.drawing.geometry import to_screen
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# Clipping needs one corner more than it leaves.
CAPACITY = MAX_CORNERS + 1


class Polygon(NamedTuple):
    """
    What is seen of a triangle.

    corners: (2, CAPACITY, CORNER_FIELDS), see clipping; u, v: (CAPACITY,) int64 [subpixel];
    values: (CAPACITY, 4) at the corners: reversed Z; red, green and blue, in
    perspective-correct interpolation times reversed Z; planes: (4, 5), memory for the scanlines
    (see scanline).
    """

    corners: np.ndarray
    u: np.ndarray
    v: np.ndarray
    values: np.ndarray
    planes: np.ndarray


def new_polygon() -> Polygon:
    """Make a polygon's arrays."""
    return Polygon(np.empty((2, CAPACITY, CORNER_FIELDS)), *np.empty((2, CAPACITY), np.int64),
                   np.empty((CAPACITY, 4)), np.empty((4, 5)))


@late_kernel
def assemble_polygon(geometry, colours, triangle, state, polygon):
    """
    Write what is seen of a triangle into `polygon`; return its number of corners and its side.

    Backs of closed bodies have no corners. The side is 0 for the front, 1 for the back.
    """
    triangles, vertices, transform = geometry.triangles, geometry.vertices, geometry.transform
    a, b, c = triangles[triangle, 0], triangles[triangle, 1], triangles[triangle, 2]
    outcodes = vertices.outcodes
    is_whole = (outcodes[a] | outcodes[b] | outcodes[c]) == INSIDE
    if is_whole:
        side = _side_on_screen(vertices, a, b, c)
    else:
        side = _side_in_space(vertices.view_space, a, b, c, transform.is_perspective)
    if side < 0 or (side == 1 and geometry.is_closed[triangle]):
        return 0, 0
    corners, u, v, values, _ = polygon
    for k in range(3):
        vertex = triangles[triangle, k]
        for axis in range(3):
            corners[0, k, axis] = vertices.view_space[vertex, axis]
        for half in range(2):
            corners[half, k, 3], corners[half, k, 4] = np.float64(k == 1), np.float64(k == 2)
        u[k], v[k] = vertices.u[vertex], vertices.v[vertex]
        values[k, 0] = vertices.reversed_z[vertex]
    count = 3 if is_whole else clip(corners, transform.near, transform.is_perspective)
    colour = colours.values
    if colours.is_flat:
        a = b = c = triangle
    for k in range(count):
        if not is_whole:
            u[k], v[k], values[k, 0] = to_screen(
                corners[1, k, 0], corners[1, k, 1], corners[1, k, 2], transform.centre_u,
                transform.centre_v, transform.is_perspective)
        u[k] -= state.shift_u
        v[k] -= state.shift_v
        weight_b, weight_c = corners[1, k, 3], corners[1, k, 4]
        factor = values[k, 0] if state.is_perspective_correct else 1.0
        for channel in range(3):
            at_a = colour[a, side, channel]
            values[k, 1 + channel] = factor * (
                at_a + weight_b * (colour[b, side, channel] - at_a)
                + weight_c * (colour[c, side, channel] - at_a))
    return count, side


@late_inner_kernel
def _side_on_screen(vertices, a, b, c):
    """Return which side a triangle shows: 0 front (counterclockwise), 1 back, -1 its edge."""
    u, v = vertices.u, vertices.v
    area = (np.int64(u[b] - u[a]) * np.int64(v[c] - v[a])
            - np.int64(u[c] - u[a]) * np.int64(v[b] - v[a]))
    # v points down, which turns the sign.
    return 0 if area < 0 else 1 if area > 0 else -1


@late_kernel
def _side_in_space(view, a, b, c, is_perspective):
    """Return the same from the points in space: in perspective by the side that the eye is on."""
    px, py, pz = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1], view[b, 2] - view[a, 2]
    qx, qy, qz = view[c, 0] - view[a, 0], view[c, 1] - view[a, 1], view[c, 2] - view[a, 2]
    toward = px * qy - py * qx
    if is_perspective:
        toward = (view[a, 0] * (py * qz - pz * qy) + view[a, 1] * (pz * qx - px * qz)
                  + view[a, 2] * toward)
    return 0 if toward < 0.0 else 1 if toward > 0.0 else -1
