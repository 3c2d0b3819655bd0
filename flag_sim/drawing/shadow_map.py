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

"""The shadow map of a scene, which is kept from frame to frame."""
from flag_sim.drawing.culling import cull, new_order, Viewport
from flag_sim.drawing.depth import clear_depth
from flag_sim.drawing.depth_bands import draw_depth_bands, new_depth_buffers
from flag_sim.drawing.geometry import Geometry, new_vertices, part_of, project
from flag_sim.drawing.pixels import BAND
from flag_sim.drawing.shadows import NO_SHADOWS, Shadows, shadows_of, sun_view

import numpy as np


class ShadowMap:
    """
    Draws what the sun sees of a scene, from its vertices as they are in its SceneBuffers.

    run: calls work(thread) for pieces of work, in all threads where that is worth it: see
    Picture. Only what this frame or the last one drew into is cleared.
    """

    def __init__(self, run):
        """Begin without a map: the scene says how large it is."""
        self._run = run
        self._key = self._scene = self._depth = self._dirty = None
        self._buffers = {}

    def draw(self, objects, scene, colours, camera, light) -> Shadows:
        """
        Return the Shadows of objects that are joined in a scene, as a camera sees them.

        colours: any Colours for the scene's triangles.
        """
        self._fit(objects, scene)
        view = sun_view(scene.positions, self._is_casting, camera, light)
        if view is None:
            return NO_SHADOWS
        pieces = iter(self._pieces)

        def work(thread):
            for positions, vertices in pieces:
                project(positions, view.transform, vertices)

        self._run(len(self._pieces), work)
        geometry = Geometry(scene.triangles, scene.is_closed, self._sizes, self._vertices,
                            view.transform)
        cull(geometry, self._order, Viewport(view.width, view.height, 0), 0,
             self._order.boxes.shape[1])
        self._draw(geometry, colours, view)
        return shadows_of(self._depth, view, camera, self._vertices.view_space, scene.triangles)

    def _fit(self, objects, scene):
        """Make anew what does not fit the objects."""
        casts_shadow = [one.casts_shadow for one in objects]
        if scene is self._scene and casts_shadow == self._key:
            return
        self._scene, self._key, self._buffers = scene, casts_shadow, {}
        self._is_casting = np.empty(len(scene.positions), np.bool_)
        casting = []
        for is_casting, (vertices, triangles) in zip(casts_shadow, scene.slices):
            self._is_casting[vertices] = is_casting
            if is_casting:
                casting.append(np.arange(triangles.start, triangles.stop, dtype=np.int32))
        self._order = new_order(np.concatenate([np.empty(0, np.int32), *casting]))
        self._sizes = np.empty(len(scene.triangles), np.uint8)
        self._vertices = new_vertices(len(scene.positions))
        self._pieces = [(chunk.positions, part_of(self._vertices, chunk.vertices))
                        for chunks in scene.chunks for chunk in chunks]

    def _draw(self, geometry, colours, view):
        """Draw all bands of the map."""
        shape, nothing = (view.height, view.width), clear_depth(False)
        if self._depth is None or self._depth.shape != shape:
            self._depth = np.full(shape, nothing)
            self._dirty = np.zeros((2, -(-view.height // BAND)), np.int32)
            self._buffers = {}
        taken = np.zeros(1, np.int64)

        def work(thread):
            if thread not in self._buffers:
                self._buffers[thread] = new_depth_buffers(view.width, len(self._order.indices))
            draw_depth_bands(taken, geometry, colours, self._order, nothing,
                             self._buffers[thread], self._depth, self._dirty)

        self._run(self._dirty.shape[1], work)
