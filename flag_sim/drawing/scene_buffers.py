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

"""Scene buffers: the objects of a scene joined in arrays that are kept from frame to frame."""
from typing import NamedTuple

from flag_sim.drawing.culling import new_order
from flag_sim.drawing.geometry import Geometry, new_vertices, part_of, Vertices
from flag_sim.drawing.mesh import vertex_normals
from flag_sim.parameters import checks

import numpy as np

# Vertices that are taken to the screen in one go: so few that they stay in a processor's cache.
VERTEX_CHUNK = 8192


class VertexChunk(NamedTuple):
    """
    Vertices of one object that are done in one go.

    index: of the object; vertices: their slice of the scene's; positions, normals, projected:
    their parts of the scene buffers.
    """

    index: int
    vertices: slice
    positions: np.ndarray
    normals: np.ndarray
    projected: Vertices


class SceneBuffers:
    """
    The objects of a scene, joined, and what is computed from them for a frame.

    positions, normals: (n, 3) of vertices; triangles: (m, 3) int32; is_closed: (m,) uint8; slices:
    for each object those of its vertices and of its triangles; chunks: for each object a list of
    VertexChunk, so that threads can share them; projected: Vertices; sizes, order: see culling.
    """

    def __init__(self, objects):
        """Join the objects; raise ValueError if there is nothing to draw."""
        self._triangles = [one.triangles for one in objects]
        self._sizes = [(len(one.vertices), one.is_closed) for one in objects]
        first_vertices = np.cumsum([0] + [len(one.vertices) for one in objects])
        first_triangles = np.cumsum([0] + [len(one.triangles) for one in objects])
        count, points = int(first_triangles[-1]), int(first_vertices[-1])
        checks.require(count > 0, 'objects', 'at least one with triangles', objects)
        self.slices = [(slice(*first_vertices[k:k + 2]), slice(*first_triangles[k:k + 2]))
                       for k in range(len(objects))]
        self.triangles = np.concatenate(
            [one.triangles + start for one, start in zip(objects, first_vertices)]
        ).astype(np.int32)
        self.is_closed = np.repeat(np.array([one.is_closed for one in objects], np.uint8),
                                   np.diff(first_triangles))
        self.positions, self.normals = np.zeros((points, 3)), np.zeros((points, 3))
        self._objects, self._view, self._loaded = [], None, [None] * len(objects)
        self._sources, self._kept = [], {}
        self.projected = new_vertices(points)
        self.chunks = [[self._chunk(k, slice(first, min(first + VERTEX_CHUNK, vertices.stop)))
                        for first in range(vertices.start, vertices.stop, VERTEX_CHUNK)]
                       for k, (vertices, _) in enumerate(self.slices)]
        self.sizes = np.empty(count, np.uint8)
        self.order = new_order(np.arange(count, dtype=np.int32))

    def _chunk(self, index, vertices):
        return VertexChunk(index, vertices, self.positions[vertices], self.normals[vertices],
                           part_of(self.projected, vertices))

    def fits(self, objects) -> bool:
        """Whether objects have the triangles that were joined."""
        return len(objects) == len(self._triangles) and all(
            one.triangles is triangles and not triangles.flags.writeable
            and (len(one.vertices), one.is_closed) == size
            for one, triangles, size in zip(objects, self._triangles, self._sizes))

    def kept(self, name: str, parts: list, make):
        """
        Return what make() makes from arrays of the objects; kept while these are the same ones.

        parts: (n, k) arrays, or None; those that can be written to are taken to have changed.
        """
        known = self._kept.get(name)
        if known is None or any(one is not last or (one is not None and one.flags.writeable)
                                for one, last in zip(parts, known[0])):
            self._kept[name] = known = parts, make()
        return known[1]

    def geometry(self, transform) -> Geometry:
        """Return the scene's triangles for the kernels, seen through a ViewTransform."""
        return Geometry(self.triangles, self.is_closed, self.sizes, self.projected, transform)

    def begin_frame(self, objects, view=None) -> list:
        """
        Return the chunks of vertices that have to be loaded, projected and lit again.

        view: whatever else than the object tells where its vertices are on the screen and how
        they are lit. Left out are the chunks of objects that are as they were in the last frame
        for which `end_frame` was called. Missing normals are averaged here (eq. 1.13); `load`
        copies the others.
        """
        last, last_view, loaded = self._objects, self._view, self._loaded
        self._objects, self._view, self._loaded = [], None, [None] * len(objects)
        self._sources, chunks = [], []
        for k, (one, (own, _)) in enumerate(zip(objects, self.slices)):
            vertices, normals = one.vertices, one.normals
            is_loaded = loaded[k] is not None and loaded[k] == (id(vertices), id(normals))
            if normals is None:
                self.positions[own] = vertices
                self.normals[own] = vertex_normals(self.positions[own], one.triangles)
            self._sources.append((None, None, own.start) if normals is None or is_loaded else
                                 (vertices, normals, own.start))
            if not (is_loaded and view == last_view and one.surface == last[k].surface):
                chunks += self.chunks[k]
        return chunks

    def load(self, chunk):
        """Copy the positions and normals of a chunk from its object."""
        vertices, normals, start = self._sources[chunk.index]
        own = slice(chunk.vertices.start - start, chunk.vertices.stop - start)
        if vertices is not None:
            chunk.positions[:] = vertices[own]
        if normals is not None:
            chunk.normals[:] = normals[own]

    def end_frame(self, objects, view):
        """Note what was loaded, projected and lit: all chunks of `begin_frame` are done."""
        self._loaded = [
            None if one.normals is None or one.vertices.flags.writeable
            or one.normals.flags.writeable else (id(one.vertices), id(one.normals))
            for one in objects]
        # The objects too, so that no other array can get an id of theirs.
        self._objects, self._view = objects, view
