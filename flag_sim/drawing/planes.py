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
Planes: what values of a triangle's vertices are on the screen.

What is linear in space is, divided by depth, linear on the screen (Olano and Greer, 1997): a value
at column u and row v is z (p + p_u u + p_v v), with the depth z of the pixel, which is left out in
orthographic projection. With corners P = (X, Y, z), in pixels at depth 1, the plane solves
(p_u, p_v, p) . P = value at each of them, wherever they are: before the eye or behind it. On a
triangle that is seen from its edge, of which no pixel is seen, planes are 0.

Single precision is enough for a plane: what it loses at column u is u 2^-24 of its change from
one pixel to the next.
"""
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# Values that are interpolated together: a vector of 256 bits.
VALUES = 8


@late_kernel
def set_planes(geometry, values, first, end, planes):
    """
    Write the planes of triangles first .. end - 1.

    values: (VALUES, n) at vertices; planes: flat float32, of each triangle p of all values, then
    p_u of all and p_v of all: what a pixel needs stands together, and is read in three pieces.
    """
    triangles = geometry.triangles
    for t in range(np.uint64(first), np.uint64(end)):
        solve = solver(geometry, t)
        a, b, c = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1]), np.uint64(
            triangles[t, 2])
        for k in range(np.uint64(VALUES)):
            p, p_u, p_v = plane(geometry.transform, solve, values[k, a], values[k, b],
                                values[k, c])
            place = np.uint64(3 * VALUES) * t + k
            planes[place] = p
            planes[place + np.uint64(VALUES)] = p_u
            planes[place + np.uint64(2 * VALUES)] = p_v


@late_kernel
def set_weight_planes(geometry, planes):
    """Write the planes (6, m) of the barycentric weights of the second and third vertex."""
    for t in range(np.uint64(geometry.triangles.shape[0])):
        solve = solver(geometry, t)
        for k in range(2):
            p, p_u, p_v = plane(geometry.transform, solve, 0.0, 1.0 - k, 1.0 * k)
            planes[3 * k, t], planes[3 * k + 1, t], planes[3 * k + 2, t] = p, p_u, p_v


@late_inner_kernel
def solver(geometry, t):
    """Return what the value of each of a triangle's vertices has in its plane: p_u, p_v and p."""
    view, is_perspective = geometry.vertices.view_space, geometry.transform.is_perspective
    a, b = np.uint64(geometry.triangles[t, 0]), np.uint64(geometry.triangles[t, 1])
    c = np.uint64(geometry.triangles[t, 2])
    ax, ay, az = view[a, 0], view[a, 1], view[a, 2] if is_perspective else 1.0
    bx, by, bz = view[b, 0], view[b, 1], view[b, 2] if is_perspective else 1.0
    cx, cy, cz = view[c, 0], view[c, 1], view[c, 2] if is_perspective else 1.0
    ux, uy, uz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    vx, vy, vz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    wx, wy, wz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    volume = ax * ux + ay * uy + az * uz
    scale = 1.0 / volume if volume != 0.0 else 0.0
    return (scale * ux, scale * uy, scale * uz, scale * vx, scale * vy, scale * vz,
            scale * wx, scale * wy, scale * wz)


@late_inner_kernel
def plane(transform, solve, at_a, at_b, at_c):
    """Return p, p_u and p_v of a value at three vertices; solve: see solver."""
    p_u = at_a * solve[0] + at_b * solve[3] + at_c * solve[6]
    p_v = at_a * solve[1] + at_b * solve[4] + at_c * solve[7]
    p = at_a * solve[2] + at_b * solve[5] + at_c * solve[8]
    return p - p_u * transform.centre_u - p_v * transform.centre_v, p_u, p_v


@late_inner_kernel
def at_pixel(planes, k, t, u, v):
    """Return value k of triangle t at column u and row v, divided by depth."""
    return planes[3 * k, t] + planes[3 * k + 1, t] * u + planes[3 * k + 2, t] * v
