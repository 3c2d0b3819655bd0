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
from flag_sim.drawing.mesh import grid_triangles, Mesh
from flag_sim.drawing.shading import Surface
from flag_sim.drawing.shapes import Dimensions, platform_mesh, pole_mesh
from flag_sim.drawing.style import Materials
from flag_sim.parameters import checks

import numpy as np

# What labels of pixels mean; 0 is nothing, and further objects count from 4.
FLAG, POLE, PLATFORM = 1, 2, 3


@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """
    One thing to draw.

    vertices: (n, 3) [m]; those that are not finite take their triangles out of the picture;
    triangles: (m, 3) of whole numbers, indices of vertices, counterclockwise seen from the front;
    normals: (n, 3) at the vertices, out of the front, of any length, or None to average them from
    the triangles (eq. 1.13); surface: how it looks; label: a whole number from 0 to 255 that tells
    its pixels from others'; is_closed: whether it is a closed body, whose back faces are never
    seen. Arrays that are read-only are taken to be the same in the next frame; others are read
    again. Raises ValueError for other shapes and types, and for triangles of vertices that do not
    exist.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None = None
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
        if triangles.size:
            least, most = _extremes(triangles)
            checks.require(0 <= least and most < len(vertices), 'triangles',
                           f'indices of the {len(vertices)} vertices', (least, most))
        object.__setattr__(self, 'triangles', triangles)
        checks.instance('surface', self.surface, Surface)
        object.__setattr__(self, 'label', checks.whole('label', self.label, 0, 255))
        object.__setattr__(self, 'is_closed', checks.boolean('is_closed', self.is_closed))


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
          label: int = FLAG) -> Object:
    """
    Return a cloth as an object, both sides of which are seen.

    vertices: (rows, columns, 3) [m]; normals: the same shape, of any length, on the side of (row
    direction) x (column direction), or None to average them (eq. 1.13).
    Raises ValueError for other shapes and types, and for fewer than two rows or columns.
    """
    return _sheet('', vertices, normals, surface, label)


def _sheet(prefix, vertices, normals, surface, label):
    """Return a sheet of which the arguments' names begin with a prefix, where they are refused."""
    vertices = ranges.points(f'{prefix}vertices', vertices, (None, None, 3))
    triangles = grid_triangles(*vertices.shape[:2])
    if normals is not None:
        normals = ranges.points(f'{prefix}normals', normals, vertices.shape).reshape(-1, 3)
    return Object(vertices.reshape(-1, 3), triangles, normals, surface, label)


def body(mesh: Mesh, surface: Surface = Surface(), label: int = 0) -> Object:
    """Return a closed mesh as an object; raises ValueError for what is none."""
    checks.instance('mesh', mesh, Mesh)
    return Object(mesh.vertices, mesh.triangles, mesh.normals, surface, label, True)


def flag_scene(flag_vertices: np.ndarray, flag_normals: np.ndarray | None = None,
               camera: Camera = Camera(), materials: Materials = Materials(),
               dimensions: Dimensions = Dimensions()) -> list[Object]:
    """
    Return the objects of the source's scene (sec. 1.2): the flag and, if seen, pole and platform.

    flag_vertices, flag_normals: see sheet; camera: it decides how finely round things are cut.
    Raises ValueError as sheet does, and for what is not of the class of its default.
    """
    checks.instance('camera', camera, Camera)
    checks.instance('materials', materials, Materials)
    checks.instance('dimensions', dimensions, Dimensions)
    flag = _sheet('flag_', flag_vertices, flag_normals, materials.flag, FLAG)
    return [flag, *_pole_and_platform(camera, materials, dimensions)]


@functools.lru_cache(maxsize=8)
def _pole_and_platform(camera, materials, dimensions):
    objects, segments = [], dimensions.segments(camera)
    if dimensions.pole_visible:
        objects.append(body(pole_mesh(dimensions, segments), materials.pole, POLE))
    if dimensions.platform_visible:
        objects.append(body(platform_mesh(dimensions, segments), materials.platform, PLATFORM))
    return objects
