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

"""All that a frame shows, joined in one set of arrays."""
from flag_sim.drawing import ranges
from flag_sim.drawing.culling import CHUNK
from flag_sim.drawing.mesh import grid_triangles, vertex_normals
from flag_sim.drawing.scene import platform_mesh, pole_mesh

import numpy as np

# Points that are taken to the screen in one go: so few that they stay in a processor's cache.
PIECE = 8192


class Assembly:
    """
    The meshes of flag, pole and platform, for one grid, one scene and one fineness.

    points, normals: (n, 3); triangles: (m, 3) int32, from number `closed` on of closed bodies,
    whose backs nobody sees; parts: the name of each thing with its slices of points and of
    triangles; pieces: the same slices of points, cut for threads to share. The flag stands first;
    its points and normals are written by every frame, and so are view, u, v, reversed_z,
    outcodes: see projection; kinds, spans, boxes: see culling.
    """

    def __init__(self, rows, columns, scene, segments):
        """Join the meshes; raise ValueError for a grid that has no triangles."""
        self.kind = (rows, columns), scene, segments
        self._shape = rows, columns, 3
        flag = grid_triangles(rows, columns)
        self.closed = len(flag)
        points, triangles = [np.zeros((rows * columns, 3))], [flag]
        normals = [points[0]]
        self.parts = {'flag': (slice(0, rows * columns), slice(0, len(flag)))}
        for name, is_visible, make in (('pole', scene.pole_visible, pole_mesh),
                                       ('platform', scene.platform_visible, platform_mesh)):
            if is_visible:
                mesh = make(scene, segments)
                first, number = sum(map(len, points)), sum(map(len, triangles))
                self.parts[name] = (slice(first, first + len(mesh.vertices)),
                                    slice(number, number + len(mesh.triangles)))
                points.append(mesh.vertices)
                normals.append(mesh.normals)
                triangles.append(mesh.triangles + np.int32(first))
        self.points, self.normals = np.concatenate(points), np.concatenate(normals)
        self.triangles = np.concatenate(triangles)
        self.order = np.arange(len(self.triangles), dtype=np.int32)
        self.pieces = [
            (name, slice(first, min(first + PIECE, points.stop)))
            for name, (points, _) in self.parts.items()
            for first in range(points.start, points.stop, PIECE)]

        count, chunks = len(self.triangles), -(-len(self.triangles) // CHUNK)
        self.view = np.empty(self.points.shape)
        self.u, self.v, self.outcodes = np.empty((3, len(self.points)), np.int32)
        self.reversed_z = np.empty(len(self.points))
        self.kinds = np.empty(count, np.uint8)
        self.spans, self.boxes = np.empty((2, count), np.int16), np.empty((4, chunks), np.int32)

    def set_flag(self, vertices, normals):
        """
        Put the flag where its vertices (rows, columns, 3) [m] are.

        normals: the same shape, or None to average them from the triangles (1.13). Raises
        ValueError for another shape.
        """
        self.give_flag(vertices, normals)
        self.take_flag(self.parts['flag'][0])

    def give_flag(self, vertices, normals):
        """Begin to do so: keep both until take_flag is done with them, piece by piece."""
        points, numbers = self.parts['flag']
        self._given = vertices.reshape(-1, 3), None
        if normals is None:
            self.take_flag(points)
            normals = vertex_normals(self.points[points], self.triangles[numbers])
        else:
            normals = ranges.points('flag_normals', normals, self._shape)
        self._given = vertices.reshape(-1, 3), normals.reshape(-1, 3)

    def take_flag(self, piece):
        """Take the points of a slice of the flag, which stands first."""
        vertices, normals = self._given
        self.points[piece] = vertices[piece]
        if normals is not None:
            self.normals[piece] = normals[piece]
