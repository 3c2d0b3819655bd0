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
import functools

from flag_sim.drawing.bands import BAND, draw_bands, new_buffers, Plan
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.culling import cull, Margin
from flag_sim.drawing.framebuffer import Frame, Framebuffer
from flag_sim.drawing.geometry import Geometry, Lens, project, SUBPIXELS
from flag_sim.drawing.mesh import face_normals
from flag_sim.drawing.multisample import PATTERNS
from flag_sim.drawing.painter import far_to_near
from flag_sim.drawing.scene import flag_scene, Object, SceneBuffers
from flag_sim.drawing.shading import Light, shade
from flag_sim.drawing.shapes import Scene
from flag_sim.drawing.style import Materials, Style
from flag_sim.drawing.visibility import Colours, Pass, slots_for
from flag_sim.parallel.thread_pool import ThreadPool
from flag_sim.parameters import checks

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

    __slots__ = ('_pool', '_scene', '_framebuffer', '_colours', '_buffers')

    def __init__(self, threads=1):
        """Begin without buffers: the first frame's camera says how large they are."""
        self._pool = ThreadPool(checks.whole('threads', threads, 0, MOST_THREADS))
        self._scene = self._framebuffer = self._colours = None
        self._buffers = {}

    def draw(self, flag_vertices, flag_normals=None, camera=Camera(), light=Light(),
             materials=Materials(), scene=Scene(), style=Style(), with_depth=False) -> Frame:
        """
        Draw the source's scene: a flag, its pole and platform.

        flag_vertices, flag_normals: see scene.sheet; the others: see draw_scene. Raises
        ValueError for other shapes, and for what is not of the class of its default.
        """
        checks.instance('camera', camera, Camera)
        checks.instance('materials', materials, Materials)
        checks.instance('scene', scene, Scene)
        objects = flag_scene(flag_vertices, flag_normals, camera, materials, scene)
        return self.draw_scene(objects, camera, light, style, with_depth)

    def draw_scene(self, objects, camera=Camera(), light=Light(), style=Style(),
                   with_depth=False, with_visibility=False) -> Frame:
        """
        Draw a list of objects.

        with_depth, with_visibility: what the Frame shall hold beside the colour. Raises
        ValueError for what is of another class, and for a list without triangles.
        """
        checks.instance('camera', camera, Camera)
        checks.instance('light', light, Light)
        checks.instance('style', style, Style)
        objects = list(objects)
        for one in objects:
            checks.instance('each of objects', one, Object)
        with self._pool:
            self._pool.wake()
            if self._scene is None or not self._scene.fits(objects):
                self._scene = SceneBuffers(objects)
            geometry = self._geometry(camera)
            colours = self._transform(objects, geometry, camera, light, style)
            order = self._cull(geometry, camera, style)
            slots = slots_for(geometry) if with_visibility else 0
            self._paint(geometry, colours, order, slots, with_depth, camera, style)
        return self._framebuffer.frame(geometry)

    def _geometry(self, camera):
        """Return the scene's triangles and the camera for the kernels."""
        scene = self._scene
        return Geometry(scene.triangles, scene.is_closed, scene.sizes, scene.vertices,
                        _lens(camera))

    def _transform(self, objects, geometry, camera, light, style):
        """Take the vertices to the screen; return Colours of both sides of them, or triangles."""
        scene, is_flat = self._scene, style.shading == 'flat'
        shape = len(scene.triangles if is_flat else scene.points), 2, 3
        if self._colours is None or self._colours.shape != shape:
            self._colours = np.empty(shape)
        colours = self._colours
        look = camera, light, is_flat
        given = scene.give(objects, look)
        pieces = iter(given)

        def take(thread):
            for piece in pieces:
                scene.take(piece)
                project(piece.points, geometry.lens, piece.vertices)
                if not is_flat:
                    shade(piece.points, piece.normals, camera.viewpoint,
                          objects[piece.number].surface, light, colours[piece.own])

        self._share(len(given), take)
        scene.keep(objects, look)
        if is_flat:
            normals = face_normals(scene.points, scene.triangles)
            points = scene.points[scene.triangles].mean(axis=1)
            for one, (_, part) in zip(objects, scene.parts):
                shade(points[part], normals[part], camera.viewpoint, one.surface, light,
                      colours[part])
        return Colours(colours, is_flat)

    def _cull(self, geometry, camera, style):
        """Return the Order, in which rows are found."""
        order = self._scene.order
        if style.hidden_surface == 'painter':
            order = order._replace(
                numbers=far_to_near(geometry.triangles, geometry.vertices.seen))
        # Lines lie in whole pixels, and samples beside the pixels' centres.
        margin = Margin(camera.width, camera.height,
                        SUBPIXELS if style.outline or style.samples > 1 else 0)
        chunks = order.boxes.shape[1]
        # To call the kernel takes as long as some hundred triangles.
        step = CHUNKS if self._pool.threads > 1 else chunks
        pieces = iter(range(0, chunks, step))

        def take(thread):
            for first in pieces:
                cull(geometry, order, margin, first, min(first + step, chunks))

        self._share(-(-chunks // step), take)
        return order

    def _share(self, pieces, take):
        """Let the pool do take(thread), which goes on until `pieces` pieces of work are done."""
        if pieces > WORTH_SHARING:
            self._pool.parallel_for(take)
        else:
            take(0)

    def _paint(self, geometry, colours, order, slots, with_depth, camera, style):
        """Draw all bands; buffers are made anew where the camera or the style is another."""
        kind = camera.width, camera.height, style.clear_colour
        if self._framebuffer is None or self._framebuffer.kind != kind:
            self._framebuffer = Framebuffer(*kind[:2], -(-camera.height // BAND), kind[2])
        images = self._framebuffer.images(with_depth, slots > 0)
        plan = _plan(camera, style)
        kind = camera.width, len(geometry.triangles), style.samples > 1, slots
        if any(known != kind for known, _ in self._buffers.values()):
            self._buffers = {}
        taken = np.zeros(1, np.int64)

        def draw(thread):
            if thread not in self._buffers:
                self._buffers[thread] = kind, new_buffers(*kind)
            draw_bands(taken, geometry, colours, order, plan, self._buffers[thread][1], images)

        self._pool.parallel_for(draw)


@functools.lru_cache(maxsize=8)
def _lens(camera):
    """Return a camera for the kernels."""
    matrix = np.diag([camera.focal, camera.focal, 1.0, 1.0]) @ camera.pose
    return Lens(matrix, *map(float, camera.centre), camera.near, camera.is_perspective)


@functools.lru_cache(maxsize=8)
def _plan(camera, style):
    """Return the Plan of a camera and a style."""
    is_painter = style.hidden_surface == 'painter'
    # In orthographic projection what is linear in space is linear on the screen.
    is_perspective_correct = style.interpolation == 'perspective' and camera.is_perspective
    return Plan(
        Pass(np.int32(0), np.int32(0), np.float32(-np.inf if is_painter else np.inf),
             style.outline, is_perspective_correct),
        np.int32(PATTERNS[style.samples] * SUBPIXELS), style.clear_colour,
        np.float32(0.0 if camera.is_perspective else -np.inf), camera.width, camera.height)
