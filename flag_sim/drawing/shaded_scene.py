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
from flag_sim.drawing.flat_tiles import starts_of_tiles
from flag_sim.drawing.shading import light_levels, shade
from flag_sim.drawing.shadow_map import ShadowMap
from flag_sim.drawing.shadows import NO_SHADOWS
from flag_sim.drawing.sky import sky_of
from flag_sim.drawing.surfaces import FACE_FIELDS, FIELDS, Surfaces
from flag_sim.drawing.texture import ENCODE

import numpy as np


class ShadedScene:
    """
    Light, textures and shadows of a scene's vertices, where pixels are shaded one by one.

    run: see ShadowMap.

    key: what else than objects, camera and light its light depends on; None where nothing is
    shaded pixel by pixel.
    """

    def __init__(self, run):
        """Begin with nothing."""
        self._shadow_map = ShadowMap(run)
        self.key = None
        self._has_shadows = False
        self._objects = []
        self._levels = None  # see light_levels
        self._textures, self._texels = [], None
        self._known = self._joined = self.fields = None

    def begin(self, objects, scene, light, style):
        """Begin a frame of `objects`, joined in a SceneBuffers."""
        self._objects = objects
        self.key = None
        self._has_shadows = style.shadows and light.sunlight > 0.0
        self._is_shaded = [self._has_shadows or one.texture is not None for one in objects]
        if not any(self._is_shaded) and not style.sky_gradient:
            return
        shape = len(scene.triangles if style.shading == 'flat' else scene.positions), 2, 3
        if self._levels is None or self._levels[0].shape != shape:
            self._levels = np.zeros(shape), np.zeros(shape)
        self.key = shape, tuple(self._is_shaded)

    def shade(self, part, points, normals, viewpoint, light, colours):
        """
        Light points of an object: see shading.shade, or light_levels if it is shaded by pixels.

        part: the object's index, and the points' slice of colours.
        """
        index, own = part
        one = self._objects[index]
        if self.key is None or not self._is_shaded[index]:
            shade(points, normals, viewpoint, one.surface, light, colours[own])
        else:
            light_levels(points, normals, viewpoint, one.surface, light,
                         tuple(levels[own] for levels in self._levels))

    def surfaces(self, scene, colours, camera, light, style):
        """Return the frame's Surfaces, or None; colours: any Colours for the scene."""
        if self.key is None:
            return None
        if not self._fits(scene):
            self._join(scene)
        tints = np.array([one.surface.color for one in self._objects], np.float32).T.copy()
        (first_levels, *of_textures), object_of, coordinates = self._joined
        textures = [one.texture is not None for one in self._objects]
        return _read_only(Surfaces(
            tints, first_levels, *of_textures, object_of, coordinates,
            *self._levels, light.ambient, ENCODE, style.shading == 'flat',
            style.interpolation == 'screen', any(textures),
            any(is_shaded and not has_texture
                for is_shaded, has_texture in zip(self._is_shaded, textures)),
            any(one.surface.specular > 0.0 for one in self._objects), *self.fields,
            self._shadows(scene, colours, camera, light), sky_of(camera, style)))

    def _fits(self, scene):
        """Whether what is joined of the objects is as it was."""
        known, self._known = self._known, (scene, self._is_shaded, self._objects)
        if known is None or known[0] is not scene or known[1] != self._is_shaded:
            return False
        return all(
            one.texture is last.texture and (
                one.texture is None or (one.texture_coordinates is last.texture_coordinates
                                        and not one.texture_coordinates.flags.writeable))
            for one, last in zip(self._objects, known[2]))

    def _join(self, scene):
        """Join what the objects have of textures, and make memory for the planes of triangles."""
        count = len(scene.triangles)
        self.fields = (np.empty((FIELDS, count), np.float32),
                       np.empty((FACE_FIELDS, 2 * count), np.float32))
        object_of = np.full(count, -1, np.int32)
        coordinates = np.zeros((len(scene.positions), 2))
        for k, (one, (vertices, triangles)) in enumerate(zip(self._objects, scene.slices)):
            if self._is_shaded[k]:
                object_of[triangles] = k
            if one.texture is not None:
                coordinates[vertices] = one.texture_coordinates
        textures = [one.texture for one in self._objects]
        if len(textures) != len(self._textures) or any(
                one is not last for one, last in zip(textures, self._textures)):
            self._textures, self._texels = textures, _joined(textures)
        self._joined = self._texels, object_of, coordinates

    def _shadows(self, scene, colours, camera, light):
        if not self._has_shadows:
            return NO_SHADOWS
        return self._shadow_map.draw(self._objects, scene, colours, camera, light)


def _read_only(record):
    """Return a record with arrays that are read-only, as some are: one type, so one kernel."""
    fields = []
    for field in record:
        if isinstance(field, np.ndarray) and field.flags.writeable:
            field = field.view()
            field.flags.writeable = False
        is_record = isinstance(field, tuple) and hasattr(field, '_fields')
        fields.append(_read_only(field) if is_record else field)
    return type(record)(*fields)


def _joined(textures):
    """Return the textures, levels, texels, starts, flats and flat_starts of Surfaces."""
    places, levels, texels, flats, starts = [], [], [], [], []
    count = start = flat_start = 0
    for texture in textures:
        if texture is None:
            places.append((0, 0, 0, 0))
            continue
        places.append((count, len(texture.levels), flat_start, flat_start + len(texture.flats)))
        levels.append(texture.levels + [start, 0, 0])
        texels.append(texture.texels)
        flats.append(texture.flats)
        starts.append(starts_of_tiles(texture.levels))
        count += len(texture.levels)
        start += len(texture.texels) // 2
        flat_start += len(texture.flats)
    if not texels:
        return (np.array(places), np.zeros((1, 3), np.int64), np.zeros(1, np.uint32),
                np.zeros(1, np.int32), np.zeros(1, np.uint32), np.zeros(1, np.int32))
    # One alone, as most often, is not copied.
    texels, flats = (some[0] if len(some) == 1 else np.concatenate(some)
                     for some in (texels, flats))
    levels = np.concatenate(levels)
    return (np.array(places), levels, texels, np.ascontiguousarray(levels[:, 0], np.int32), flats,
            np.concatenate(starts))
