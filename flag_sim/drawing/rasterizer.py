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
The rasterizer: vertices to the screen, triangles to pixels.

A pixel belongs to a triangle if its centre does; a centre on an edge belongs to the triangle on
one side alone (the top-left rule), so triangles that share an edge leave neither gaps nor doubles.
Hidden surfaces are removed by a Z-buffer of float32 "nearness", where greater is nearer, of a
measure that is affine on the screen: 1 / z in perspective, cleared to 0, and -z in orthographic
projection, cleared to -inf. Both are exact for planes.
"""
from flag_sim.drawing.clipping import clip, INSIDE, MOST_CORNERS, NOWHERE, OUTSIDE, whereabouts
from flag_sim.drawing.spans import span_correct, span_linear
from flag_sim.kernels import kernel

import numpy as np

# Vertices are snapped to this many places a pixel, which makes the edges' arithmetic exact.
PLACES = 256.0
# An edge meets a row of pixel centres at a multiple of 1 / (256 dv) pixels, dv its height in
# places, below 2^23: so it misses a pixel centre by at least 2^-31 or not at all, and float64
# knows where it is to better than 2^-36. Rounding up after taking off 2^-33 is therefore exact.
SLACK = 2.0 ** -33


@kernel
def project(vertices, matrix, cu, cv, near, is_perspective, view, screen, where):
    """
    Take vertices (n, 3) [m] to the screen.

    matrix: (4, 4) world to the optical frame, x and y scaled to pixels at depth 1; cu, cv: the
    principal point [pixel]. Writes view (n, 3): X, Y, z of that frame; screen (n, 3): u, v
    [pixel], snapped, and nearness, for vertices that are INSIDE; where (n,): see clipping.
    """
    for i in range(vertices.shape[0]):
        px, py, pz = vertices[i, 0], vertices[i, 1], vertices[i, 2]
        x = matrix[0, 0] * px + matrix[0, 1] * py + matrix[0, 2] * pz + matrix[0, 3]
        y = matrix[1, 0] * px + matrix[1, 1] * py + matrix[1, 2] * pz + matrix[1, 3]
        z = matrix[2, 0] * px + matrix[2, 1] * py + matrix[2, 2] * pz + matrix[2, 3]
        view[i, 0], view[i, 1], view[i, 2] = x, y, z
        where[i] = whereabouts(x, y, z, near, is_perspective)
        if where[i] == INSIDE:
            screen[i, 0], screen[i, 1], screen[i, 2] = _to_screen(x, y, z, cu, cv, is_perspective)


@kernel
def bounds(screen, where, width, height):
    """
    Bound the pixels that a mesh can cover: rows top .. bottom - 1, columns left .. right - 1.

    A mesh with a vertex OUTSIDE can cover all of the image; one that is not seen gets no rows.
    """
    left, right, top, bottom = float(width), -1.0, float(height), -1.0
    for i in range(screen.shape[0]):
        if where[i] == OUTSIDE:
            return 0, height, 0, width
        if where[i] == INSIDE:
            left, right = min(left, screen[i, 0]), max(right, screen[i, 0])
            top, bottom = min(top, screen[i, 1]), max(bottom, screen[i, 1])
    left, right = max(np.ceil(left), 0.0), min(np.floor(right) + 1.0, float(width))
    top, bottom = max(np.ceil(top), 0.0), min(np.floor(bottom) + 1.0, float(height))
    if left >= right or top >= bottom:
        return 0, 0, 0, 0
    return int(top), int(bottom), int(left), int(right)


@kernel
def fill(triangles, view, screen, where, colours, is_flat, two_sided,
         cu, cv, near, is_perspective, is_correct,
         row_first, row_step, width, height, nearness, words):
    """
    Draw triangles (m, 3) into rows row_first, row_first + row_step, ... of the image.

    view, screen, where: from project; colours: (2, n, 3) of both sides, 0..255, at vertices, or
    (2, m, 3) of triangles if is_flat; without two_sided the backs are not drawn; is_correct:
    interpolate colours perspective-correctly, else linearly on the screen; nearness, words:
    (height width,) at least, float32 and uint32. Triangles with a vertex NOWHERE are not drawn.
    """
    shape = np.empty((2, MOST_CORNERS + 1, 6))
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        state = where[a] | where[b] | where[c]
        if state >= NOWHERE:
            continue
        if state == INSIDE:
            side = _side(screen[a, 0], screen[a, 1], screen[b, 0], screen[b, 1],
                         screen[c, 0], screen[c, 1])
        else:
            side = _side_of_view(view, a, b, c, is_perspective)
        if side < 0 or (side == 1 and not two_sided):
            continue
        for k in range(3):
            vertex = triangles[t, k]
            matter = t if is_flat else vertex
            for axis in range(3):
                shape[0, k, axis] = view[vertex, axis]
                shape[1, k, axis] = screen[vertex, axis]
                shape[0, k, 3 + axis] = shape[1, k, 3 + axis] = colours[side, matter, axis]
        count = 3
        if state != INSIDE:
            count = clip(shape, near, is_perspective)
            for k in range(count):
                shape[1, k, 0], shape[1, k, 1], shape[1, k, 2] = _to_screen(
                    shape[1, k, 0], shape[1, k, 1], shape[1, k, 2], cu, cv, is_perspective)
        if is_correct:
            for k in range(count):
                for axis in range(3, 6):
                    shape[1, k, axis] *= shape[1, k, 2]
        for k in range(2, count):
            fill_triangle(shape, 0, k - 1, k, is_correct,
                          row_first, row_step, width, height, nearness, words)


@kernel
def fill_triangle(corners, a, b, c, is_correct,
                  row_first, row_step, width, height, nearness, words):
    """Draw a triangle of corners[1], (n, 6): u, v, nearness, red, green, blue."""
    # From top to bottom, always: triangles that share an edge then compute it alike.
    if corners[1, b, 1] < corners[1, a, 1]:
        a, b = b, a
    if corners[1, c, 1] < corners[1, b, 1]:
        b, c = c, b
    if corners[1, b, 1] < corners[1, a, 1]:
        a, b = b, a
    au, av = corners[1, a, 0], corners[1, a, 1]
    bu, bv = corners[1, b, 0], corners[1, b, 1]
    cu, cv = corners[1, c, 0], corners[1, c, 1]
    area = (bu - au) * (cv - av) - (cu - au) * (bv - av)
    if area == 0.0:
        return

    # Rows whose centres lie in [top, bottom).
    row = max(int(np.ceil(av)), 0)
    row += (row_first - row) % row_step
    end = min(int(np.ceil(cv)), height)
    if row >= end or max(au, bu, cu) <= 0.0 or min(au, bu, cu) > width - 1.0:
        return

    # Each value q is a plane over the screen: q = qa + q_u (u - ua) + q_v (v - va).
    uu, uv = (cv - av) / area, (bv - av) / area
    vu, vv = (cu - au) / area, (bu - au) / area
    s, s_u, s_v = _plane(corners[1, a, 2], corners[1, b, 2], corners[1, c, 2], uu, uv, vu, vv)
    r, r_u, r_v = _plane(corners[1, a, 3], corners[1, b, 3], corners[1, c, 3], uu, uv, vu, vv)
    g, g_u, g_v = _plane(corners[1, a, 4], corners[1, b, 4], corners[1, c, 4], uu, uv, vu, vv)
    b_, b_u, b_v = _plane(corners[1, a, 5], corners[1, b, 5], corners[1, c, 5], uu, uv, vu, vv)

    along_ac = (cu - au) / (cv - av)
    along_ab = (bu - au) / (bv - av)
    along_bc = (cu - bu) / (cv - bv)
    while row < end:
        long = au + along_ac * (row - av)
        short = au + along_ab * (row - av) if row < bv else bu + along_bc * (row - bv)
        left, right = (long, short) if area > 0.0 else (short, long)
        begin = max(np.ceil(left - SLACK), 0.0)
        count = int(min(np.ceil(right - SLACK), float(width)) - begin)
        if count > 0:
            du, dv = begin - au, row - av
            first = np.uint64(row * width + int(begin))
            if is_correct:
                span_correct(
                    words, nearness, first, np.uint64(count),
                    np.float32(s + s_u * du + s_v * dv), np.float32(s_u),
                    np.float32(r + r_u * du + r_v * dv), np.float32(r_u),
                    np.float32(g + g_u * du + g_v * dv), np.float32(g_u),
                    np.float32(b_ + b_u * du + b_v * dv), np.float32(b_u))
            else:
                span_linear(
                    words, nearness, first, np.uint64(count),
                    np.float32(s + s_u * du + s_v * dv), np.float32(s_u),
                    np.float32(r + r_u * du + r_v * dv), np.float32(r_u),
                    np.float32(g + g_u * du + g_v * dv), np.float32(g_u),
                    np.float32(b_ + b_u * du + b_v * dv), np.float32(b_u))
        row += row_step


@kernel
def _to_screen(x, y, z, cu, cv, is_perspective):
    """Project a point: u, v, snapped, and nearness."""
    if is_perspective:
        near = 1.0 / z
        return _snap(cu + x * near), _snap(cv + y * near), near
    return _snap(cu + x), _snap(cv + y), -z


@kernel
def _snap(value):
    return np.floor(value * PLACES + 0.5) / PLACES


@kernel
def _side(au, av, bu, bv, cu, cv):
    """Say which side a triangle shows: 0 front (counterclockwise), 1 back, -1 its edge."""
    area = (bu - au) * (cv - av) - (cu - au) * (bv - av)
    # v points down, which turns the sign.
    return 0 if area < 0.0 else 1 if area > 0.0 else -1


@kernel
def _side_of_view(view, a, b, c, is_perspective):
    """Say the same from the points in space: perspective asks where the eye is."""
    px, py, pz = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1], view[b, 2] - view[a, 2]
    qx, qy, qz = view[c, 0] - view[a, 0], view[c, 1] - view[a, 1], view[c, 2] - view[a, 2]
    toward = px * qy - py * qx
    if is_perspective:
        toward = (view[a, 0] * (py * qz - pz * qy) + view[a, 1] * (pz * qx - px * qz)
                  + view[a, 2] * toward)
    return 0 if toward < 0.0 else 1 if toward > 0.0 else -1


@kernel
def _plane(qa, qb, qc, uu, uv, vu, vv):
    """Give a value at corner a and its slopes along u and v."""
    return qa, (qb - qa) * uu - (qc - qa) * uv, (qc - qa) * vv - (qb - qa) * vu
