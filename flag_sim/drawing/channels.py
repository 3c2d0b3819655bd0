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
from flag_sim.drawing.pixels import BAND, clamp
from flag_sim.drawing.visibility import weights_of
from flag_sim.jit.kernels import late_kernel
from flag_sim.parallel.atomics import fetch_add
from flag_sim.parameters import checks

import numpy as np

# What a frame can hold beside the colour: made while triangles are drawn, ...
DRAWN = ('depth', 'visibility')
# ... and made from the visibility: (values a pixel, type, what pixels hold where nothing is).
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


class Sight(NamedTuple):
    """
    Where vertices are in a frame, for its flow.

    view_space: (n, 3), see geometry.Vertices, nan where that is not known; centre_u, centre_v:
    the principal point [pixel]; is_perspective: whether x and y are divided by the depth.
    """

    view_space: np.ndarray
    centre_u: float
    centre_v: float
    is_perspective: bool


class Attributes(NamedTuple):
    """
    What the vertices and triangles of a scene have, for the kernels.

    normals: (n, 3) unit normals out of the front in the optical frame, 0 where there is none;
    labels: (m,) uint8; texture_coordinates: (n, 2), nan where there are none; now, before: Sight
    of this frame and of the one before. Of size 0 where they are not wanted.
    """

    normals: np.ndarray
    labels: np.ndarray
    texture_coordinates: np.ndarray
    now: Sight
    before: Sight


def attributes_of(objects: Iterable, scene, names: Iterable, camera: Camera,
                  camera_before: Camera) -> Attributes:
    """
    Return the Attributes that some of RESOLVED need, of a scene that is projected.

    objects: of the scene; scene: their SceneBuffers; camera, camera_before: of this frame and of
    the one before.
    """
    unit_normals, labels, coordinates = np.empty((0, 3)), np.empty(0, np.uint8), np.empty((0, 2))
    points = len(scene.positions)
    if 'normals' in names:
        unit_normals = np.empty((points, 3))
        _turn(scene.normals, camera.pose, unit_normals)
    if 'labels' in names:
        labels = np.repeat(np.array([one.label for one in objects], np.uint8),
                           [len(one.triangles) for one in objects])
    if 'texture_coordinates' in names:
        coordinates = joined([one.texture_coordinates for one in objects], objects, 2)
    now = before = Sight(scene.projected.view_space, *camera.centre, camera.is_perspective)
    if 'flow' in names:
        then = new_vertices(points)
        project(joined([one.before for one in objects], objects, 3),
                view_transform(camera_before), then)
        before = Sight(then.view_space, *camera_before.centre, camera_before.is_perspective)
    return Attributes(unit_normals, labels, coordinates, now, before)


def joined(parts: list, objects: Iterable, count: int) -> np.ndarray:
    """Return values of the vertices of all objects, (n, count); nan for those that have none."""
    return np.concatenate([
        np.full((len(one.vertices), count), np.nan) if part is None else part
        for part, one in zip(parts, objects)], dtype=np.float64)


@late_kernel
def _turn(normals, pose, turned):
    """Bring normals (n, 3) of any length to length 1, in the optical frame; 0 where none is."""
    for i in range(normals.shape[0]):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        length = math.sqrt(x * x + y * y + z * z)
        scale = 1.0 / length if 0.0 < length < math.inf else 0.0
        for axis in range(3):
            turned[i, axis] = scale * (
                pose[axis, 0] * x + pose[axis, 1] * y + pose[axis, 2] * z) if scale > 0.0 else 0.0


@late_kernel
def resolve(taken, columns, visibility, corners, attributes, images):
    """
    Write the channels of bands of an image as long as there are any.

    taken: (1,) int64, how many bands were taken by this and other threads; columns: (2, bands),
    the first column and the end of what has changed in each band; visibility: triangles, is_back
    and weights of a Visibility, corners: its triangles' vertices; images: Resolved.
    """
    while True:
        band = fetch_add(taken, 0, 1)
        if band >= columns.shape[1]:
            break
        area = (band * BAND, min((band + 1) * BAND, visibility[0].shape[0]),
                columns[0, band], columns[1, band])
        if images.normals.size > 0:
            _write_normals(area, visibility, corners, attributes.normals, images.normals)
        if images.labels.size > 0:
            _write_labels(area, visibility[0], attributes.labels, images.labels)
        if images.texture_coordinates.size > 0:
            _write_linear(area, visibility, corners, attributes.texture_coordinates,
                          images.texture_coordinates)
        if images.flow.size > 0:
            _write_flow(area, visibility, corners, attributes, images.flow)


@late_kernel
def _write_normals(area, visibility, corners, normals, image):
    """Write unit normals on the side that is seen, as Gouraud shading has them (eq. 1.13)."""
    top, end, left, right = area
    triangles, is_back, weights = visibility
    for row in range(top, end):
        for column in range(left, right):
            t = triangles[row, column]
            if t < 0:
                image[row, column] = 0.0
                continue
            a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
            of_a, of_b, of_c = weights_of(weights, row, column)
            x = of_a * normals[a, 0] + of_b * normals[b, 0] + of_c * normals[c, 0]
            y = of_a * normals[a, 1] + of_b * normals[b, 1] + of_c * normals[c, 1]
            z = of_a * normals[a, 2] + of_b * normals[b, 2] + of_c * normals[c, 2]
            length = math.sqrt(x * x + y * y + z * z)
            side = -1.0 if is_back[row, column] else 1.0
            scale = side / length if length > 0.0 else 0.0
            image[row, column, 0] = scale * x
            image[row, column, 1] = scale * y
            image[row, column, 2] = scale * z


@late_kernel
def _write_labels(area, triangles, labels, image):
    top, end, left, right = area
    for row in range(top, end):
        for column in range(left, right):
            t = triangles[row, column]
            image[row, column, 0] = labels[t] if t >= 0 else 0


@late_kernel
def _write_linear(area, visibility, corners, values, image):
    """Write two values, linear in space and within the range of the triangle's vertices."""
    top, end, left, right = area
    triangles, _, weights = visibility
    for row in range(top, end):
        for column in range(left, right):
            t = triangles[row, column]
            if t < 0:
                image[row, column] = np.nan
                continue
            a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
            of_a, of_b, of_c = weights_of(weights, row, column)
            for k in range(2):
                at_a, at_b, at_c = values[a, k], values[b, k], values[c, k]
                value = of_a * at_a + of_b * at_b + of_c * at_c
                least, most = min(at_a, at_b, at_c), max(at_a, at_b, at_c)
                image[row, column, k] = clamp(value, least, most)


@late_kernel
def _write_flow(area, visibility, corners, attributes, image):
    """
    Write where the point that a pixel sees was in the frame before, minus where it is [pixel].

    Both places are those of the same point of the surface, so what stands still has 0 exactly.
    """
    top, end, left, right = area
    triangles, _, weights = visibility
    now, before = attributes.now, attributes.before
    for row in range(top, end):
        for column in range(left, right):
            t = triangles[row, column]
            if t < 0:
                image[row, column] = np.nan
                continue
            of_vertices = weights_of(weights, row, column)
            u, v = on_screen(now, corners, t, of_vertices)
            last_u, last_v = on_screen(before, corners, t, of_vertices)
            image[row, column, 0], image[row, column, 1] = last_u - u, last_v - v


@late_kernel
def on_screen(sight, corners, t, of_vertices):
    """Return the place on the screen of a point of triangle t; nan behind the eye."""
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
    of_a, of_b, of_c = of_vertices
    points = sight.view_space
    x = of_a * points[a, 0] + of_b * points[b, 0] + of_c * points[c, 0]
    y = of_a * points[a, 1] + of_b * points[b, 1] + of_c * points[c, 1]
    z = of_a * points[a, 2] + of_b * points[b, 2] + of_c * points[c, 2]
    if sight.is_perspective:
        if not z > 0.0:
            return np.nan, np.nan
        return sight.centre_u + x / z, sight.centre_v + y / z
    return sight.centre_u + x, sight.centre_v + y
