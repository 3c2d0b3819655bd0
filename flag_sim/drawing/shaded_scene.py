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

"""The scene's part of pixels that are shaded one by one (see surfaces), kept between frames."""
from flag_sim.drawing.shading import light_levels, shade
from flag_sim.drawing.surfaces import Surfaces
from flag_sim.drawing.texture import ENCODE, TEXEL

import numpy as np


class ShadedScene:
    """
    Light, textures and coordinates of a scene's vertices, where some object has a texture.

    key: what else than objects, camera and light its light depends on; None where nothing is
    shaded pixel by pixel.
    """

    def __init__(self):
        """Begin with nothing."""
        self.key = None
        self._objects = []
        self._levels = None  # see light_levels
        self._textures, self._joined = [], None

    def begin(self, objects, scene, style):
        """Begin a frame of `objects`, joined in a SceneBuffers."""
        self._objects = objects
        self.key = None
        if all(one.texture is None for one in objects):
            return
        shape = len(scene.triangles if style.shading == 'flat' else scene.positions), 2, 3
        if self._levels is None or self._levels[0].shape != shape:
            self._levels = np.zeros(shape), np.zeros(shape)
        self.key = shape, tuple(one.texture is not None for one in objects)

    def shade(self, part, points, normals, viewpoint, light, colours):
        """
        Light points of an object: see shading.shade.

        part: the object's index, and the points' slice of colours.
        """
        index, own = part
        one = self._objects[index]
        shade(points, normals, viewpoint, one.surface, light, colours[own])
        if self.key is not None and one.texture is not None:
            light_levels(points, normals, viewpoint, one.surface, light,
                         tuple(levels[own] for levels in self._levels))

    def surfaces(self, scene, light, style):
        """Return the frame's Surfaces, or None."""
        if self.key is None:
            return None
        textures = [one.texture for one in self._objects]
        if len(textures) != len(self._textures) or any(
                one is not last for one, last in zip(textures, self._textures)):
            self._textures, self._joined = textures, _joined(textures)
        first_levels, levels, texels = self._joined
        texture_of = np.full(len(scene.triangles), -1, np.int32)
        coordinates = np.zeros((len(scene.positions), 2))
        for k, (one, (vertices, triangles)) in enumerate(zip(self._objects, scene.slices)):
            if one.texture is not None:
                texture_of[triangles], coordinates[vertices] = k, one.texture_coordinates
        return Surfaces(first_levels, levels, texels, texture_of, coordinates, *self._levels,
                        light.ambient, ENCODE, style.shading == 'flat',
                        style.interpolation == 'screen')


def _joined(textures):
    """Return of each texture the first mipmap and their number, and all levels and texels."""
    places, levels, texels, count, start = [], [], [], 0, 0
    for texture in textures:
        if texture is None:
            places.append((0, 0))
            continue
        places.append((count, len(texture.levels)))
        levels.append(texture.levels + [start, 0, 0])
        texels.append(texture.texels)
        count += len(texture.levels)
        start += len(texture.texels) // TEXEL
    # One alone, as most often, is not copied.
    return (np.array(places), np.concatenate(levels),
            texels[0] if len(texels) == 1 else np.concatenate(texels))
