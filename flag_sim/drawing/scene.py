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
The scene: a list of objects. Which ones, and how many, is up to the caller.

Nothing that draws them knows of a flag: `flag_scene` makes the entries of the source's scene.
"""
import dataclasses
import functools
import weakref

from flag_sim.drawing import ranges
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.dimensions import Dimensions
from flag_sim.drawing.mesh import grid_triangles, Mesh
from flag_sim.drawing.shading import Surface
from flag_sim.drawing.shapes import (
    ground_mesh, mesh_of_box, placed, platform_mesh, pole_mesh)
from flag_sim.drawing.style import Materials
from flag_sim.drawing.texture import Texture
from flag_sim.parameters import checks

import numpy as np

# What labels of pixels mean; 0 is nothing, and boxes count from BOXES on.
FLAG, POLE, PLATFORM, GROUND, BOXES = 1, 2, 3, 4, 5


@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """
    One thing to draw.

    vertices: (n, 3) [m]; those that are not finite take their triangles out of the picture;
    triangles: (m, 3) of whole numbers, indices of vertices, counterclockwise seen from the front;
    normals: (n, 3) at the vertices, out of the front, of any length, or None to average them from
    the triangles (eq. 1.13); surface: how it looks; label: a whole number from 0 to 255 that tells
    its pixels from others'; is_closed: whether it is a closed body, whose back faces are never
    seen; texture_coordinates: (n, 2) at the vertices, or None; before: (n, 3) [m], where the
    vertices were in the frame before, for the flow, or None where that is not known; texture: a
    picture that takes the place of the surface's colour, for which there must be
    texture_coordinates, or None; casts_shadow: whether the sun does not shine through it.
    Arrays that are read-only are taken to be the same in the next frame; others are read again.
    Raises ValueError for other shapes and types, and for triangles of vertices that do not exist.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
    surface: Surface = Surface()
    label: int = 0
    is_closed: bool = False
    texture_coordinates: np.ndarray | None = None
    before: np.ndarray | None = None
    texture: Texture | None = None
    casts_shadow: bool = True

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
        if triangles.size:
            least, most = _extremes(triangles)
            checks.require(0 <= least and most < len(vertices), 'triangles',
                           f'indices of the {len(vertices)} vertices', (least, most))
        object.__setattr__(self, 'triangles', triangles)
        checks.instance('surface', self.surface, Surface)
        object.__setattr__(self, 'label', checks.whole('label', self.label, 0, 255))
        object.__setattr__(self, 'is_closed', checks.boolean('is_closed', self.is_closed))
        for name, shape in (('texture_coordinates', (len(vertices), 2)),
                            ('before', vertices.shape)):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, ranges.points(name, getattr(self, name), shape))
        if self.texture_coordinates is not None and self.texture_coordinates.flags.writeable:
            ranges.single('texture_coordinates', self.texture_coordinates)
        casts_shadow = checks.boolean('casts_shadow', self.casts_shadow)
        object.__setattr__(self, 'casts_shadow', casts_shadow)
        if self.texture is not None:
            checks.instance('texture', self.texture, Texture)
            checks.require(self.texture_coordinates is not None, 'texture_coordinates',
                           'given where there is a texture', None)


@dataclasses.dataclass(frozen=True, eq=False)
class LastFrame:
    """
    What the frame before was drawn from, for the flow to this one.

    flag_vertices: (rows, columns, 3) [m]; camera; dimensions: of what stands there. Raises
    ValueError for other shapes, and for what is not of its class.
    """

    flag_vertices: np.ndarray
    camera: Camera = Camera()
    dimensions: Dimensions = Dimensions()

    def __post_init__(self):
        """Refuse what was no frame."""
        ranges.points('flag_vertices', self.flag_vertices, (None, None, 3))
        checks.instance('camera', self.camera, Camera)
        checks.instance('dimensions', self.dimensions, Dimensions)


# Of arrays of triangles that are read-only: a weak reference and their extremes, by id.
_known_extremes = {}


def _extremes(triangles):
    """Return the least and the greatest index; of a read-only array, found once."""
    key = id(triangles)
    known = _known_extremes.get(key)
    if known is not None and known[0]() is triangles and not triangles.flags.writeable:
        return known[1]
    extremes = int(triangles.min()), int(triangles.max())
    if not triangles.flags.writeable:
        _known_extremes[key] = (
            weakref.ref(triangles, lambda _: _known_extremes.pop(key, None)), extremes)
    return extremes


def sheet(vertices: np.ndarray, normals: np.ndarray | None = None, surface: Surface = Surface(),
          label: int = FLAG, before: np.ndarray | None = None,
          texture: Texture | None = None) -> Object:
    """
    Return a cloth as an object, both sides of which are seen.

    vertices: (rows, columns, 3) [m]; normals: the same shape, of any length, on the side of (row
    direction) x (column direction), or None to average them (eq. 1.13); before: the vertices in
    the frame before, or None; texture: a picture on it, or None. Its texture coordinates go from 0
    to 1 along the rows, which is from the hoist to the fly, and from 0 to 1 down the columns, the
    same on both sides, so that the back shows the picture mirrored, as flags do.
    Raises ValueError for other shapes and types, and for fewer than two rows or columns.
    """
    return _sheet('', vertices, normals, (surface, texture), label, before)


def _sheet(prefix, vertices, normals, look, label, before):
    """Return a sheet of which the arguments' names begin with a prefix, where they are refused."""
    vertices = ranges.points(f'{prefix}vertices', vertices, (None, None, 3))
    triangles = grid_triangles(*vertices.shape[:2])
    if normals is not None:
        normals = ranges.points(f'{prefix}normals', normals, vertices.shape).reshape(-1, 3)
    if before is not None:
        before = ranges.points(f'{prefix}before', before, vertices.shape).reshape(-1, 3)
    surface, texture = look
    return Object(vertices.reshape(-1, 3), triangles, normals, surface, label,
                  texture_coordinates=_grid_coordinates(*vertices.shape[:2]), before=before,
                  texture=texture)


@functools.lru_cache(maxsize=8)
def _grid_coordinates(rows, columns):
    """Return (u, v) of the nodes of a grid: (rows columns, 2)."""
    v, u = np.mgrid[0.0:1.0:rows * 1j, 0.0:1.0:columns * 1j]
    coordinates = np.column_stack([u.ravel(), v.ravel()])
    coordinates.flags.writeable = False
    return coordinates


def body(mesh: Mesh, surface: Surface = Surface(), label: int = 0,
         before: np.ndarray | None = None, casts_shadow: bool = True) -> Object:
    """
    Return a closed mesh as an object; raises ValueError for what is none.

    before: (n, 3) [m], its vertices in the frame before, or None where that is not known;
    casts_shadow: see Object.
    """
    checks.instance('mesh', mesh, Mesh)
    return Object(mesh.vertices, mesh.triangles, mesh.normals, surface, label, True,
                  before=before, casts_shadow=casts_shadow)


def flag_scene(flag_vertices: np.ndarray, flag_normals: np.ndarray | None = None,
               camera: Camera = Camera(), materials: Materials = Materials(),
               dimensions: Dimensions = Dimensions(),
               last: LastFrame | None = None) -> list[Object]:
    """
    Return the objects of the source's scene (sec. 1.2): the flag and what else is to be seen.

    flag_vertices, flag_normals: see sheet; camera: it decides how finely round things are cut;
    last: the frame before, or None where there is none; a flag of another grid has no flow.
    Raises ValueError as sheet does, and for what is not of the class of its default.
    """
    checks.instance('camera', camera, Camera)
    checks.instance('materials', materials, Materials)
    checks.instance('dimensions', dimensions, Dimensions)
    flag_vertices = ranges.points('flag_vertices', flag_vertices, (None, None, 3))
    before = dimensions_before = None
    if last is not None:
        checks.instance('last', last, LastFrame)
        before = last.flag_vertices if np.shape(last.flag_vertices) == (
            flag_vertices.shape) else None
        dimensions_before = last.dimensions
    flag = _sheet('flag_', flag_vertices, flag_normals, (materials.flag, materials.flag_image),
                  FLAG, before)
    return [flag, *_things(camera, materials, dimensions, dimensions_before)]


@functools.lru_cache(maxsize=8)
def _things(camera, materials, dimensions, dimensions_before):
    """Return what stands in the scene beside the flag."""
    objects, segments = [], dimensions.segments(camera)

    def add(mesh_of, surface, label):
        # Cut as finely as now, so that vertices are the same ones.
        before = dimensions_before and _at_pole(mesh_of, dimensions_before, segments).vertices
        objects.append(body(_at_pole(mesh_of, dimensions, segments), surface, label, before))
    if dimensions.pole_visible:
        add(pole_mesh, materials.pole, POLE)
    if dimensions.platform_visible:
        add(platform_mesh, materials.platform, PLATFORM)
    if dimensions.ground_visible:
        mesh = ground_mesh()
        # Nothing is below it that could be in its shadow.
        objects.append(body(mesh, materials.ground, GROUND, mesh.vertices, casts_shadow=False))
    boxes_before = dimensions_before.boxes if dimensions_before else ()
    for number, box in enumerate(dimensions.boxes):
        before = boxes_before[number:number + 1]
        objects.append(body(mesh_of_box(box), box.surface, BOXES + number,
                            mesh_of_box(before[0]).vertices if before else None))
    return objects


def _at_pole(mesh_of, dimensions, segments):
    """Return a mesh of the pole or the platform where that is; built once for its sizes."""
    return placed(mesh_of(_upright(dimensions), segments), dimensions.place)


@functools.lru_cache(maxsize=4)
def _upright(dimensions):
    return dataclasses.replace(dimensions, pole_position=(0.0, 0.0, 0.0), pole_yaw=0.0,
                               pole_tilt=0.0, boxes=())
