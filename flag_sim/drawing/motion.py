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
Motion: where what each pixel sees is in another frame, and whether the camera sees it there.

The surface moves, not the light on it: shadows and highlights have no part in this.
"""
from collections.abc import Iterable
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.channels import joined
from flag_sim.drawing.covering import binned, is_covered, set_planes, Sight
from flag_sim.drawing.geometry import new_vertices, project, view_transform
from flag_sim.drawing.scene import Object
from flag_sim.drawing.visibility import Visibility, weights_of
from flag_sim.jit.kernels import late_inner_kernel, late_kernel
from flag_sim.parameters import checks

import numpy as np

NEARER = 1e-6
"""By which part of its depth a surface must be nearer than a point to hide it."""


class Motion(NamedTuple):
    """
    What became of the point that a pixel's centre sees in the other frame.

    flow: (height, width, 2) float32, where it is there, minus where it is here [pixel]; nan where
    nothing is, where that is not known, and behind the eye. is_hidden: (height, width) bool,
    whether the other frame does not show it there: it is beyond the image or the near plane, or
    something stands before it; False where nothing is, and where that is not known.
    """

    flow: np.ndarray
    is_hidden: np.ndarray


def motion(visibility: Visibility, objects: Iterable[Object], camera: Camera,
           other: Camera) -> Motion:
    """
    Return the Motion from a frame to another one, before or after it.

    visibility: of the frame (the channel); objects: it was drawn of, whose `before` is where their
    vertices are in the other frame; camera, other: of both frames. What is hidden is found in the
    triangles themselves, at the very point, and not in the pixels of the other frame; a surface
    hides what is farther by NEARER of its depth. Raises ValueError for what is of another class,
    and for objects that the frame was not drawn of.
    """
    now, then = _sights(visibility, objects, camera, other)
    planes = np.empty((len(visibility.corners), 4, 3))
    set_planes(now, visibility.corners, planes)
    flow = np.empty((*visibility.triangles.shape, 2), np.float32)
    _follow(visibility.triangles, visibility.corners, (now, planes), then, flow)
    return Motion(flow, _hidden(visibility, then, other))


def hidden(visibility: Visibility, objects: Iterable[Object], camera: Camera,
           other: Camera) -> np.ndarray:
    """Return the `is_hidden` of `motion` alone, in less time."""
    return _hidden(visibility, _sights(visibility, objects, camera, other)[1], other)


def _sights(visibility, objects, camera, other):
    """Return the Sights of the frame and of the other one; raise ValueError as `motion` does."""
    checks.instance('visibility', visibility, Visibility)
    checks.instance('camera', camera, Camera)
    checks.instance('other', other, Camera)
    objects = [checks.instance('each of objects', one, Object) for one in objects]
    now = _sight(np.concatenate([one.vertices for one in objects]), camera)
    checks.require(len(now.view_space) == len(visibility.depths), 'objects',
                   f'of the {len(visibility.depths)} vertices of the frame', len(now.view_space))
    return now, _sight(joined([one.before for one in objects], objects, 3).T, other)


def _sight(points, camera):
    vertices = new_vertices(len(points))
    project(np.ascontiguousarray(points, np.float64), view_transform(camera), vertices)
    return Sight(vertices.view_space, *map(float, camera.centre), camera.is_perspective)


def _hidden(visibility, then, other):
    found = np.zeros(visibility.triangles.shape, np.bool_)
    _hide((visibility.triangles, visibility.weights, visibility.corners), then,
          binned(then, visibility.corners, other),
          (float(other.width), float(other.height), other.near), found)
    return found


@late_kernel
def _follow(triangles, corners, here, then, flow):
    """
    Write the flow of every pixel, nan where nothing is.

    triangles, corners: of a Visibility; here: the Sight of the frame, and the planes of its
    triangles.
    """
    now, planes = here
    for row in range(triangles.shape[0]):
        for column in range(triangles.shape[1]):
            t = triangles[row, column]
            if t < 0:
                flow[row, column, 0] = flow[row, column, 1] = np.nan
                continue
            # The flow is that of where the centre's line of sight meets the triangle's plane. What
            # is drawn was snapped to parts of a pixel, so that may be a little outside of it.
            at = _weights_at(planes[t], column - now.centre_u, row - now.centre_v)
            then_u, then_v = _on_screen(then, corners, t, at)
            flow[row, column, 0] = then_u - column
            flow[row, column, 1] = then_v - row


@late_kernel
def _hide(seen, then, bins, image, found):
    """
    Write whether the point of a pixel that sees something is hidden in the other frame.

    It is what is nearest on the triangle to where the pixel's line of sight meets its plane. seen:
    triangles, weights and corners of a Visibility; image: width and height [pixel] and near plane
    [m] of the other frame.
    """
    triangles, weights, corners = seen
    width, height, near = image
    for row in range(triangles.shape[0]):
        for column in range(triangles.shape[1]):
            t = triangles[row, column]
            if t < 0:
                continue
            of_vertices = weights_of(weights, row, column)
            then_u, then_v = _on_screen(then, corners, t, of_vertices)
            z = _depth(then, corners, t, of_vertices)
            if not z == z:  # the place in the other frame is not known
                continue
            found[row, column] = not (
                z > near and -0.5 <= then_u < width - 0.5 and -0.5 <= then_v < height - 0.5
            ) or is_covered(then, bins, t, (then_u, then_v, z - NEARER * abs(z)), near)


@late_inner_kernel
def _weights_at(plane, x, y):
    """Return the weights of a triangle's vertices where a line of sight meets its plane."""
    of_a = plane[0, 0] * x + plane[0, 1] * y + plane[0, 2]
    of_b = plane[1, 0] * x + plane[1, 1] * y + plane[1, 2]
    of_c = plane[2, 0] * x + plane[2, 1] * y + plane[2, 2]
    total = of_a + of_b + of_c
    return of_a / total, of_b / total, of_c / total


@late_inner_kernel
def _depth(sight, corners, t, of_vertices):
    """Return the depth of a point of triangle t."""
    of_a, of_b, of_c = of_vertices
    z = sight.view_space
    return of_a * z[corners[t, 0], 2] + of_b * z[corners[t, 1], 2] + of_c * z[corners[t, 2], 2]


@late_kernel
def _on_screen(sight, corners, t, of_vertices):
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
