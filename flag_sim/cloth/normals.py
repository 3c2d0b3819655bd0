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

"""Normals of the cloth at its nodes, averaged over the faces around them (eq. 1.13)."""
import math

from flag_sim.jit.kernels import kernel
from flag_sim.parameters import checks
import numpy as np


def node_normals(positions: np.ndarray) -> np.ndarray:
    """
    Return unit normals (rows, columns, 3) for nodes at positions (rows, columns, 3) [m].

    The area vectors of the faces around a node are summed, so that each counts by its area. A
    cloth flat in x-z, as it is at rest, has normals +y; so has a node whose faces have no area.
    Where a position is not finite the normals around it are not. Raises ValueError for other
    shapes and types.
    """
    positions = checks.grid('positions', positions)
    normals = np.zeros_like(positions)
    _sum_area_vectors(positions, normals)
    _normalise(normals)
    return normals


@kernel
def _sum_area_vectors(p, sums):
    """Add to each node twice the area vectors of the faces that it belongs to."""
    for r in range(p.shape[0] - 1):
        for c in range(p.shape[1] - 1):
            # Sides of the upper face (r, c), (r, c+1), (r+1, c), then of the lower one opposite.
            ex, ey, ez = (p[r, c + 1, 0] - p[r, c, 0], p[r, c + 1, 1] - p[r, c, 1],
                          p[r, c + 1, 2] - p[r, c, 2])
            sx, sy, sz = (p[r + 1, c, 0] - p[r, c, 0], p[r + 1, c, 1] - p[r, c, 1],
                          p[r + 1, c, 2] - p[r, c, 2])
            upper = (ey * sz - ez * sy, ez * sx - ex * sz, ex * sy - ey * sx)
            ex, ey, ez = (p[r + 1, c, 0] - p[r + 1, c + 1, 0], p[r + 1, c, 1] - p[r + 1, c + 1, 1],
                          p[r + 1, c, 2] - p[r + 1, c + 1, 2])
            sx, sy, sz = (p[r, c + 1, 0] - p[r + 1, c + 1, 0], p[r, c + 1, 1] - p[r + 1, c + 1, 1],
                          p[r, c + 1, 2] - p[r + 1, c + 1, 2])
            lower = (ey * sz - ez * sy, ez * sx - ex * sz, ex * sy - ey * sx)
            for axis in range(3):
                both = upper[axis] + lower[axis]
                sums[r, c, axis] += upper[axis]
                sums[r, c + 1, axis] += both
                sums[r + 1, c, axis] += both
                sums[r + 1, c + 1, axis] += lower[axis]


@kernel
def _normalise(n):
    """Scale each vector to unit length; +y where there is none."""
    for r in range(n.shape[0]):
        for c in range(n.shape[1]):
            length = math.sqrt(n[r, c, 0]**2 + n[r, c, 1]**2 + n[r, c, 2]**2)
            if length > 0.0:
                for axis in range(3):
                    n[r, c, axis] /= length
            else:
                n[r, c, 1] = 1.0
