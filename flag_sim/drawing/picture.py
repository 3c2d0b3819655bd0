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
from flag_sim import checks
from flag_sim.crew import Crew
from flag_sim.drawing import ranges
from flag_sim.drawing.assembly import Assembly
from flag_sim.drawing.bands import BAND, Buffers, draw_bands
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.canvas import Canvas
from flag_sim.drawing.culling import cull
from flag_sim.drawing.light import Light, shade
from flag_sim.drawing.mesh import face_normals
from flag_sim.drawing.painter import far_to_near
from flag_sim.drawing.projection import project, SUBPIXELS
from flag_sim.drawing.scene import Scene
from flag_sim.drawing.style import Materials, Style
from flag_sim.drawing.tiles import PATTERNS

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

    >>> picture = Picture()
    >>> rgb = picture.draw(vertices)            # (rows, columns, 3) [m]
    >>> depth = picture.depth()                 # of the same frame, if it is wanted
    """

    __slots__ = ('_crew', '_camera', '_canvas', '_assembly', '_draw_bands', '_colours', '_buffers',
                 '_order', '_is_depth_kept', '_is_depth_wanted')

    def __init__(self, threads=1):
        """Begin without buffers: the first frame's camera says how large they are."""
        self._crew = Crew(checks.whole('threads', threads, 0, MOST_THREADS))
        self._camera = self._canvas = self._assembly = self._draw_bands = self._colours = None
        self._buffers = {}
        self._is_depth_kept = self._is_depth_wanted = False

    def draw(self, flag_vertices, flag_normals=None, camera=Camera(), light=Light(),
             materials=Materials(), scene=Scene(), style=Style()):
        """
        Draw one frame and return it: (height, width, 3) uint8, C-contiguous.

        flag_vertices: (rows, columns, 3) [m]; flag_normals: the same shape, of any length, on
        the side of (row direction) x (column direction); None averages them from the triangles
        (1.13). A vertex that is not finite takes its triangles out of the picture. The array is
        the picture's own, so it is read-only, and the next frame overwrites it. Raises ValueError
        for other shapes, and for what is not of the class of its default.
        """
        for name, value, kind in (('camera', camera, Camera), ('light', light, Light),
                                  ('materials', materials, Materials), ('scene', scene, Scene),
                                  ('style', style, Style)):
            checks.instance(name, value, kind)
        with self._crew:
            self._crew.call()
            self._assemble(flag_vertices, flag_normals, camera, scene)
            self._transform(materials, light, style)
            self._cull(style)
            self._paint(style)
        return self._canvas.rgb

    def depth(self):
        """
        Return the last frame's depth along the optical axis: (height, width) float32 [m].

        It is that of the pixels' centres, and +inf where nothing is. The first time, the frame is
        drawn again for it; the next frames keep it as long as it is asked for each time. Raises
        ValueError before the first frame.
        """
        checks.require(self._camera, 'depth', 'asked for after a frame is drawn', None)
        self._is_depth_wanted = True
        if not self._is_depth_kept:
            self._is_depth_kept = True
            self._share_bands()
        reversed_z = self._canvas.reversed_z(True).reshape(self._camera.height, self._camera.width)
        if not self._camera.is_perspective:
            return -reversed_z
        with np.errstate(divide='ignore'):
            return np.float32(1.0) / reversed_z

    def _assemble(self, vertices, normals, camera, scene):
        """Join flag and scene; what stands still is joined once."""
        vertices = ranges.points('flag_vertices', vertices, (None, None, 3))
        self._camera = camera
        kind = vertices.shape[:2], scene, scene.segments(camera)
        if self._assembly is None or self._assembly.kind != kind:
            self._assembly = Assembly(*vertices.shape[:2], *kind[1:])
        self._assembly.give_flag(vertices, normals)

    def _transform(self, materials, light, style):
        """Take the vertices to the screen, and light both sides of them, or of triangles."""
        assembly, camera = self._assembly, self._camera
        matrix = np.diag([camera.focal, camera.focal, 1.0, 1.0]) @ camera.pose
        is_flat = style.shading == 'flat'
        shape = len(assembly.triangles if is_flat else assembly.points), 2, 3
        if self._colours is None or self._colours.shape != shape:
            self._colours = np.empty(shape)
        pieces = iter(assembly.pieces)

        def take(thread):
            for name, piece in pieces:
                if name == 'flag':
                    assembly.take_flag(piece)
                project(assembly.points[piece], matrix, *camera.centre, camera.near,
                        camera.is_perspective, assembly.view[piece], assembly.u[piece],
                        assembly.v[piece], assembly.reversed_z[piece], assembly.outcodes[piece])
                if not is_flat:
                    shade(assembly.points[piece], assembly.normals[piece], camera.viewpoint,
                          getattr(materials, name), light, self._colours[piece])

        self._share(len(assembly.pieces), take)
        if is_flat:
            normals = face_normals(assembly.points, assembly.triangles)
            points = assembly.points[assembly.triangles].mean(axis=1)
            for name, (_, part) in assembly.parts.items():
                shade(points[part], normals[part], camera.viewpoint, getattr(materials, name),
                      light, self._colours[part])

    def _cull(self, style):
        """Find what can be seen in which rows."""
        assembly, camera = self._assembly, self._camera
        if style.hidden_surface == 'painter':
            self._order = far_to_near(assembly.triangles, assembly.view)
        else:
            self._order = assembly.order
        # Lines lie in whole pixels, and samples beside the pixels' centres.
        margin = SUBPIXELS if style.outline or style.samples > 1 else 0
        chunks = assembly.boxes.shape[1]
        pieces = iter(range(0, chunks, CHUNKS))

        def take(thread):
            for first in pieces:
                cull(assembly.triangles, self._order, first, min(first + CHUNKS, chunks),
                     assembly.u, assembly.v, assembly.outcodes, margin, camera.width,
                     camera.height, assembly.kinds, assembly.spans, assembly.boxes)

        self._share(-(-chunks // CHUNKS), take)

    def _share(self, pieces, take):
        """Let the crew do take(thread), which goes on until `pieces` pieces of work are done."""
        if pieces > WORTH_SHARING:
            self._crew.deal(take)
        else:
            take(0)

    def _paint(self, style):
        """Draw all bands; buffers are made anew where the camera or the style is another."""
        assembly, camera = self._assembly, self._camera
        clear_depth = 0.0 if camera.is_perspective else -np.inf
        kind = camera.width, camera.height, style.clear_colour, clear_depth
        if self._canvas is None or self._canvas.kind != kind:
            bands = -(-camera.height // BAND)
            self._canvas = Canvas(camera.width, camera.height, bands, *kind[2:])
        kind = camera.width, len(assembly.triangles), style.samples > 1
        if any(buffers.kind != kind for buffers in self._buffers.values()):
            self._buffers = {}
        # In orthographic projection what is linear in space is linear on the screen.
        is_perspective_correct = style.interpolation == 'perspective' and camera.is_perspective
        pattern = np.int32(PATTERNS[style.samples] * SUBPIXELS)

        def draw(thread, taken, reversed_z):
            if thread not in self._buffers:
                self._buffers[thread] = Buffers(*kind)
            buffers, canvas = self._buffers[thread], self._canvas
            draw_bands(taken, assembly.triangles, self._order, assembly.spans, assembly.boxes,
                       assembly.kinds, assembly.closed, assembly.view, assembly.u, assembly.v,
                       assembly.reversed_z, assembly.outcodes, self._colours,
                       style.shading == 'flat', *camera.centre, camera.near, camera.is_perspective,
                       is_perspective_correct, style.hidden_surface == 'painter', style.outline,
                       pattern, style.clear_colour, np.float32(clear_depth), camera.width,
                       camera.height, buffers.stride, *buffers.arrays, canvas.drawn,
                       canvas.byte_array, canvas.word_array, reversed_z)

        self._draw_bands = draw
        self._is_depth_kept, self._is_depth_wanted = self._is_depth_wanted, False
        self._share_bands()

    def _share_bands(self):
        """Let the crew draw the last frame's bands, with its reversed Z if that is kept."""
        reversed_z = self._canvas.reversed_z(self._is_depth_kept)
        taken = np.zeros(1, np.int64)
        self._crew.deal(lambda thread: self._draw_bands(thread, taken, reversed_z))
