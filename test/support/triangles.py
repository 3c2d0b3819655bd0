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

"""Triangles drawn by the rasterizer alone, and which pixels they cover by exact arithmetic."""
from flag_sim.drawing.clipping import GUARD_BAND
from flag_sim.drawing.culling import CHUNK, cull, DrawOrder, triangles_in_rows, Viewport
from flag_sim.drawing.geometry import Geometry, SUBPIXELS, Vertices, ViewTransform
from flag_sim.drawing.polygon import new_polygon
from flag_sim.drawing.rasterizer import Colours, rasterize, RasterizerState, Target
from flag_sim.drawing.triangle_setup import new_batch

import numpy as np

WIDTH, HEIGHT = 61, 43
STRIDE = 64
NO_FACES = np.empty(0, np.uint32)
BATCH, POLYGON = new_batch(), new_polygon()


def draw(corners, reversed_z=1.0, colours=255.0, is_perspective_correct=False, bands=1,
         is_painter=False, shift=(0.0, 0.0), size=None):
    """
    Draw triangles of corners (m, 3, 2) [pixel]; return reversed Z and packed colours.

    Both are (HEIGHT, WIDTH). size: how all are drawn: LARGE, MEDIUM or SMALL; None leaves that to
    their widths.
    """
    snapped = np.asarray(np.round(np.asarray(corners) * SUBPIXELS), dtype=np.int32).reshape(-1, 2)
    points, count = len(snapped), len(snapped) // 3
    near = np.array(np.broadcast_to(reversed_z, (count, 3)), dtype=float).ravel()
    values = np.empty((points, 2, 3))
    values[:] = np.broadcast_to(colours, (count, 3, 3)).reshape(-1, 1, 3)
    vertices = Vertices(np.empty((points, 3)), *np.ascontiguousarray(snapped.T), near,
                        np.zeros(points, np.int32))
    transform = ViewTransform(np.eye(4), 0.0, 0.0, 0.1, True)
    geometry, order = geometry_of(vertices, transform, SUBPIXELS)
    if size is not None:
        geometry.sizes[:] = size
    indices = np.empty(count + 1, np.int32)
    depth, colour = np.zeros((HEIGHT, STRIDE), np.float32), np.zeros((HEIGHT, STRIDE), np.uint32)
    state = RasterizerState(*np.int32(np.multiply(shift, SUBPIXELS)),
                            np.float32(-np.inf if is_painter else np.inf), False,
                            is_perspective_correct)
    for top in range(0, HEIGHT, -(-HEIGHT // bands)):
        end = min(top + -(-HEIGHT // bands), HEIGHT)
        found, _, _ = triangles_in_rows(order, top, end, indices)
        target = Target(colour[top:end].reshape(-1), depth[top:end].reshape(-1), NO_FACES,
                        top, end, WIDTH, STRIDE)
        rasterize(geometry, Colours(values, False), indices[:found], state, target, BATCH, POLYGON,
                  None)
    return depth[:, :WIDTH], colour[:, :WIDTH]


def geometry_of(vertices, transform, margin):
    """Return the Geometry of triangles of three vertices each, and their DrawOrder."""
    points = len(vertices.u)
    count = points // 3
    geometry = Geometry(np.arange(points, dtype=np.int32).reshape(-1, 3),
                        np.zeros(count, np.uint8), np.empty(count, np.uint8), vertices, transform)
    chunks = -(-count // CHUNK)
    order = DrawOrder(np.arange(count, dtype=np.int32), np.empty((2, count), np.int16),
                      np.empty((4, chunks), np.int32))
    cull(geometry, order, Viewport(WIDTH, HEIGHT, margin), 0, chunks)
    return geometry, order


def covered(snapped):
    """Return by exact edge functions which pixels a triangle (3, 2) [subpixels] covers."""
    a, b, c = (np.asarray(corner, dtype=np.int64) for corner in snapped)
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area == 0:
        return np.zeros((HEIGHT, WIDTH), bool)
    if area < 0:
        b, c = c, b
    x, y = SUBPIXELS * np.arange(WIDTH), SUBPIXELS * np.arange(HEIGHT)[:, None]
    inside = np.ones((HEIGHT, WIDTH), bool)
    for begin, end in ((a, b), (b, c), (c, a)):
        dx, dy = end - begin
        edge = dx * (y - begin[1]) - dy * (x - begin[0])
        is_top_or_left = dy < 0 or (dy == 0 and dx > 0)
        inside &= edge >= 0 if is_top_or_left else edge > 0
    return inside


def some_triangles(kind, count, rng):
    """Make triangles of a kind: (count, 3, 2) [subpixels]."""
    spread = np.array([WIDTH, HEIGHT]) * SUBPIXELS
    triangles = rng.integers(-spread // 4, spread * 5 // 4, (count, 3, 2))
    if kind == 'sliver':
        # The third corner lies within two subpixels of the line through the others.
        along = rng.random((count, 1))
        triangles[:, 2] = triangles[:, 0] + np.round(
            along * (triangles[:, 1] - triangles[:, 0])) + rng.integers(-2, 3, (count, 2))
    elif kind == 'thin':
        # About a centre, no wider than what is drawn in batches.
        centre = triangles[:, 0] // SUBPIXELS * SUBPIXELS
        way = rng.integers((-7 * SUBPIXELS, -999 * SUBPIXELS), (7 * SUBPIXELS, 1000 * SUBPIXELS),
                           (count, 2))
        triangles = np.stack([centre - way, centre + way + rng.integers(-1, 2, (count, 2)),
                              centre + rng.integers(-1, 2, (count, 2))], axis=1)
    elif kind == 'small':
        triangles = triangles[:, :1] + rng.integers(-400, 401, (count, 3, 2))
    elif kind == 'narrow':
        # Up to as high as vertices can be apart: what is beyond is clipped.
        triangles[:, :, 0] = triangles[:, :1, 0] + rng.integers(0, 64 * SUBPIXELS, (count, 3))
        reach = int(GUARD_BAND) * SUBPIXELS
        triangles[:, :, 1] = np.clip(triangles[:, :, 1] * 8 ** rng.integers(0, 5, (count, 1)),
                                     -reach, reach)
    elif kind == 'centres':
        triangles = triangles // SUBPIXELS * SUBPIXELS
    elif kind == 'halves':
        triangles = triangles // (SUBPIXELS // 2) * (SUBPIXELS // 2)
    elif kind == 'axes':
        triangles[:, 1, 1] = triangles[:, 0, 1]
        triangles[:, 2, 0] = triangles[:, 0, 0]
    elif kind == 'huge':
        reach = int(GUARD_BAND) * SUBPIXELS
        triangles = rng.integers(-reach, reach + 1, (count, 3, 2))
        # A corner in the picture, or else most of them miss it.
        triangles[:, 0] = rng.integers(0, spread, (count, 2))
    elif kind == 'huge sliver':
        # Opposite ends of the band, the line through them crossing the picture near a centre.
        reach = int(GUARD_BAND) * SUBPIXELS
        triangles[:, 0] = rng.integers(-reach, reach + 1, (count, 2))
        centre = triangles[:, 2] // SUBPIXELS * SUBPIXELS
        triangles[:, 1] = np.clip(2 * centre - triangles[:, 0], -reach, reach)
        triangles[:, 2] = centre + rng.integers(-1, 2, (count, 2))
    return triangles
