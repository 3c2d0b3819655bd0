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

"""A frame from end to end: flag, pole and platform in, pixels out."""
import dataclasses

from flag_sim.drawing import checks, rasterizer
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.light import Light, Material, shade
from flag_sim.drawing.mesh import face_normals, grid_triangles, Mesh, vertex_normals
from flag_sim.drawing.scene import platform_mesh, pole_mesh, Scene
from flag_sim.drawing.spans import unpack

import numpy as np

SHADINGS = ('gouraud', 'flat')
INTERPOLATIONS = ('screen', 'perspective')


@dataclasses.dataclass(frozen=True)
class Materials:
    """What the three things of the scene are made of."""

    flag: Material = Material((205.0, 35.0, 40.0))
    pole: Material = Material((200.0, 200.0, 205.0))
    platform: Material = Material((150.0, 145.0, 135.0))


@dataclasses.dataclass(frozen=True)
class Style:
    """
    How the picture is made.

    background: (3,) colour where nothing is, 0 to 255; shading: 'gouraud' interpolates the
    vertices' colours, 'flat' gives each triangle one; interpolation: of colours, 'screen' is
    linear from pixel to pixel as in 1.14, 'perspective' linear in space.
    Raises ValueError for a colour out of range or another word.
    """

    background: tuple = (180.0, 240.0, 240.0)
    shading: str = 'gouraud'
    interpolation: str = 'screen'

    def __post_init__(self):
        """Refuse unknown words and colours; keep plain numbers."""
        object.__setattr__(self, 'background', checks.color('background', self.background))
        checks.one_of('shading', self.shading, SHADINGS)
        checks.one_of('interpolation', self.interpolation, INTERPOLATIONS)


class Picture:
    """
    Draws frames into buffers of its own, which it keeps from frame to frame.

    Only the rectangles that this frame or the last one drew into are emptied and turned into
    bytes: elsewhere the background is there already.

    >>> picture = Picture()
    >>> rgb = picture.draw(vertices)            # (rows, columns, 3) [m]
    >>> depth = picture.depth()                 # of the same frame, if it is wanted
    """

    def __init__(self):
        """Begin without buffers: the first frame's camera says how large they are."""
        self._camera = None
        self._cleared_to = None
        self._drawn = {}
        self._grid = None
        self._grid_triangles = None

    def draw(self, flag_vertices, flag_normals=None, camera=Camera(), light=Light(),
             materials=Materials(), scene=Scene(), style=Style()):
        """
        Draw one frame and return it: (height, width, 3) uint8, C-contiguous.

        flag_vertices: (rows, columns, 3) [m]; flag_normals: the same shape, of any length, on
        the side of (row direction) x (column direction); None averages them from the triangles
        (1.13). A vertex that is not finite takes its triangles out of the picture. The array is
        the picture's own, so it is read-only, and the next frame overwrites it. Raises ValueError
        for other shapes.
        """
        segments = scene.segments(camera)
        things = {'flag': (self._flag(flag_vertices, flag_normals), materials.flag)}
        if scene.pole_visible:
            things['pole'] = pole_mesh(scene, segments), materials.pole
        if scene.platform_visible:
            things['platform'] = platform_mesh(scene, segments), materials.platform

        emptied = self._clear(camera, style)
        self._drawn = {name: self._draw_mesh(mesh, material, light, style)
                       for name, (mesh, material) in things.items()}
        for name in {**emptied, **self._drawn}:
            rectangle = _union(emptied.get(name), self._drawn.get(name))
            unpack(self._words, self._bytes, camera.width, *rectangle)
        return self._rgb

    def depth(self):
        """
        Give the last frame's depth along the optical axis: (height, width) float32 [m].

        It is +inf where nothing is. Raises ValueError before the first frame.
        """
        checks.require(self._camera, 'depth', 'asked for after a frame is drawn', None)
        if not self._camera.is_perspective:
            return -self._nearness_image
        with np.errstate(divide='ignore'):
            return np.float32(1.0) / self._nearness_image

    def _flag(self, vertices, normals):
        """Make the flag's mesh from its grid."""
        vertices = np.asarray(vertices)
        checks.require(vertices.ndim == 3 and vertices.shape[2] == 3, 'flag_vertices',
                       'of shape (rows, columns, 3)', vertices.shape)
        if self._grid != vertices.shape:
            self._grid_triangles = grid_triangles(*vertices.shape[:2])
            self._grid = vertices.shape
        points = np.ascontiguousarray(vertices.reshape(-1, 3), dtype=np.float64)
        if normals is None:
            normals = vertex_normals(points, self._grid_triangles)
        else:
            normals = np.asarray(normals)
            checks.require(normals.shape == vertices.shape, 'flag_normals',
                           f'of the shape of flag_vertices {vertices.shape}', normals.shape)
            normals = np.ascontiguousarray(normals.reshape(-1, 3), dtype=np.float64)
        return Mesh(points, self._grid_triangles, normals, two_sided=True)

    def _clear(self, camera, style):
        """
        Empty the buffers, made anew where the camera wants another size, and take its matrix.

        Returns the rectangles that were emptied, by name: what the frame before drew, or all.
        """
        self._matrix = np.diag([camera.focal, camera.focal, 1.0, 1.0]) @ camera.pose
        red, green, blue = (int(channel + 0.5) for channel in style.background)
        word = red | green << 8 | blue << 16
        farthest = 0.0 if camera.is_perspective else -np.inf
        cleared_to = camera.width, camera.height, word, farthest
        if cleared_to == self._cleared_to:
            emptied = self._drawn
        else:
            self._cleared_to = cleared_to
            self._allocate(camera.width, camera.height)
            emptied = {'all': (0, camera.height, 0, camera.width)}
        self._camera = camera
        for top, bottom, left, right in emptied.values():
            self._words_image[top:bottom, left:right] = word
            self._nearness_image[top:bottom, left:right] = farthest
        return emptied

    def _allocate(self, width, height):
        """Make buffers, flat for the kernels, and the views of them that are images."""
        pixels = width * height
        # Colours are turned into bytes four at a time.
        padded = -(-pixels // 4) * 4
        self._nearness = np.empty(padded, np.float32)
        self._words = np.zeros(padded, np.uint32)
        self._bytes = np.empty(padded // 4 * 3, np.uint32)
        self._nearness_image = self._nearness[:pixels].reshape(height, width)
        self._words_image = self._words[:pixels].reshape(height, width)
        self._rgb = self._bytes.view(np.uint8)[:3 * pixels].reshape(height, width, 3)
        self._rgb.flags.writeable = False

    def _draw_mesh(self, mesh, material, light, style):
        """Take a mesh from the world to the buffers; return the rectangle that it can cover."""
        camera = self._camera
        is_flat = style.shading == 'flat'
        normals = face_normals(mesh.vertices, mesh.triangles) if is_flat else mesh.normals
        colours = shade(normals, material, light)
        view, screen = np.empty(mesh.vertices.shape), np.empty(mesh.vertices.shape)
        where = np.empty(len(mesh.vertices), np.uint8)
        rasterizer.project(mesh.vertices, self._matrix, *camera.centre, camera.near,
                           camera.is_perspective, view, screen, where)
        # In orthographic projection what is linear in space is linear on the screen.
        is_correct = style.interpolation == 'perspective' and camera.is_perspective
        rasterizer.fill(mesh.triangles, view, screen, where, colours, is_flat, mesh.two_sided,
                        *camera.centre, camera.near, camera.is_perspective, is_correct,
                        0, 1, camera.width, camera.height, self._nearness, self._words)
        return rasterizer.bounds(screen, where, camera.width, camera.height)


def _union(one, other):
    """Bound two rectangles (top, bottom, left, right), either of which may be None or empty."""
    some = [rectangle for rectangle in (one, other) if rectangle and rectangle[0] < rectangle[1]]
    if not some:
        return 0, 0, 0, 0
    tops, bottoms, lefts, rights = zip(*some)
    return min(tops), max(bottoms), min(lefts), max(rights)
