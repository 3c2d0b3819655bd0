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

"""The pass over an image that makes its channels from the faces and depths that pixels see."""
from flag_sim.drawing.channels import COORDINATE, MOTION, NORMAL
from flag_sim.drawing.pixels import BAND
from flag_sim.drawing.planes import VALUES
from flag_sim.drawing.vectors import set_from_plane
from flag_sim.drawing.visibility import is_back, NO_FACE, triangle_of, write_visibility
from flag_sim.jit.kernels import late_kernel, wide_kernel
from flag_sim.parallel.atomics import fetch_add

import numpy as np


# Pixels whose values are interpolated in one go, so that they stay in a processor's cache.
SEGMENT = 256


def new_values() -> np.ndarray:
    """Make memory for the values of a segment's pixels, (SEGMENT VALUES,) float32."""
    return np.empty(SEGMENT * VALUES, np.float32)


@late_kernel
def resolve(taken, columns, pixels, attributes, images, visibility, values):
    """
    Write the channels of bands of an image as long as there are any.

    taken: (1,) int64, how many bands were taken by this and other threads; columns: dirty, see
    framebuffer.Images, and seen: (2, height) int32, the first column and the end of what each row
    saw in the last frame, and then in this one: what is beyond both has not changed; pixels: the
    faces and the depths [m] that pixels see, (height, width); images: Resolved; visibility:
    triangles, is_back and weights of a Visibility, of size 0 if it is not wanted; values: see
    new_values.
    """
    faces, depths = pixels
    dirty, seen = columns
    while True:
        band = fetch_add(taken, 0, 1)
        if band >= dirty.shape[1]:
            break
        for row in range(np.uint64(band * BAND),
                         np.uint64(min((band + 1) * BAND, faces.shape[0]))):
            marks, depth = faces[np.int64(row)], depths[np.int64(row)]
            last_left, last_right = np.uint64(seen[0, row]), np.uint64(seen[1, row])
            left, right = _seen(marks, np.uint64(dirty[0, band]), np.uint64(dirty[1, band]))
            seen[0, row], seen[1, row] = left, right
            if last_left < last_right:
                left = min(left, last_left) if left < right else last_left
                right = max(right, last_right)
            for first in range(left, right, np.uint64(SEGMENT)):
                _write_segment((row, first, min(first + np.uint64(SEGMENT), right)), marks, depth,
                               attributes, images, visibility, values)


@late_kernel
def _write_segment(area, marks, depth, attributes, images, visibility, values):
    """Write channels of pixels of a row; area: the row, their first column and the end."""
    if attributes.planes.size > 0:
        _interpolate(area, marks, attributes.planes, values)
    if images.normals.size > 0:
        _write_normals(area, marks, values, images.normals.reshape(-1))
    if images.labels.size > 0:
        _write_labels(area, marks, attributes.labels, images.labels.reshape(-1))
    if images.texture_coordinates.size > 0:
        _write_coordinates(area, marks, depth, attributes, values,
                           images.texture_coordinates.reshape(-1))
    if images.flow.size > 0:
        _write_flow(area, marks, depth, attributes, values, images.flow.reshape(-1))
    if visibility[0].size > 0:
        write_visibility(area, marks, depth, attributes, visibility)


@late_kernel
def _interpolate(area, marks, planes, values):
    """Write all values of pixels, divided by depth; see planes.set_planes."""
    row, left, right = area
    v, k = np.float32(row), np.uint64(VALUES)
    for i in range(left, right):
        u = np.float32(np.int32(i))
        place, target = np.uint64(3) * k * np.uint64(triangle_of(marks[i])), k * (i - left)
        set_from_plane(values, target, planes, place, u, v)


@late_kernel
def _seen(marks, left, right):
    """Return the first and the end of the pixels left .. right - 1 that see something."""
    step = np.uint64(16)
    while left + step <= right and not _any(marks, left, left + step):
        left += step
    while left + step <= right and not _any(marks, right - step, right):
        right -= step
    while left < right and marks[left] == NO_FACE:
        left += np.uint64(1)
    while left < right and marks[right - np.uint64(1)] == NO_FACE:
        right -= np.uint64(1)
    return (left, right) if left < right else (np.uint64(0), np.uint64(0))


@late_kernel
def _any(marks, first, end):
    found = np.uint32(0)
    for i in range(first, end):
        found |= marks[i]
    return found != NO_FACE


@wide_kernel
def _write_normals(area, marks, values, image):
    """Write unit normals on the side that is seen, as Gouraud shading has them (eq. 1.13)."""
    row, left, right = area
    start = row * np.uint64(marks.size)
    zero, one = np.float32(0.0), np.float32(1.0)
    for i in range(left, right):
        mark, place = marks[i], np.uint64(VALUES) * (i - left) + np.uint64(NORMAL)
        x, y, z = values[place], values[place + np.uint64(1)], values[place + np.uint64(2)]
        length = np.sqrt(x * x + y * y + z * z)
        side = -one if is_back(mark) else one
        is_known = (mark != NO_FACE) & (length > zero)
        scale = side / length if is_known else zero
        p = np.uint64(3) * (start + i)
        image[p] = scale * x if is_known else zero
        image[p + np.uint64(1)] = scale * y if is_known else zero
        image[p + np.uint64(2)] = scale * z if is_known else zero


@wide_kernel
def _write_labels(area, marks, labels, image):
    row, left, right = area
    start = row * np.uint64(marks.size)
    for i in range(left, right):
        label = labels[triangle_of(marks[i])]
        image[start + i] = np.uint8(label if marks[i] != NO_FACE else 0)


@wide_kernel
def _write_coordinates(area, marks, depth, attributes, values, image):
    """Write texture coordinates, linear in space and within the range of the scene's vertices."""
    row, left, right = area
    start, is_perspective = row * np.uint64(marks.size), attributes.is_perspective
    ranges, one, nothing = attributes.ranges, np.float32(1.0), np.float32(np.nan)
    u_least, u_most, v_least, v_most = ranges[0, 0], ranges[0, 1], ranges[1, 0], ranges[1, 1]
    for i in range(left, right):
        mark, place = marks[i], np.uint64(VALUES) * (i - left) + np.uint64(COORDINATE)
        z = depth[i] if is_perspective else one
        x, y = z * values[place], z * values[place + np.uint64(1)]
        # What is no number stays so.
        x = u_least if x < u_least else u_most if x > u_most else x
        y = v_least if y < v_least else v_most if y > v_most else y
        p = np.uint64(2) * (start + i)
        image[p] = x if mark != NO_FACE else nothing
        image[p + np.uint64(1)] = y if mark != NO_FACE else nothing


@wide_kernel
def _write_flow(area, marks, depth, attributes, values, image):
    """
    Write where the point that a pixel sees was in the frame before, minus where it is [pixel].

    With X / z = u - u_0, it was at (X + dX) / (z + dz) + u_0', which is farther to the right by
    (dX - (u - u_0) dz) / (z + dz) + u_0' - u_0: planes are divided by z already.
    """
    row, left, right = area
    start = row * np.uint64(marks.size)
    shift, centre = attributes.shift, attributes.centre
    shift_u, shift_v = np.float32(shift[0]), np.float32(shift[1])
    centre_u, centre_v = np.float32(centre[0]), np.float32(centre[1])
    v, one, zero, nothing = np.float32(row), np.float32(1.0), np.float32(0.0), np.float32(np.nan)
    is_perspective, was_perspective = attributes.is_perspective, attributes.was_perspective
    for i in range(left, right):
        u, mark = np.float32(np.int32(i)), marks[i]
        place = np.uint64(VALUES) * (i - left) + np.uint64(MOTION)
        x, y, z = values[place], values[place + np.uint64(1)], values[place + np.uint64(2)]
        if is_perspective == was_perspective:
            away = one + z if is_perspective else one
            if is_perspective:
                x, y = x - (u - centre_u) * z, y - (v - centre_v) * z
        else:
            scale = depth[i] if is_perspective else one
            x, y, away = scale * x, scale * y, scale * z if was_perspective else one
        x, y = x / away + shift_u, y / away + shift_v
        if is_perspective != was_perspective:
            x, y = x - (u - centre_u), y - (v - centre_v)
        is_known = (mark != NO_FACE) & (away > zero)
        p = np.uint64(2) * (start + i)
        image[p] = x if is_known else nothing
        image[p + np.uint64(1)] = y if is_known else nothing
