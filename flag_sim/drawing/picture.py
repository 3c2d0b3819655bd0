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
from flag_sim.crew import Crew
from flag_sim.drawing import checks, rasterizer, tiles
from flag_sim.drawing.assembly import Assembly
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.canvas import Canvas, SampleBuffers
from flag_sim.drawing.light import Light, shade
from flag_sim.drawing.mesh import face_normals
from flag_sim.drawing.painter import far_to_near
from flag_sim.drawing.projection import bounds, project
from flag_sim.drawing.scene import Scene
from flag_sim.drawing.style import Materials, Style

import numpy as np


class Picture:
    """
    Draws frames into buffers of its own, which it keeps from frame to frame.

    threads: how many share a frame, 0 chooses by measuring the first frames; the pixels are the
    same for any number. Only the rectangles that this frame or the last one drew into are
    emptied and turned into bytes: elsewhere the background is there already.

    >>> picture = Picture()
    >>> rgb = picture.draw(vertices)            # (rows, columns, 3) [m]
    >>> depth = picture.depth()                 # of the same frame, if it is wanted
    """

    def __init__(self, threads=1):
        """Begin without buffers: the first frame's camera says how large they are."""
        self._crew = Crew(threads)
        self._camera = self._canvas = self._samples = self._assembly = None
        self._drawn = {}

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
        with self._crew:
            self._assemble(flag_vertices, flag_normals, camera, scene)
            emptied = self._empty(camera, style)
            view, screen, where = self._project(style)
            colours = self._shade(materials, light, style)
            self._paint(view, screen, where, colours, style, emptied)
            rectangles = [_union(emptied.get(name), self._drawn.get(name))
                          for name in {**emptied, **self._drawn}]
            self._crew.share(lambda *band: self._canvas.to_bytes(rectangles, *band))
        return self._canvas.rgb

    def depth(self):
        """
        Give the last frame's depth along the optical axis: (height, width) float32 [m].

        It is that of the pixels' centres, and +inf where nothing is. Raises ValueError before
        the first frame.
        """
        checks.require(self._camera, 'depth', 'asked for after a frame is drawn', None)
        if not self._camera.is_perspective:
            return -self._canvas.nearness_image
        with np.errstate(divide='ignore'):
            return np.float32(1.0) / self._canvas.nearness_image

    def _assemble(self, vertices, normals, camera, scene):
        """Join flag and scene; what stands still is joined once."""
        vertices = np.asarray(vertices)
        checks.require(vertices.ndim == 3 and vertices.shape[2] == 3, 'flag_vertices',
                       'of shape (rows, columns, 3)', vertices.shape)
        kind = vertices.shape[:2], scene, scene.segments(camera)
        if self._assembly is None or self._assembly.kind != kind:
            self._assembly = Assembly(*vertices.shape[:2], *kind[1:])
        self._assembly.set_flag(vertices, normals)

    def _empty(self, camera, style):
        """
        Take a canvas, made anew where the camera or the background is another.

        Returns the rectangles to empty, by name: what the frame before drew, or all.
        """
        farthest = 0.0 if camera.is_perspective else -np.inf
        kind = camera.width, camera.height, style.word, farthest
        self._camera = camera
        if self._canvas is not None and self._canvas.kind == kind:
            return self._drawn
        self._canvas = Canvas(*kind)
        return {'all': (0, camera.height, 0, camera.width)}

    def _project(self, style):
        """Take the vertices to the screen; keep the rectangle that each thing can cover."""
        points, camera = self._assembly.points, self._camera
        view, screen = np.empty(points.shape), np.empty(points.shape)
        where = np.empty(len(points), np.uint8)
        matrix = np.diag([camera.focal, camera.focal, 1.0, 1.0]) @ camera.pose
        project(points, matrix, *camera.centre, camera.near, camera.is_perspective,
                view, screen, where)
        # Lines lie in whole pixels, and samples beside the pixels' centres.
        margin = 1 if style.outline or style.samples > 1 else 0
        self._drawn = {
            name: bounds(screen[vertices], where[vertices], camera.width, camera.height, margin)
            for name, (vertices, _) in self._assembly.parts.items()}
        return view, screen, where

    def _shade(self, materials, light, style):
        """Give the colours of both sides of all vertices, or of all triangles if flat."""
        points, normals = self._assembly.points, self._assembly.normals
        is_flat = style.shading == 'flat'
        if is_flat:
            triangles = self._assembly.triangles
            normals = face_normals(points, triangles)
            points = points[triangles].mean(axis=1)
        colours = np.empty((len(points), 2, 3))
        for name, slices in self._assembly.parts.items():
            part = slices[is_flat]
            shade(points[part], normals[part], self._camera.viewpoint, getattr(materials, name),
                  light, colours[part])
        return colours

    def _paint(self, view, screen, where, colours, style, emptied):
        """Fill the canvas, then draw the samples of its edges."""
        assembly, camera, canvas = self._assembly, self._camera, self._canvas
        is_painted = style.hidden_surface == 'painter'
        order = far_to_near(assembly.triangles, view) if is_painted else assembly.order
        # In orthographic projection what is linear in space is linear on the screen.
        is_correct = style.interpolation == 'perspective' and camera.is_perspective

        def fill(order, shift, marks, band, bands, nearness, words):
            rasterizer.fill(
                assembly.triangles, order, assembly.closed, view, screen, where, colours,
                style.shading == 'flat', *camera.centre, camera.near, camera.is_perspective,
                is_correct, is_painted, style.outline, *shift, marks, band, bands,
                camera.width, camera.height, nearness, words)

        def draw_centres(band, bands):
            canvas.clear(emptied.values(), band, bands)
            fill(order, (0.0, 0.0), tiles.no_marks(), band, bands, canvas.nearness, canvas.words)

        self._crew.share(draw_centres)
        if style.samples == 1:
            return
        if self._samples is None or self._samples.size != (camera.width, camera.height):
            self._samples = SampleBuffers(camera.width, camera.height)
        samples = self._samples
        pattern = tiles.PATTERNS[style.samples]

        def draw_samples(band, bands):
            where_to = samples.marks, camera.width, camera.height, band, bands
            touching = np.empty_like(order)
            count = tiles.touching(assembly.triangles, order, screen, where, *where_to, touching)
            buffers = (canvas.kind[2], np.float32(canvas.kind[3]), samples.words,
                       samples.nearness, samples.sums)
            tiles.clear_marked(*where_to, *buffers)
            for shift in pattern:
                fill(touching[:count], tuple(shift), samples.marks, band, bands,
                     samples.nearness, samples.words)
                tiles.add_sample(*where_to, *buffers)
            tiles.resolve(*where_to, style.samples, samples.sums, canvas.words)

        self._crew.share(lambda *bands: tiles.mark_edges(
            canvas.words, camera.width, camera.height, *bands,
            np.empty(camera.width + tiles.TILE, np.uint32), samples.marks))
        self._crew.share(draw_samples)


def _union(one, other):
    """Bound two rectangles (top, bottom, left, right), either of which may be None or empty."""
    some = [rectangle for rectangle in (one, other) if rectangle and rectangle[0] < rectangle[1]]
    if not some:
        return 0, 0, 0, 0
    tops, bottoms, lefts, rights = zip(*some)
    return min(tops), max(bottoms), min(lefts), max(rights)
