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

"""A picture: a scene in, a frame out, stage by stage."""
from collections.abc import Iterable
import functools

from flag_sim.drawing.bands import BAND, draw_bands, new_buffers, Rare, RenderSettings
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.channel_pass import new_values, resolve
from flag_sim.drawing.channels import attributes_of, channel_names, needs_faces
from flag_sim.drawing.culling import CHUNK, cull, Viewport
from flag_sim.drawing.depth import clear_depth
from flag_sim.drawing.dimensions import Dimensions
from flag_sim.drawing.framebuffer import Frame, Framebuffer
from flag_sim.drawing.geometry import project, SUBPIXELS, view_transform
from flag_sim.drawing.mesh import face_normals
from flag_sim.drawing.multisample import PATTERNS
from flag_sim.drawing.painter import far_to_near
from flag_sim.drawing.planes import set_planes, set_weight_planes
from flag_sim.drawing.rasterizer import Colours, RasterizerState
from flag_sim.drawing.scene import flag_scene, Object
from flag_sim.drawing.scene_buffers import SceneBuffers
from flag_sim.drawing.shaded_scene import ShadedScene
from flag_sim.drawing.shading import Light
from flag_sim.drawing.style import Materials, Style, THREADS
from flag_sim.drawing.surfaces import set_surfaces
from flag_sim.parallel.thread_pool import ThreadPool
from flag_sim.parameters import checks

import numpy as np

# Chunks of triangles that a thread culls in one go.
CHUNKS_AT_ONCE = 128
# More pieces of work than this are shared among threads; fewer are done sooner than those begin.
WORTH_SHARING = 4


class Picture:
    """
    Draws frames into buffers of its own, which it keeps from frame to frame.

    threads: how many share a frame, see THREADS; 0 chooses by measuring the first frames. The
    pixels are the same for any number. Raises ValueError for others. Only what this frame or the
    last one drew into is cleared and turned into bytes: elsewhere the background is there already.

    >>> frame = Picture().draw(vertices, channels=['depth'])     # (rows, columns, 3) [m]
    >>> frame.colour, frame.depth
    """

    __slots__ = ('_threads', '_pool', '_scene', '_framebuffer', '_colours', '_buffers', '_shaded')

    def __init__(self, threads: int = THREADS.default):
        """Begin without buffers: the first frame's camera says how large they are."""
        self._threads = THREADS.convert(threads)
        self._pool = ThreadPool(self._threads)
        self._scene = self._framebuffer = self._colours = None
        self._buffers = {}
        self._shaded = ShadedScene(self._run)

    def __reduce__(self):
        """Let a copy, also one of a file, begin without buffers: it draws the same."""
        return type(self), (self._threads,)

    def draw(self, flag_vertices: np.ndarray, flag_normals: np.ndarray | None = None,
             camera: Camera = Camera(), light: Light = Light(),
             materials: Materials = Materials(), dimensions: Dimensions = Dimensions(),
             style: Style = Style(), channels: Iterable[str] = ()) -> Frame:
        """
        Draw the source's scene (sec. 1.2): a flag, its pole and its platform.

        flag_vertices, flag_normals: see scene.sheet; the others: see scene.flag_scene and
        draw_scene. Raises ValueError for other shapes, and for what is not of the class of its
        default.
        """
        objects = flag_scene(flag_vertices, flag_normals, camera, materials, dimensions)
        return self.draw_scene(objects, camera, light, style, channels)

    def draw_scene(self, objects: Iterable[Object], camera: Camera = Camera(),
                   light: Light = Light(), style: Style = Style(),
                   channels: Iterable[str] = (), camera_before: Camera | None = None) -> Frame:
        """
        Draw a list of objects.

        channels: what the Frame holds beside the colour, a list of names: depth, normals, labels,
        texture_coordinates, flow or visibility. camera_before: of the frame before, for the flow;
        None: it stood still. Raises ValueError for what is of another class, for other names, and
        for a list without triangles.
        """
        checks.instance('camera', camera, Camera)
        checks.instance('light', light, Light)
        checks.instance('style', style, Style)
        channels = channel_names(channels)
        if camera_before is not None:
            checks.instance('camera_before', camera_before, Camera)
        checks.require(isinstance(objects, Iterable), 'objects', 'a list of Object', objects)
        objects = [checks.instance('each of objects', one, Object) for one in objects]
        with self._pool:
            self._pool.wake()
            if self._scene is None or not self._scene.fits(objects):
                self._scene = SceneBuffers(objects)
            geometry = self._scene.geometry(view_transform(camera))
            self._shaded.begin(objects, self._scene, light, style)
            colours = self._project_and_shade(objects, geometry, camera, light, style)
            order = self._cull(geometry, camera, style)
            surfaces = self._shaded.surfaces(self._scene, colours, camera, light, style)
            if surfaces is not None:
                self._by_triangles(lambda *some: set_surfaces(
                    geometry, surfaces, *self._shaded.fields, *some))
            self._rasterize(geometry, colours, order, (camera, style), channels, surfaces)
            if needs_faces(channels):
                self._resolve(geometry, *attributes_of(objects, self._scene, channels, camera,
                                                       camera_before or camera))
        return self._framebuffer.frame(self._scene)

    def _project_and_shade(self, objects, geometry, camera, light, style):
        """Take the vertices to the screen; return the Colours of vertices or triangles."""
        scene, is_flat = self._scene, style.shading == 'flat'
        shape = len(scene.triangles if is_flat else scene.positions), 2, 3
        if self._colours is None or self._colours.shape != shape:
            self._colours = np.zeros(shape)  # of what is shaded by pixels they stay so
        colours = self._colours
        shaded = self._shaded
        view = camera, light, is_flat, shaded.key
        changed = scene.begin_frame(objects, view)
        chunks = iter(changed)

        def work(thread):
            for chunk in chunks:
                scene.load(chunk)
                project(chunk.positions, geometry.transform, chunk.projected)
                if not is_flat:
                    shaded.shade((chunk.index, chunk.vertices), chunk.positions, chunk.normals,
                                 camera.viewpoint, light, colours)

        self._run(len(changed), work)
        scene.end_frame(objects, view)
        if is_flat:
            normals = face_normals(scene.positions, scene.triangles)
            centres = scene.positions[scene.triangles].mean(axis=1)
            for k, (_, own) in enumerate(scene.slices):
                shaded.shade((k, own), centres[own], normals[own], camera.viewpoint, light,
                             colours)
        return Colours(colours, is_flat)

    def _cull(self, geometry, camera, style):
        """Return the DrawOrder, in which rows are found."""
        order = self._scene.order
        if style.hidden_surface == 'painter':
            order = order._replace(
                indices=far_to_near(geometry.triangles, geometry.vertices.view_space))
        # Lines lie in whole pixels, and samples beside the pixels' centres.
        viewport = Viewport(camera.width, camera.height,
                            SUBPIXELS if style.outline or style.samples > 1 else 0)
        chunks = order.boxes.shape[1]
        # To call the kernel takes as long as some hundred triangles.
        step = CHUNKS_AT_ONCE if self._pool.threads > 1 else chunks
        starts = iter(range(0, chunks, step))

        def work(thread):
            for first in starts:
                cull(geometry, order, viewport, first, min(first + step, chunks))

        self._run(-(-chunks // step), work)
        return order

    def _run(self, pieces, work):
        """Call work(thread) in all threads, or in this one alone for few pieces of work."""
        if pieces > WORTH_SHARING:
            self._pool.parallel_for(work)
        else:
            work(0)

    def _rasterize(self, geometry, colours, order, look, channels, surfaces):
        """Draw all bands; buffers are made anew where they do not fit the camera or the style."""
        camera, style = look
        key = camera.width, camera.height, style.clear_colour
        if self._framebuffer is None or self._framebuffer.key != key:
            self._framebuffer = Framebuffer(camera.width, camera.height,
                                            -(-camera.height // BAND), style.clear_colour)
        images = self._framebuffer.images(channels)
        settings = _render_settings(camera, style)
        is_shaded = surfaces is not None
        has_faces = is_shaded or images.faces.size > 0
        shape = camera.width, len(geometry.triangles), style.samples > 1, has_faces, is_shaded
        if any(known != shape for known, _ in self._buffers.values()):
            self._buffers = {}
        taken = np.zeros(1, np.int64)
        rare = Rare(surfaces) if style.outline or has_faces else None

        def work(thread):
            if thread not in self._buffers:
                self._buffers[thread] = shape, new_buffers(*shape)
            draw_bands(taken, geometry, colours, order, settings, self._buffers[thread][1],
                       images, rare)

        self._pool.parallel_for(work)

    def _by_triangles(self, set_some):
        """Call set_some(first, end) for all triangles, in all threads if they are many."""
        count = len(self._scene.triangles)
        step = CHUNKS_AT_ONCE * CHUNK if self._pool.threads > 1 else count
        starts = iter(range(0, count, step))

        def work(thread):
            for first in starts:
                set_some(first, min(first + step, count))

        self._run(-(-count // step), work)

    def _resolve(self, geometry, attributes, values):
        """Write the channels that are made from what each pixel sees."""
        if attributes.planes.size:
            self._by_triangles(lambda *some: set_planes(geometry, values, *some,
                                                        attributes.planes))
        if attributes.weights.size:
            set_weight_planes(geometry, attributes.weights)
        dirty, seen, pixels, images, visibility = self._framebuffer.to_resolve()
        taken = np.zeros(1, np.int64)
        self._pool.parallel_for(lambda thread: resolve(
            taken, (dirty, seen), pixels, attributes, images, visibility, new_values()))


@functools.lru_cache(maxsize=8)
def _render_settings(camera, style):
    """Return a camera's and a style's RenderSettings."""
    is_painter = style.hidden_surface == 'painter'
    # In orthographic projection what is linear in space is linear on the screen.
    is_perspective_correct = style.interpolation == 'perspective' and camera.is_perspective
    return RenderSettings(
        RasterizerState(np.int32(0), np.int32(0), np.float32(-np.inf if is_painter else np.inf),
                        style.outline, is_perspective_correct),
        np.int32(PATTERNS[style.samples] * SUBPIXELS), style.clear_colour,
        clear_depth(camera.is_perspective), camera.width, camera.height,
        style.sky_gradient)
