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
Shadows: what the sun does not see is in them (Williams, 1978).

The scene is drawn a second time as the sun sees it, in orthographic projection, and only its
depth is kept: the shadow map. A point is in shadow where the map is nearer to the sun than it is.

The map has that depth at the centres of its texels alone, and a point is compared with some that
are du, dv <= REACH texels beside it. There the plane of its triangle has the depth z + du dz/du +
dv dz/dv, so that is what they are compared with. Where a neighbouring triangle begins before, it
is nearer to the sun than this plane by at most REACH times what its slope has more or less: so
much is the bias that keeps a surface from shading itself. Each vertex knows the slopes of its
triangles, of those that show the sun the same side, for others do not begin where this one ends
but lie before or behind it. Within a triangle the bias is what is between its vertices. To it
come the rounding of float32, and of vertices to SUBPIXELS of a texel, which the slope multiplies.

Near the terminator slopes have no bound, and nor have their differences, by which what is just
behind a fold would become bright. So differences count up to TURN alone, and slopes up to
STEEPEST: on a surface as steep as that the sun shines with 1 / STEEPEST of its light.
"""
import math
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.geometry import SUBPIXELS, view_transform
from flag_sim.drawing.shading import Light
from flag_sim.jit.kernels import late_inner_kernel, late_kernel

import numpy as np

# Of a shadow's soft edge: as far from a point are the farthest texels it is compared with, for
# the average over 3 x 3 texels with its place among them (percentage-closer, Reeves et al., 1987).
REACH = 2.0
STEEPEST, TURN = 32.0, 2.0
# Of the depth [m] in float32, by some places.
ROUNDING = 2.0 ** -20
# Texels along a side, at most, and to what its sides are rounded up, so that they seldom change.
LARGEST, STEP = 2048, 256
# Around what is seen [texel]: for the taps, and for rounding to whole texels.
MARGIN = 4
# What is farther from the origin is left out [m].
FARTHEST = 4000.0


class Shadows(NamedTuple):
    """
    The sun's shadow map, for the kernels; of size 0 where there are no shadows.

    depth: (height, width) float32 [m]; places: (n, 3) of the vertices: column and row in the map,
    and depth [m]; slopes: (n, 2, 4) [m] a texel, of each vertex's triangles the least and the
    greatest dz/du, and the same of dz/dv: of those that show the sun their front, and of the
    others; texel: its side [m]; rounding: [m]; ways: how pixels get into the map: of its column,
    its row and its depth each a_0, a_u, a_v, b and c, so that it is (a_0 + a_u u + a_v v) z + b z
    + c at column u, row v and depth z, without the first z in orthographic projection.
    """

    depth: np.ndarray
    places: np.ndarray
    slopes: np.ndarray
    texel: float
    rounding: float
    ways: tuple


def _no_ways():
    return ((np.float32(0.0),) * 5,) * 3


NO_SHADOWS = Shadows(np.empty((0, 0), np.float32), np.empty((0, 3)), np.empty((0, 2, 4)), 1.0,
                     0.0, _no_ways())


def sun_camera(casting: np.ndarray, points: np.ndarray, camera: Camera,
               light: Light) -> Camera | None:
    """
    Return the camera from which the sun sees all that can shade what `camera` sees, or None.

    casting, points: (n, 3) [m] of what casts shadows, and of the whole scene. Its texels are as
    fine as the pixels of what is nearest to the camera of what casts shadows, or as LARGEST
    allows; they stay where they are in the world while the scene moves, so that edges of shadows
    do not crawl.
    """
    # Right, down and away from the sun; and ahead of the camera.
    turn = Camera(azimuth=light.azimuth, elevation=light.elevation, distance=0.0).pose[:3, :3]
    ways = np.vstack([turn, camera.pose[2, :3]])
    low, high = np.empty((2, 2, 4))
    for some, least, most in zip((casting, points), low, high):
        _extremes(some, ways, least, most)
    depth = camera.pose[2, 3]
    near, far = max(low[1, 3] + depth, camera.near), high[1, 3] + depth
    nearest, (low, high) = low[0, 3] + depth, (low[0, :3], high[0, :3])
    if not (low[0] <= high[0] and near < far):  # of no points, the least is the greatest number
        return None
    view = _corners(camera, near, far) @ turn.T
    first = np.maximum(low, view.min(axis=0))[:2]
    end = np.minimum(high, view.max(axis=0))[:2]
    extent = end - first
    if not (extent > 0.0).all():
        return None
    # In steps of a quarter of an octave.
    fine = 2.0 ** (
        math.ceil(4.0 * math.log2(camera.pixels_per_metre(max(near, nearest)))) / 4.0)
    while (extent * fine).max() + 2 * MARGIN > LARGEST:
        fine *= 2.0 ** -0.25
    width, height = (min(LARGEST, int(-(-(side * fine + 2 * MARGIN) // STEP) * STEP))
                     for side in extent)
    middle = np.rint(0.5 * (first + end) * fine) / fine
    target = turn.T @ [*middle, 0.5 * (low[2] + high[2])]
    return Camera(width, height, 'orthographic', scale=height / fine, target=tuple(target),
                  distance=0.5 * (high[2] - low[2]) + 1.0, azimuth=light.azimuth,
                  elevation=light.elevation, near=0.5)


@late_kernel
def _extremes(points, ways, least, most):
    """Write how far points (n, 3) that are not too far reach along ways (k, 3) at least, most."""
    least[:], most[:] = np.inf, -np.inf
    for i in range(np.uint64(points.shape[0])):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if abs(x) < FARTHEST and abs(y) < FARTHEST and abs(z) < FARTHEST:
            for k in range(ways.shape[0]):
                along = ways[k, 0] * x + ways[k, 1] * y + ways[k, 2] * z
                least[k], most[k] = min(least[k], along), max(most[k], along)


def _corners(camera, near, far):
    """Return the corners (8, 3) of what a camera sees from one depth to another [m]."""
    corners = []
    for depth in (near, far):
        scale = (depth if camera.is_perspective else 1.0) / camera.focal
        for u in (-0.5, camera.width - 0.5):
            for v in (-0.5, camera.height - 0.5):
                corners.append(((u - camera.centre[0]) * scale, (v - camera.centre[1]) * scale,
                                depth))
    turn = camera.pose[:3, :3]
    return np.array(corners) @ turn + camera.position


def shadows_of(depth: np.ndarray, sun: Camera, camera: Camera, points: np.ndarray,
               triangles: np.ndarray) -> Shadows:
    """
    Return the Shadows of points (n, 3) and triangles (m, 3), with the sun's depth image.

    sun, camera: that of the sun, and the one that sees the shadows.
    """
    transform = view_transform(sun)
    places, slopes = np.empty((len(points), 3)), np.empty((len(points), 2, 4))
    _places_at_vertices(points, transform, places)
    _slopes_at_vertices(places, triangles, 1.0 / sun.focal, slopes)
    return Shadows(depth, places, slopes, 1.0 / sun.focal, ROUNDING * (sun.distance + 1.0),
                   _ways(camera, transform))


def _ways(camera, transform):
    """Return the ways from what a camera sees into the shadow map: see Shadows."""
    # From the optical frame of the camera, in metres, to the map.
    turn = camera.pose[:3, :3].T
    matrix = transform.matrix[:3, :3] @ turn
    constant = (transform.matrix[:3, 3] - matrix @ camera.pose[:3, 3]
                + (transform.centre_u, transform.centre_v, 0.0))
    right, down, ahead = (matrix / [camera.focal, camera.focal, 1.0]).T
    begin = -right * camera.centre[0] - down * camera.centre[1]
    if camera.is_perspective:
        begin, ahead = begin + ahead, 0.0 * ahead
    return tuple(tuple(np.float32(value) for value in way)
                 for way in zip(begin, right, down, ahead, constant))


@late_inner_kernel
def slopes_of(places, a, b, c, texel):
    """Return dz/du and dz/dv of the triangle of vertices a, b and c, and which side it shows."""
    px, py = places[b, 0] - places[a, 0], places[b, 1] - places[a, 1]
    qx, qy = places[c, 0] - places[a, 0], places[c, 1] - places[a, 1]
    pz, qz = places[b, 2] - places[a, 2], places[c, 2] - places[a, 2]
    area = px * qy - py * qx
    du, dv = (pz * qy - py * qz) / area, (px * qz - pz * qx) / area
    # Of what is no number, as of a triangle seen from its edge, the comparisons make a limit.
    steepest = STEEPEST * texel
    du = max(du, -steepest) if du < steepest else steepest
    dv = max(dv, -steepest) if dv < steepest else steepest
    return du, dv, 0 if area < 0.0 else 1


@late_inner_kernel
def bias_at(shadows, vertex, du, dv, side):
    """Return the bias [m] at a vertex of a triangle with these slopes, without the rounding."""
    slopes, texel = shadows.slopes, shadows.texel
    across = max(slopes[vertex, side, 1] - du, du - slopes[vertex, side, 0])
    along = max(slopes[vertex, side, 3] - dv, dv - slopes[vertex, side, 2])
    most = TURN * texel
    return REACH * (min(across, most) + min(along, most)) + (abs(du) + abs(dv)) / SUBPIXELS


@late_kernel
def _places_at_vertices(points, transform, places):
    matrix = transform.matrix
    for i in range(np.uint64(points.shape[0])):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        places[i, 0] = (matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2] * z
                        + (matrix[0, 3] + transform.centre_u))
        places[i, 1] = (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2] * z
                        + (matrix[1, 3] + transform.centre_v))
        places[i, 2] = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2] * z + matrix[2, 3]


@late_kernel
def _slopes_at_vertices(places, triangles, texel, slopes):
    slopes[..., 0::2], slopes[..., 1::2] = np.inf, -np.inf
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        du, dv, side = slopes_of(places, a, b, c, texel)
        for corner in range(3):
            vertex = triangles[t, corner]
            slopes[vertex, side, 0] = min(slopes[vertex, side, 0], du)
            slopes[vertex, side, 1] = max(slopes[vertex, side, 1], du)
            slopes[vertex, side, 2] = min(slopes[vertex, side, 2], dv)
            slopes[vertex, side, 3] = max(slopes[vertex, side, 3], dv)
