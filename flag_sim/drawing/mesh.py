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

"""Triangle meshes and their normals (eqs. 1.12, 1.13)."""
import dataclasses
import functools

from flag_sim.jit.kernels import late_kernel
from flag_sim.parameters import checks

import numpy as np

# Along a side of a grid: more than any memory holds.
MAX_NODES = 2 ** 24


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """
    A surface of triangles.

    vertices: (n, 3) float64 [m]; triangles: (m, 3) int32, counterclockwise seen from the front;
    normals: (n, 3) float64 at the vertices, out of the front, of any length.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray


@functools.lru_cache(maxsize=8)
def grid_triangles(rows: int, columns: int) -> np.ndarray:
    """
    Cut the cells of a grid of rows x columns nodes in two: (2 (rows - 1) (columns - 1), 3) int32.

    Cell (i, j) becomes (i, j), (i, j+1), (i+1, j) and (i+1, j+1), (i+1, j), (i, j+1); node (i, j)
    has the index i columns + j. Read-only. Raises ValueError for fewer than two rows or columns.
    """
    rows, columns = (checks.whole(name, count, 0, MAX_NODES)
                     for name, count in (('rows', rows), ('columns', columns)))
    checks.require(rows >= 2 and columns >= 2, 'a grid', 'of at least 2 x 2 nodes',
                   (rows, columns))
    node = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    here, right = node[:-1, :-1], node[:-1, 1:]
    below, across = node[1:, :-1], node[1:, 1:]
    cells = np.stack([here, right, below, across, below, right], axis=-1)
    triangles = cells.reshape(-1, 3)
    triangles.flags.writeable = False
    return triangles


def face_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the normal of each triangle, as long as twice its area: (m, 3) [m2] (eq. 1.12)."""
    normals = np.empty((len(triangles), 3))
    _cross_products(vertices, triangles, normals)
    return normals


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """
    Average at each vertex the normals of its triangles: (n, 3) [m2] (eq. 1.13).

    The average is weighted by area (the sum of the cross products), which makes the normal
    independent of how finely a flat part is cut. It is not brought to unit length.
    """
    normals = np.zeros((len(vertices), 3))
    _sum_at_vertices(face_normals(vertices, triangles), triangles, normals)
    return normals


@late_kernel
def _cross_products(vertices, triangles, normals):
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        px = vertices[b, 0] - vertices[a, 0]
        py = vertices[b, 1] - vertices[a, 1]
        pz = vertices[b, 2] - vertices[a, 2]
        qx = vertices[c, 0] - vertices[a, 0]
        qy = vertices[c, 1] - vertices[a, 1]
        qz = vertices[c, 2] - vertices[a, 2]
        normals[t, 0] = py * qz - pz * qy
        normals[t, 1] = pz * qx - px * qz
        normals[t, 2] = px * qy - py * qx


@late_kernel
def _sum_at_vertices(of_faces, triangles, of_vertices):
    for t in range(triangles.shape[0]):
        for corner in range(3):
            vertex = triangles[t, corner]
            for axis in range(3):
                of_vertices[vertex, axis] += of_faces[t, axis]
