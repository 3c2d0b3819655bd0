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
Clipping: triangles are cut to what the rasterizer can draw (Sutherland and Hodgman, 1974).

Points are (X, Y, z) of the optical frame with X and Y in pixels at depth 1: a perspective image
has u = X / z, an orthographic one u = X, both relative to the principal point. Triangles are cut
by the near plane, and by a guard band that is far wider than the image: what lies between the
two is left out pixel by pixel, which is cheaper than clipping it.
"""
from flag_sim.jit.kernels import late_kernel

# Half the width of the guard band around the principal point [pixel]. With a principal point
# below 2^13 all coordinates stay below 2^15, where the edge functions are exact.
GUARD_BAND = 2.0 ** 14
# A vertex beyond this [m or pixel] is INVALID, like one that is not finite.
FARTHEST = 1e15
# A triangle that is cut by five planes has at most eight corners.
MAX_CORNERS = 8
# X, Y, z, and a point's barycentric weights of the triangle's second and third vertex.
CORNER_FIELDS = 5
PLANES = 5

INSIDE, OUTSIDE, INVALID = 0, 1, 2


@late_kernel
def outcode(x, y, z, near, is_perspective):
    """
    Return whether a point is INSIDE all planes, OUTSIDE of one, or INVALID.

    Like the outcode of Cohen and Sutherland, but without a bit for each plane: clip tries them
    all.
    """
    limit = GUARD_BAND * z if is_perspective else GUARD_BAND
    # The common case first: nothing else is then looked at.
    if abs(x) <= limit and abs(y) <= limit and near <= z < FARTHEST:
        return INSIDE
    if abs(x) < FARTHEST and abs(y) < FARTHEST and abs(z) < FARTHEST:
        return OUTSIDE
    return INVALID


@late_kernel
def clip(corners, near, is_perspective):
    """
    Cut the triangle in corners[0, :3] by all planes; return the polygon's number of corners.

    corners: (2, MAX_CORNERS + 1, CORNER_FIELDS): X, Y, z and what else is linear in space. Each
    plane takes the polygon from one half of the array to the other; it ends in corners[1].
    """
    count = 3
    for plane in range(PLANES):
        source, target = plane % 2, 1 - plane % 2
        kept = 0
        for k in range(count):
            k_next = k + 1 if k + 1 < count else 0
            here = _distance(corners, source, k, plane, near, is_perspective)
            there = _distance(corners, source, k_next, plane, near, is_perspective)
            if here >= 0.0:
                for c in range(CORNER_FIELDS):
                    corners[target, kept, c] = corners[source, k, c]
                kept += 1
            if (here >= 0.0) != (there >= 0.0):
                # Always from the inside out: both triangles of an edge get the same point.
                inner, outer = (k, k_next) if here >= 0.0 else (k_next, k)
                step = abs(here) if here >= 0.0 else abs(there)
                step /= abs(here) + abs(there)
                for c in range(CORNER_FIELDS):
                    inside = corners[source, inner, c]
                    corners[target, kept, c] = \
                        inside + step * (corners[source, outer, c] - inside)
                kept += 1
        count = kept
    return count


@late_kernel
def _distance(corners, half, k, plane, near, is_perspective):
    """Return how far a corner is inside of a plane, in any unit; negative outside."""
    if plane == 0:
        return corners[half, k, 2] - near
    limit = GUARD_BAND * corners[half, k, 2] if is_perspective else GUARD_BAND
    if plane == 1:
        return limit + corners[half, k, 0]
    if plane == 2:
        return limit - corners[half, k, 0]
    if plane == 3:
        return limit + corners[half, k, 1]
    return limit - corners[half, k, 1]
