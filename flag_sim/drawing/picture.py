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

"""A frame from end to end: a scene in, pixels out."""
from typing import Mapping

from flag_sim import checks
from flag_sim.crew import Crew
from flag_sim.drawing.attributes import PLANE
from flag_sim.drawing.bands import BAND, draw_bands, new_buffers, Plan
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.channels import Attribute, Layout
from flag_sim.drawing.culling import cull, Margin, Order
from flag_sim.drawing.framebuffer import Frame, Framebuffer
from flag_sim.drawing.geometry import Geometry, Lens, project, SUBPIXELS, Vertices
from flag_sim.drawing.mesh import face_normals
from flag_sim.drawing.multisample import PATTERNS
from flag_sim.drawing.painter import far_to_near
from flag_sim.drawing.scene import flag_scene, Object, SceneBuffers
from flag_sim.drawing.shading import Light, shade
from flag_sim.drawing.shapes import Scene
from flag_sim.drawing.style import Materials, Style
from flag_sim.drawing.visibility import Pass, slots_for

import numpy as np

# Chunks of triangles that a thread looks at in one go.
CHUNKS = 128
# More pieces than this are shared among threads; fewer are done sooner than those can begin.
WORTH_SHARING = 4
MOST_THREADS = 64


class Picture:
    """
    Draws frames into buffers of its own, which it keeps from frame to frame.

    threads: how many share a frame, 0 chooses by measuring the first frames; the pixels are the
    same for any number, up to MOST_THREADS; raises ValueError for others. Only what this frame or
    the last one drew into is emptied and turned into bytes: elsewhere the background is there
    already.

    >>> frame = Picture().draw(vertices, with_depth=True)     # (rows, columns, 3) [m]
    >>> frame.colour, frame.depth
    """

    __slots__ = ('_crew', '_scene', '_framebuffer', '_layout', '_buffers')

    def __init__(self, threads=1):
        """Begin without buffers: the first frame's camera says how large they are."""
        self._crew = Crew(checks.whole('threads', threads, 0, MOST_THREADS))
        self._scene = self._framebuffer = self._layout = None
        self._buffers = {}

    def draw(self, flag_vertices, flag_normals=None, camera=Camera(), light=Light(),
             materials=Materials(), scene=Scene(), style=Style(), with_depth=False) -> Frame:
        """
        Draw the source's scene: a flag, its pole and platform.

        flag_vertices, flag_normals: see scene.sheet; the others: see draw_scene. Raises
        ValueError for other shapes, and for what is not of the class of its default.
        """
        for name, value, kind in (('camera', camera, Camera), ('materials', materials, Materials),
                                  ('scene', scene, Scene)):
            checks.instance(name, value, kind)
        objects = flag_scene(flag_vertices, flag_normals, camera, materials, scene)
        return self.draw_scene(objects, camera, light, style, with_depth)

    def draw_scene(self, objects, camera=Camera(), light=Light(), style=Style(),
                   with_depth=False, attributes: Mapping[str, Attribute] = {}) -> Frame:
        """
        Draw a list of objects.

        with_depth: whether the frame's depth is wanted; attributes: what else it shall show, by
        names that its channels then have. Raises ValueError for what is of another class, and for
        attributes of another number of values than the objects have.
        """
        for name, value, kind in (('camera', camera, Camera), ('light', light, Light),
                                  ('style', style, Style)):
            checks.instance(name, value, kind)
        objects = list(objects)
        for number, one in enumerate(objects):
            checks.instance(f'objects[{number}]', one, Object)
        for name, one in attributes.items():
            checks.instance(name, one, Attribute)
        with self._crew:
            self._crew.call()
            if self._scene is None or not self._scene.fits(objects):
                self._scene = SceneBuffers(objects)
            self._scene.give(objects)
            values = self._lay_out(camera, style, attributes)
            geometry = self._geometry(camera)
            self._transform(objects, geometry, camera, light, style)
            order, clipped = self._cull(geometry, camera, style)
            return self._paint(geometry, order, clipped, values, (camera, style, with_depth))

    def _lay_out(self, camera, style, attributes):
        """Say where the values of vertices and triangles stand."""
        shape = len(self._scene.points), len(self._scene.triangles)
        kind = shape, style.shading == 'flat', [
            (name, one.channels, one.at) for name, one in attributes.items()]
        if self._layout is None or self._layout.kind != kind:
            self._layout = Layout(*kind[:2], attributes)
        # In orthographic projection what is linear in space is linear on the screen.
        is_perspective = style.interpolation == 'perspective' and camera.is_perspective
        background = [int(channel + 0.5) for channel in style.background]
        return self._layout.values(attributes, self._scene.parts, background, is_perspective)

    def _geometry(self, camera):
        """Return the scene's triangles and the camera for the kernels."""
        scene = self._scene
        matrix = np.diag([camera.focal, camera.focal, 1.0, 1.0]) @ camera.pose
        lens = Lens(matrix, *map(float, camera.centre), camera.near, camera.is_perspective)
        return Geometry(scene.triangles, scene.is_closed, scene.sizes, scene.vertices, lens)

    def _transform(self, objects, geometry, camera, light, style):
        """Take the vertices to the screen, and light both sides of them, or of triangles."""
        scene, colours, is_flat = self._scene, self._layout.colours, style.shading == 'flat'
        pieces = iter(scene.pieces)

        def take(thread):
            for number, piece in pieces:
                scene.take(number, piece)
                project(scene.points[piece], geometry.lens,
                        Vertices(*(array[piece] for array in scene.vertices)))
                if not is_flat:
                    shade(scene.points[piece], scene.normals[piece], camera.viewpoint,
                          objects[number].surface, light, colours[piece])

        self._share(len(scene.pieces), take)
        if is_flat:
            normals = face_normals(scene.points, scene.triangles)
            points = scene.points[scene.triangles].mean(axis=1)
            for one, (_, part) in zip(objects, scene.parts):
                shade(points[part], normals[part], camera.viewpoint, one.surface, light,
                      colours[part])

    def _cull(self, geometry, camera, style):
        """Return the Order, in which rows are found, and how many triangles must be clipped."""
        order = self._scene.order
        if style.hidden_surface == 'painter':
            order = order._replace(
                numbers=far_to_near(geometry.triangles, geometry.vertices.seen))
        # Lines lie in whole pixels, and samples beside the pixels' centres.
        margin = Margin(camera.width, camera.height,
                        SUBPIXELS if style.outline or style.samples > 1 else 0)
        chunks = order.boxes.shape[1]
        pieces, clipped = iter(range(0, chunks, CHUNKS)), []

        def take(thread):
            for first in pieces:
                clipped.append(
                    cull(geometry, order, margin, first, min(first + CHUNKS, chunks)))

        self._share(-(-chunks // CHUNKS), take)
        return order, sum(clipped)

    def _share(self, pieces, take):
        """Let the crew do take(thread), which goes on until `pieces` pieces of work are done."""
        if pieces > WORTH_SHARING:
            self._crew.deal(take)
        else:
            take(0)

    def _paint(self, geometry, order, clipped, values, look):
        """Draw all bands; buffers are made anew where the camera or the style is another."""
        camera, style, with_depth = look
        groups, shape = len(values.first), (camera.height, camera.width)
        if self._framebuffer is None or (self._framebuffer.shape, self._framebuffer.clear_colour) \
                != (shape, style.clear_colour):
            self._framebuffer = Framebuffer(camera.width, camera.height, -(-camera.height // BAND),
                                            style.clear_colour)
        images = self._framebuffer.images(with_depth, values.nothing)
        ceiling = np.float32(-np.inf if style.hidden_surface == 'painter' else np.inf)
        plan = Plan(Pass(np.int32(0), np.int32(0), ceiling, style.outline, groups),
                    np.int32(PATTERNS[style.samples] * SUBPIXELS),
                    np.float32(0.0 if camera.is_perspective else -np.inf), *shape[::-1])
        slots = slots_for(len(geometry.triangles), clipped, style.outline)
        kind = camera.width, len(geometry.triangles), style.samples > 1
        if any(known != kind or buffers.table.size < slots * groups * PLANE
               for known, buffers in self._buffers.values()):
            self._buffers = {}
        taken = np.zeros(1, np.int64)

        def draw(thread):
            if thread not in self._buffers:
                self._buffers[thread] = kind, new_buffers(*kind[:2], slots * groups, kind[2])
            draw_bands(taken, geometry, order, values, plan, self._buffers[thread][1], images)

        self._crew.deal(draw)
        return self._framebuffer.frame(self._layout.names)
