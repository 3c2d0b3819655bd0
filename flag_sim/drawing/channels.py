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
Channels: what the camera knows of each pixel beside its colour, for those who learn from it.

All tell of what a pixel's centre sees, also where a style's samples average the colour: the
average of two labels, normals or motions is that of nothing in the scene.
"""
from collections.abc import Iterable
import math
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.geometry import new_vertices, project, view_transform
from flag_sim.drawing.planes import VALUES
from flag_sim.jit.kernels import late_kernel
from flag_sim.parameters import checks

import numpy as np

# What a frame can hold beside the colour: of the pixels' faces themselves, ...
DRAWN = ('depth', 'visibility')
# ... and of what these have: (values a pixel, type, what pixels hold where nothing is).
RESOLVED = {
    'normals': (3, np.float32, 0.0),
    'labels': (1, np.uint8, 0),
    'texture_coordinates': (2, np.float32, np.nan),
    'flow': (2, np.float32, np.nan),
}


def channel_names(channels: Iterable) -> tuple:
    """Return the names of channels as a tuple; raises ValueError for others."""
    is_list = isinstance(channels, Iterable) and not isinstance(channels, (str, bytes))
    checks.require(is_list, 'channels', 'a list of names', channels)
    return tuple(checks.choice('each of channels', name, (*DRAWN, *RESOLVED))
                 for name in channels)


def needs_faces(names: Iterable) -> bool:
    """Return whether channels are made from the faces that pixels see."""
    return 'visibility' in names or not RESOLVED.keys().isdisjoint(names)


class Resolved(NamedTuple):
    """
    The images of RESOLVED, for the kernels; of size 0 where they are not wanted.

    normals: (height, width, 3) float32; labels: (height, width, 1) uint8; texture_coordinates,
    flow: (height, width, 2) float32.
    """

    normals: np.ndarray
    labels: np.ndarray
    texture_coordinates: np.ndarray
    flow: np.ndarray


def renewed(images: Resolved | None, names: Iterable, height: int, width: int) -> Resolved:
    """Return images for some of RESOLVED: those that there are, or new ones that see nothing."""
    made = {}
    for name, (count, kind, nothing) in RESOLVED.items():
        if name not in names:
            made[name] = np.empty((0, 0, count), kind)
        elif images is None or not getattr(images, name).size:
            made[name] = np.full((height, width, count), nothing, kind)
        else:
            made[name] = getattr(images, name)
    return Resolved(**made)


# Of planes.VALUES: unit normals in the optical frame; texture coordinates; how much each vertex
# was elsewhere in the frame before, in the space of geometry.Vertices, or where it was if only one
# of the frames has perspective.
NORMAL, COORDINATE, MOTION = 0, 3, 5


class Attributes(NamedTuple):
    """
    What the triangles of a scene have, for the kernels; of size 0 where it is not wanted.

    planes: see planes.set_planes; labels: (m,) int32; ranges: (2, 2), of both texture coordinates
    the least and the most of all vertices; shift: how far the principal point has moved since the
    frame before [pixel]; weights: see planes.set_weight_planes; centre: the principal point, (u,
    v); is_perspective, was_perspective: in this frame and in the one before.
    """

    planes: np.ndarray
    labels: np.ndarray
    ranges: np.ndarray
    shift: tuple
    weights: np.ndarray
    centre: tuple
    is_perspective: bool
    was_perspective: bool


def attributes_of(objects: Iterable, scene, names: Iterable, camera: Camera,
                  camera_before: Camera) -> tuple[Attributes, np.ndarray]:
    """
    Return the Attributes that some of RESOLVED need, of a scene that is projected.

    objects: of the scene; scene: their SceneBuffers; names: of channels; camera, camera_before: of
    this frame and of the one before. The planes are yet to be set: also returns the values for
    them at the vertices, (VALUES, n).
    """
    points, count = len(scene.positions), len(scene.triangles)
    has_planes = not {'normals', 'texture_coordinates', 'flow'}.isdisjoint(names)
    # Kept, for new memory takes as long as a third of the work.
    values, planes = scene.kept('planes', [], lambda: (
        np.zeros((VALUES, points)), np.empty(3 * VALUES * count, np.float32)))
    labels, ranges = np.empty(0, np.int32), np.zeros((2, 2), np.float32)
    if 'normals' in names:
        _turn(scene.normals, camera.pose, values[NORMAL:NORMAL + 3])
    if 'labels' in names:
        labels = np.repeat(np.array([one.label for one in objects], np.int32),
                           [len(one.triangles) for one in objects])
    if 'texture_coordinates' in names:
        parts = [one.texture_coordinates for one in objects]
        values[COORDINATE:COORDINATE + 2], ranges = scene.kept('texture_coordinates', parts, (
            lambda: _with_ranges(joined(parts, objects, 2))))
    was_perspective = camera_before.is_perspective
    if 'flow' in names:
        then = new_vertices(points)
        project(np.concatenate([
            np.full((len(one.vertices), 3), np.nan) if one.before is None else one.before
            for one in objects], dtype=np.float64), view_transform(camera_before), then)
        values[MOTION:MOTION + 3] = then.view_space.T
        if was_perspective == camera.is_perspective:
            # What stands still has 0 exactly.
            values[MOTION:MOTION + 3] -= scene.projected.view_space.T
    shift = tuple(float(then - now) for then, now in zip(camera_before.centre, camera.centre))
    return Attributes(
        planes[:planes.size * has_planes], labels, ranges, shift,
        np.empty((6 if 'visibility' in names else 0, count)), tuple(map(float, camera.centre)),
        camera.is_perspective, was_perspective), values


def _with_ranges(values):
    """Return values (k, n), and of each the least and the most that is finite: (k, 2) float32."""
    return values, np.array([[_extreme(np.fmin, row), _extreme(np.fmax, row)] for row in values],
                            np.float32)


def joined(parts: list, objects: Iterable, count: int) -> np.ndarray:
    """Return values of the vertices of all objects, (count, n); nan for those that have none."""
    return np.concatenate([
        np.full((count, len(one.vertices)), np.nan) if part is None else part.T
        for part, one in zip(parts, objects)], axis=1, dtype=np.float64)


def _extreme(function, values):
    """Return what np.fmin or np.fmax, for which nan is nothing, makes of finite values."""
    return function.reduce(np.where(np.isinf(values), np.nan, values))


@late_kernel
def _turn(normals, pose, turned):
    """Bring normals (n, 3) of any length to length 1, in the optical frame (3, n); 0 for none."""
    for i in range(np.uint64(normals.shape[0])):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        length = math.sqrt(x * x + y * y + z * z)
        scale = 1.0 / length if 0.0 < length < math.inf else 0.0
        for axis in range(3):
            turned[axis, i] = scale * (
                pose[axis, 0] * x + pose[axis, 1] * y + pose[axis, 2] * z) if scale > 0.0 else 0.0
