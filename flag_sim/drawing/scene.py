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
A scene is a list of objects. Which ones, and how many, is the caller's matter.

Nothing of what draws them knows a flag: `flag_scene` makes the entries of the source's scene.
"""
import dataclasses
import functools
from typing import NamedTuple

from flag_sim.drawing import ranges
from flag_sim.drawing.culling import CHUNK, Order
from flag_sim.drawing.geometry import Vertices
from flag_sim.drawing.mesh import grid_triangles, Mesh, vertex_normals
from flag_sim.drawing.shading import Surface
from flag_sim.drawing.shapes import platform_mesh, pole_mesh
from flag_sim.parameters import checks

import numpy as np

# What labels of pixels mean; 0 is nothing, and further objects count from 4.
FLAG, POLE, PLATFORM = 1, 2, 3
# Points that are taken to the screen in one go: so few that they stay in a processor's cache.
PIECE = 8192


@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """
    One thing to draw.

    vertices: (n, 3) [m], of which those that are not finite take their triangles out of the
    picture; triangles: (m, 3) int32, counterclockwise seen from the front; normals: (n, 3) at the
    vertices, out of the front, of any length, or None to average them from the triangles (1.13);
    surface: how it looks; label: a whole number that tells its pixels from others'; is_closed:
    whether it is a closed body, whose backs nobody sees. Arrays that are read-only are taken to
    be the same in the next frame; others are read again. Raises ValueError for other shapes and
    types, and for triangles of vertices that do not exist.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray = None
    surface: Surface = Surface()
    label: int = 0
    is_closed: bool = False

    def __post_init__(self):
        """Refuse what cannot be drawn."""
        vertices = ranges.points('vertices', self.vertices, (None, 3))
        object.__setattr__(self, 'vertices', vertices)
        if self.normals is not None:
            normals = ranges.points('normals', self.normals, vertices.shape)
            object.__setattr__(self, 'normals', normals)
        triangles = ranges.points('triangles', self.triangles, (None, 3))
        if triangles.dtype.kind not in 'iu':
            checks.require(False, 'triangles', 'whole numbers', triangles.dtype.name)
        if triangles.flags.writeable and triangles.size:
            checks.require(0 <= triangles.min() and triangles.max() < len(vertices), 'triangles',
                           f'numbers of the {len(vertices)} vertices',
                           (int(triangles.min()), int(triangles.max())))
        object.__setattr__(self, 'triangles', triangles)
        checks.instance('surface', self.surface, Surface)
        object.__setattr__(self, 'label', checks.whole('label', self.label, 0, 255))
        object.__setattr__(self, 'is_closed', checks.boolean('is_closed', self.is_closed))


def sheet(vertices, normals=None, surface=Surface(), label=FLAG) -> Object:
    """
    Return a cloth as an object, both sides of which are seen.

    vertices: (rows, columns, 3) [m]; normals: the same shape, of any length, on the side of (row
    direction) x (column direction), or None to average them (1.13). Raises ValueError for other
    shapes and types, and for fewer than two rows or columns.
    """
    vertices = ranges.points('flag_vertices', vertices, (None, None, 3))
    triangles = grid_triangles(*vertices.shape[:2])
    if normals is not None:
        normals = ranges.points('flag_normals', normals, vertices.shape).reshape(-1, 3)
    return Object(vertices.reshape(-1, 3), triangles, normals, surface, label)


def body(mesh: Mesh, surface=Surface(), label=0) -> Object:
    """Return a closed mesh as an object."""
    return Object(mesh.vertices, mesh.triangles, mesh.normals, surface, label, True)


def flag_scene(flag_vertices, flag_normals, camera, materials, measures) -> list:
    """
    Return the objects of the source's scene (1.2): the flag and, if seen, pole and platform.

    flag_vertices, flag_normals: see sheet; camera: what tells how finely round things are cut;
    materials: a Materials; measures: a Scene.
    """
    flag = sheet(flag_vertices, flag_normals, materials.flag, FLAG)
    return [flag, *_what_stands(camera, materials, measures)]


@functools.lru_cache(maxsize=8)
def _what_stands(camera, materials, measures):
    objects, segments = [], measures.segments(camera)
    if measures.pole_visible:
        objects.append(body(pole_mesh(measures, segments), materials.pole, POLE))
    if measures.platform_visible:
        objects.append(body(platform_mesh(measures, segments), materials.platform, PLATFORM))
    return objects


class Piece(NamedTuple):
    """Points that are done in one go: their object's number, their slice, and their arrays."""

    number: int
    own: slice
    points: np.ndarray
    normals: np.ndarray
    vertices: Vertices


class SceneBuffers:
    """
    The objects of a scene, joined in one set of arrays, and what is made of them for a frame.

    points, normals: (n, 3); triangles: (m, 3) int32; is_closed: (m,) uint8; parts: for each
    object its slices of points and of triangles; pieces: for each object a list, cut for threads
    to share. vertices, sizes, order: see geometry and culling.
    """

    def __init__(self, objects):
        """Join the objects; raise ValueError if there is nothing to draw."""
        self._triangles = [one.triangles for one in objects]
        self._sizes = [(len(one.vertices), one.is_closed) for one in objects]
        starts = np.cumsum([0] + [len(one.vertices) for one in objects])
        numbers = np.cumsum([0] + [len(one.triangles) for one in objects])
        count, points = int(numbers[-1]), int(starts[-1])
        checks.require(count > 0, 'objects', 'at least one with triangles', objects)
        self.parts = [(slice(*starts[k:k + 2]), slice(*numbers[k:k + 2]))
                      for k in range(len(objects))]
        self.triangles = np.concatenate(
            [one.triangles + start for one, start in zip(objects, starts)]).astype(np.int32)
        self.is_closed = np.repeat(np.array([one.is_closed for one in objects], np.uint8),
                                   np.diff(numbers))
        self.points, self.normals = np.zeros((points, 3)), np.zeros((points, 3))
        self._objects, self._look, self._taken = [], None, [None] * len(objects)
        self.vertices = Vertices(np.empty((points, 3)), *np.empty((2, points), np.int32),
                                 np.empty(points), np.empty(points, np.int32))
        self.pieces = [[self._piece(k, slice(first, min(first + PIECE, part.stop)))
                        for first in range(part.start, part.stop, PIECE)]
                       for k, (part, _) in enumerate(self.parts)]
        self.sizes = np.empty(count, np.uint8)
        chunks = -(-count // CHUNK)
        self.order = Order(np.arange(count, dtype=np.int32), np.empty((2, count), np.int16),
                           np.empty((4, chunks), np.int32))

    def _piece(self, number, own):
        return Piece(number, own, self.points[own], self.normals[own],
                     Vertices(*(array[own] for array in self.vertices)))

    def fits(self, objects) -> bool:
        """Whether objects have the triangles that were joined."""
        return len(objects) == len(self._triangles) and all(
            one.triangles is triangles and not triangles.flags.writeable
            and (len(one.vertices), one.is_closed) == size
            for one, triangles, size in zip(objects, self._triangles, self._sizes))

    def give(self, objects, look=None):
        """
        Begin a frame: average what normals are missing; `take` copies the rest.

        look: whatever else than an object tells where its points are on the screen and how they
        are lit. Returns the pieces to do: not those of objects that are as they were in the last
        frame, whose end `keep` told.
        """
        last, last_look, taken = self._objects, self._look, self._taken
        self._objects, self._look, self._taken = [], None, [None] * len(objects)
        self._given, pieces = [], []
        for k, (one, (points, _)) in enumerate(zip(objects, self.parts)):
            vertices, normals = one.vertices, one.normals
            has_stayed = taken[k] is not None and taken[k] == (id(vertices), id(normals))
            if normals is None:
                self.points[points] = vertices
                self.normals[points] = vertex_normals(self.points[points], one.triangles)
            self._given.append((None, None, points.start) if normals is None or has_stayed else
                               (vertices, normals, points.start))
            if not (has_stayed and look == last_look and one.surface == last[k].surface):
                pieces += self.pieces[k]
        return pieces

    def keep(self, objects, look):
        """End what `give` began: all pieces are done."""
        self._taken = [
            None if one.normals is None or one.vertices.flags.writeable
            or one.normals.flags.writeable else (id(one.vertices), id(one.normals))
            for one in objects]
        # Of the objects, too, so that no other array gets an id of these.
        self._objects, self._look = objects, look

    def take(self, piece):
        """Take the points of a Piece from the object."""
        vertices, normals, start = self._given[piece.number]
        own = slice(piece.own.start - start, piece.own.stop - start)
        if vertices is not None:
            piece.points[:] = vertices[own]
        if normals is not None:
            piece.normals[:] = normals[own]
