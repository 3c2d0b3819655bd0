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

"""What stands before a point: the triangles of a scene, sorted into the tiles of an image."""
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

TILE = 4
"""Side of the squares in which triangles are looked for [pixel]."""


class Sight(NamedTuple):
    """
    Where vertices are in a frame.

    view_space: (n, 3), see geometry.Vertices, nan where that is not known; centre_u, centre_v:
    the principal point [pixel]; is_perspective: whether x and y are divided by the depth.
    """

    view_space: np.ndarray
    centre_u: float
    centre_v: float
    is_perspective: bool


class Bins(NamedTuple):
    """
    Which triangles may be seen in each tile of an image.

    bounds: (m, 4) float64, least and greatest u and v of each triangle [pixel]; planes: (m, 4, 3)
    float64, see set_planes; starts: (tiles + 1,) int64, where the triangles of a tile begin in
    `members`, (n,) int32; columns: of tiles.
    """

    bounds: np.ndarray
    planes: np.ndarray
    starts: np.ndarray
    members: np.ndarray
    columns: int


def binned(sight: Sight, corners: np.ndarray, camera: Camera) -> Bins:
    """Return the Bins of the triangles `corners` in an image."""
    columns, rows = -(-camera.width // TILE), -(-camera.height // TILE)
    bounds, starts = np.empty((len(corners), 4)), np.zeros(columns * rows + 1, np.int64)
    planes = np.empty((len(corners), 4, 3))
    _set_bounds(sight, corners, camera.near, bounds)
    set_planes(sight, corners, planes)
    _count(bounds, columns, rows, starts)
    np.cumsum(starts, out=starts)
    members = np.empty(starts[-1], np.int32)
    _sort_in(bounds, columns, rows, starts[:-1].copy(), members)
    return Bins(bounds, planes, starts, members, columns)


@late_kernel
def _set_bounds(sight, corners, near, bounds):
    """Write the bounds of triangles; of those that reach behind the near plane, everything."""
    points = sight.view_space
    for t in range(corners.shape[0]):
        least_u, most_u, least_v, most_v = np.inf, -np.inf, np.inf, -np.inf
        nearest, farthest = np.inf, -np.inf
        is_known = True
        for k in range(3):
            x, y, z = points[corners[t, k], 0], points[corners[t, k], 1], points[corners[t, k], 2]
            is_known = is_known and x == x and y == y and z == z
            scale = 1.0 / z if sight.is_perspective and z > 0.0 else 1.0
            u, v = sight.centre_u + x * scale, sight.centre_v + y * scale
            least_u, most_u = min(least_u, u), max(most_u, u)
            least_v, most_v = min(least_v, v), max(most_v, v)
            nearest, farthest = min(nearest, z), max(farthest, z)
        if not is_known or farthest <= near:
            least_u, most_u, least_v, most_v = np.inf, -np.inf, np.inf, -np.inf
        elif nearest <= near and sight.is_perspective:
            least_u, most_u, least_v, most_v = -np.inf, np.inf, -np.inf, np.inf
        bounds[t, 0], bounds[t, 1] = least_u, most_u
        bounds[t, 2], bounds[t, 3] = least_v, most_v


@late_kernel
def set_planes(sight, corners, planes):
    """
    Write what tells where a line of sight through (x, y) [pixel from the centre] meets triangles.

    Each of the four is linear: p[0] x + p[1] y + p[2]. The first three are determinants of the
    line's direction and two vertices, of one sign where it passes within all edges; in their
    proportions it meets the plane between the three vertices. The fourth is their sum, each times
    its vertex's depth: over their sum it is the depth there.
    """
    points = sight.view_space
    for t in range(corners.shape[0]):
        for k in range(3):
            b, c = corners[t, (k + 1) % 3], corners[t, (k + 2) % 3]
            bx, by, bz = points[b, 0], points[b, 1], points[b, 2]
            cx, cy, cz = points[c, 0], points[c, 1], points[c, 2]
            if not sight.is_perspective:  # all lines are parallel to the axis
                bz = cz = 1.0
            planes[t, k, 0] = by * cz - bz * cy
            planes[t, k, 1] = bz * cx - bx * cz
            planes[t, k, 2] = bx * cy - by * cx
        for axis in range(3):
            planes[t, 3, axis] = (planes[t, 0, axis] * points[corners[t, 0], 2]
                                  + planes[t, 1, axis] * points[corners[t, 1], 2]
                                  + planes[t, 2, axis] * points[corners[t, 2], 2])


@late_inner_kernel
def _tiles(least, most, count):
    """Return the first tile and the end of those between two coordinates [pixel]."""
    limit = 1.0 * count * TILE
    if not least <= most or most < -0.5 or least > limit:
        return 0, 0
    first = int(max(least + 0.5, 0.0)) // TILE
    return first, min(int(min(most + 0.5, limit)) // TILE + 1, count)


@late_kernel
def _count(bounds, columns, rows, starts):
    """Count the triangles of each tile, one place behind it."""
    for t in range(bounds.shape[0]):
        left, right = _tiles(bounds[t, 0], bounds[t, 1], columns)
        top, bottom = _tiles(bounds[t, 2], bounds[t, 3], rows)
        for row in range(top, bottom):
            for column in range(left, right):
                starts[row * columns + column + 1] += 1


@late_kernel
def _sort_in(bounds, columns, rows, places, members):
    """Write each triangle where its tiles' next one stands."""
    for t in range(bounds.shape[0]):
        left, right = _tiles(bounds[t, 0], bounds[t, 1], columns)
        top, bottom = _tiles(bounds[t, 2], bounds[t, 3], rows)
        for row in range(top, bottom):
            for column in range(left, right):
                tile = row * columns + column
                members[places[tile]] = t
                places[tile] += 1


@late_inner_kernel
def is_covered(sight, bins, own, point, near):
    """
    Return whether another triangle than `own` stands before a point (u, v, depth).

    Hardly any of a tile's triangles has the point within its edges, whatever their bounds are:
    asked first, and in one condition, that is answered without a branch that is often mistaken.
    """
    u, v, depth = point
    x, y = u - sight.centre_u, v - sight.centre_v
    tile = int(v + 0.5) // TILE * bins.columns + int(u + 0.5) // TILE
    planes, bounds = bins.planes, bins.bounds
    for k in range(np.uint64(bins.starts[tile]), np.uint64(bins.starts[tile + 1])):
        t = np.uint64(bins.members[k])
        of_a = planes[t, 0, 0] * x + planes[t, 0, 1] * y + planes[t, 0, 2]
        of_b = planes[t, 1, 0] * x + planes[t, 1, 1] * y + planes[t, 1, 2]
        of_c = planes[t, 2, 0] * x + planes[t, 2, 1] * y + planes[t, 2, 2]
        if (t != np.uint64(own)) & (((of_a >= 0.0) & (of_b >= 0.0) & (of_c >= 0.0))
                                    | ((of_a <= 0.0) & (of_b <= 0.0) & (of_c <= 0.0))):
            z = (planes[t, 3, 0] * x + planes[t, 3, 1] * y + planes[t, 3, 2]) / (
                of_a + of_b + of_c)
            if (near < z < depth and bounds[t, 0] <= u <= bounds[t, 1]
                    and bounds[t, 2] <= v <= bounds[t, 3]):
                return True
    return False
