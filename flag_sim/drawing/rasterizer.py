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
The rasterizer: triangles to pixels.

A pixel belongs to a triangle if its centre does; a centre on an edge belongs to the triangle on
one side alone (the top-left rule), so triangles that share an edge leave neither gaps nor doubles.
Hidden surfaces are removed by a Z-buffer of float32 in reversed Z, where greater is nearer, which
is affine on the screen: 1 / z in perspective, cleared to 0, and -z in orthographic projection,
cleared to -inf. Both are exact for planes. In painter's algorithm later triangles
cover earlier ones instead. Narrow triangles are drawn in groups (see blocks), others one by one,
row by row; both cover the same pixels.
"""
from flag_sim.drawing.blocks import (
    draw_narrow, EDGE_FIELDS, GROUP, PLANE_FIELDS, POSITION_FIELDS, VALUE_FIELDS)
from flag_sim.drawing.clipping import clip, INSIDE, MOST_CORNERS
from flag_sim.drawing.culling import ALONE, NARROW
from flag_sim.drawing.outline import draw_outline
from flag_sim.drawing.projection import SUBPIXELS, to_screen
from flag_sim.drawing.spans import empty, span_linear, span_perspective_correct
from flag_sim.drawing.tiles import TILE
from flag_sim.kernels import kernel

import numpy as np

SLACK = 2.0 ** -33


@kernel
def fill(triangles, numbers, count, kinds, closed, view, u, v, reversed_z, outcodes, colours,
         is_flat, cu, cv, near, is_perspective, is_perspective_correct, is_painter, is_outlined,
         shift_u, shift_v, marks, top, end, width, stride, depths, words):
    """
    Draw those of triangles (m, 3) that numbers[:count] tells into rows top .. end - 1.

    kinds: from cull; closed: from this triangle on backs are not drawn; view, u, v, reversed_z,
    outcodes: from project; colours: (n, 2, 3) of both sides, 0..255, at vertices, or (m, 2, 3) of
    triangles if is_flat; is_perspective_correct: how colours are interpolated, else linearly on
    the screen; is_painter: cover what was drawn before, near or far; is_outlined: draw the edges
    too; shift_u, shift_v: where in the pixel its sample lies, from the centre [subpixel];
    marks: tiles from row `top` on that are wanted (see tiles), all if it has none; depths, words:
    reversed Z float32 and colours uint32 of the rows, `stride` pixels each, a multiple of LANES.
    No triangle may have an INVALID vertex.
    """
    positions, values = np.empty(POSITION_FIELDS * GROUP, np.int32), np.empty(VALUE_FIELDS * GROUP)
    edges = np.empty(EDGE_FIELDS * GROUP, np.int32)
    group_planes = np.empty(PLANE_FIELDS * GROUP, np.float32)
    shape, planes = np.empty((2, MOST_CORNERS + 1, 6)), np.empty((5, 4))
    k = np.uint64(0)
    while k < count:
        first, kind = k, kinds[numbers[k]]
        if kind != ALONE and not is_outlined:
            while k < count and k - first < GROUP and kinds[numbers[k]] == kind:
                k += np.uint64(1)
            draw_narrow(triangles, numbers, first, k - first, closed, u, v, reversed_z, colours,
                        is_flat, is_perspective_correct, is_painter, kind == NARROW, shift_u,
                        shift_v, top, end, width, stride, positions, values, edges, group_planes,
                        depths, words)
            continue
        t = np.uint64(numbers[k])
        k += np.uint64(1)
        corners = _shape(triangles, t, closed, view, u, v, reversed_z, outcodes, colours, is_flat,
                         cu, cv, near, is_perspective, shape)
        for corner in range(corners):
            shape[1, corner, 0] -= shift_u / SUBPIXELS
            shape[1, corner, 1] -= shift_v / SUBPIXELS
            if is_perspective_correct:
                # Perspective-correct colours are interpolated multiplied by 1 / z.
                for axis in range(3, 6):
                    shape[1, corner, axis] *= shape[1, corner, 2]
        for corner in range(2, corners):
            fill_triangle(shape, np.uint64(0), np.uint64(corner - 1), np.uint64(corner), planes,
                          is_perspective_correct, is_painter, marks, top, end, width, stride,
                          depths, words)
        if is_outlined:
            draw_outline(shape, corners, is_perspective_correct, is_painter, marks, top, end,
                         width, stride, depths, words)


@kernel
def _shape(triangles, t, closed, view, u, v, reversed_z, outcodes, colours, is_flat, cu, cv, near,
           is_perspective, shape):
    """Put what is seen of a triangle in shape[1]: u, v, reversed Z, colours; count its corners."""
    a, b, c = np.uint64(triangles[t, 0]), np.uint64(triangles[t, 1]), np.uint64(triangles[t, 2])
    is_whole = (outcodes[a] | outcodes[b] | outcodes[c]) == INSIDE
    if is_whole:
        side = _side(float(u[a]), float(v[a]), float(u[b]), float(v[b]), float(u[c]), float(v[c]))
    else:
        side = _side_of_view(view, a, b, c, is_perspective)
    if side < 0 or (side == 1 and t >= closed):
        return 0
    for k in range(3):
        vertex = np.uint64(triangles[t, k])
        matter = t if is_flat else vertex
        shape[1, k, 0], shape[1, k, 1] = u[vertex] / SUBPIXELS, v[vertex] / SUBPIXELS
        shape[1, k, 2] = reversed_z[vertex]
        for axis in range(3):
            shape[0, k, axis] = view[vertex, axis]
            shape[0, k, 3 + axis] = shape[1, k, 3 + axis] = colours[matter, side, axis]
    if is_whole:
        return 3
    corners = clip(shape, near, is_perspective)
    for k in range(corners):
        sub_u, sub_v, shape[1, k, 2] = to_screen(
            shape[1, k, 0], shape[1, k, 1], shape[1, k, 2], cu, cv, is_perspective)
        shape[1, k, 0], shape[1, k, 1] = sub_u / SUBPIXELS, sub_v / SUBPIXELS
    return corners


@kernel
def fill_triangle(corners, a, b, c, planes, is_perspective_correct, is_painter, marks,
                  top, bottom, width, stride, depths, words):
    """
    Draw a triangle of corners[1], (n, 6): u, v, reversed Z, red, green, blue.

    planes: (5, 4), for the work in between.
    """
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

    # Rows whose centres lie in [av, cv).
    row, end = max(int(np.ceil(av)), top), min(int(np.ceil(cv)), bottom)
    if row >= end or max(au, bu, cu) <= 0.0 or min(au, bu, cu) > width - 1.0:
        return

    # Each value q is a plane over the screen: q = q_0 + q_u (u - ua) + q_v (v - va).
    share = 1.0 / area
    uu, uv = (cv - av) * share, (bv - av) * share
    vu, vv = (cu - au) * share, (bu - au) * share
    for q in range(4):
        along_b = corners[1, b, 2 + q] - corners[1, a, 2 + q]
        along_c = corners[1, c, 2 + q] - corners[1, a, 2 + q]
        planes[0, q] = corners[1, a, 2 + q]
        planes[1, q] = along_b * uu - along_c * uv
        planes[2, q] = along_c * vv - along_b * vu
        # Perspective-correct colours come times reversed Z; what they are held within does not.
        for corner in (a, b, c):
            value = corners[1, corner, 2 + q]
            if is_perspective_correct and q > 0:
                value /= corners[1, corner, 2]
            planes[3, q] = value if corner == a else min(planes[3, q], value)
            planes[4, q] = value if corner == a else max(planes[4, q], value)
    bounds = planes[3:].astype(np.float32)

    along_ac = (cu - au) / (cv - av)
    along_ab = (bu - au) / (bv - av)
    along_bc = (cu - bu) / (cv - bv)
    while row < end:
        long = au + along_ac * (row - av)
        short = au + along_ab * (row - av) if row < bv else bu + along_bc * (row - bv)
        left, right = (long, short) if area > 0.0 else (short, long)
        begin = max(int(np.ceil(left - SLACK)), 0)
        stop = min(int(np.ceil(right - SLACK)), width)
        while begin < stop:
            run, is_wanted = stop, True
            if marks.size > 0:
                run = min((begin // TILE + 1) * TILE, stop)
                is_wanted = marks[(row - top) // TILE, begin // TILE]
            if is_wanted:
                du, dv = begin - au, row - av
                first, count = np.uint64((row - top) * stride + begin), np.uint64(run - begin)
                s, ds = _at(planes, 0, du, dv)
                r, dr = _at(planes, 1, du, dv)
                g, dg = _at(planes, 2, du, dv)
                b_, db = _at(planes, 3, du, dv)
                if is_painter:
                    # What is emptied first is covered; a test in the span would slow it down.
                    empty(depths, first, count)
                if is_perspective_correct:
                    span_perspective_correct(words, depths, first, count, bounds[0], bounds[1],
                                             s, ds, r, dr, g, dg, b_, db)
                else:
                    span_linear(words, depths, first, count, bounds[0], bounds[1],
                                s, ds, r, dr, g, dg, b_, db)
            begin = run
        row += 1


@kernel
def _at(planes, q, du, dv):
    """Return a plane's value, and its slope along the row."""
    return (np.float32(planes[0, q] + planes[1, q] * du + planes[2, q] * dv),
            np.float32(planes[1, q]))


@kernel
def _side(au, av, bu, bv, cu, cv):
    """Return which side a triangle shows: 0 front (counterclockwise), 1 back, -1 its edge."""
    area = (bu - au) * (cv - av) - (cu - au) * (bv - av)
    # v points down, which turns the sign.
    return 0 if area < 0.0 else 1 if area > 0.0 else -1


@kernel
def _side_of_view(view, a, b, c, is_perspective):
    """Return the same from the points in space: perspective asks where the eye is."""
    px, py, pz = view[b, 0] - view[a, 0], view[b, 1] - view[a, 1], view[b, 2] - view[a, 2]
    qx, qy, qz = view[c, 0] - view[a, 0], view[c, 1] - view[a, 1], view[c, 2] - view[a, 2]
    toward = px * qy - py * qx
    if is_perspective:
        toward = (view[a, 0] * (py * qz - pz * qy) + view[a, 1] * (pz * qx - px * qz)
                  + view[a, 2] * toward)
    return 0 if toward < 0.0 else 1 if toward > 0.0 else -1
