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
import functools
import math
from typing import NamedTuple

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.geometry import SUBPIXELS, ViewTransform
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

    depth: (height, width) float32 of reversed Z [m], see depth; places: (n, 3) of the vertices:
    to the right and down in the map [texel], and depth [m]; slopes: (n, 2, 4) [m] a texel, of each
    vertex's triangles the least and the greatest dz/du, and the same of dz/dv: of those that show
    the sun their front, and of the others; texel: its side [m]; rounding: [m]; ways: how pixels
    get into the map: of its column, its row and its depth each a_0, a_u, a_v, b and c, so that it
    is (a_0 + a_u u + a_v v) z + b z + c at column u, row v and depth z, without the first z in
    orthographic projection.
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


class SunView(NamedTuple):
    """
    How the sun sees what can shade what a camera sees: in orthographic projection.

    width, height: of the map; focal: texels a metre; transform: see geometry; farthest: no more
    than so far away from the sun's eye is anything that casts shadows [m]; sun: azimuth and
    elevation.
    """

    width: int
    height: int
    focal: float
    transform: ViewTransform
    farthest: float
    sun: tuple


def sun_view(points: np.ndarray, is_casting: np.ndarray, camera: Camera,
             light: Light) -> SunView | None:
    """
    Return how the sun sees all that can shade what `camera` sees, or None if that is nothing.

    points: (n, 3) [m] of the whole scene; is_casting: (n,) bool, those of what casts shadows. Its
    texels are as fine as the pixels of what is nearest to the camera of what casts shadows, or as
    LARGEST allows; they stay where they are in the world while the scene moves, so that edges of
    shadows do not crawl.
    """
    turn, ways, rays, _ = _turned(camera, light.azimuth, light.elevation)
    extremes = np.empty((2, 2, 4))
    _extremes(points, is_casting, ways, extremes)
    (low, high), (_, (_, _, _, most)) = extremes.tolist()
    depth = float(camera.pose[2, 3])
    near, far = max(extremes[1, 0, 3] + depth, camera.near), most + depth
    if not (low[0] <= high[0] and near < far):  # of no points, the least is the greatest number
        return None
    first, end = [], []
    for axis in range(2):
        seen = [begin[axis] + away * way[axis] for begin, way in rays for away in (near, far)]
        first.append(max(low[axis], min(seen)))
        end.append(min(high[axis], max(seen)))
    extent = end[0] - first[0], end[1] - first[1]
    if not min(extent) > 0.0:
        return None
    # In steps of a quarter of an octave.
    fine = 2.0 ** (
        math.ceil(4.0 * math.log2(camera.pixels_per_metre(max(near, low[3] + depth)))) / 4.0)
    while max(extent) * fine + 2 * MARGIN > LARGEST:
        fine *= 2.0 ** -0.25
    width, height = (min(LARGEST, int(-(-(side * fine + 2 * MARGIN) // STEP) * STEP))
                     for side in extent)
    # The middle is a whole number of texels away from the world's origin.
    distance = 0.5 * (high[2] - low[2]) + 1.0
    matrix = np.eye(4)
    matrix[:2, :3], matrix[2, :3] = fine * turn[:2], turn[2]
    matrix[:3, 3] = (-float(round(0.5 * (first[0] + end[0]) * fine)),
                     -float(round(0.5 * (first[1] + end[1]) * fine)),
                     distance - 0.5 * (low[2] + high[2]))
    transform = ViewTransform(matrix, 0.5 * width - 0.5, 0.5 * height - 0.5, 0.5, False)
    return SunView(width, height, fine, transform, distance,
                   (light.azimuth, light.elevation))


@functools.lru_cache(maxsize=8)
def _turned(camera, azimuth, elevation):
    """
    Return what is the same in all frames of a camera and a sun that stand still.

    That is the sun's axes, right, down and away from it, (3, 3); those and what is ahead of the
    camera, (4, 3); of the corners of the image where they are along these axes: a pair of how they
    begin, and how they go on with every metre of depth; and along each axis what the ways of
    Shadows are in metres, from the world's origin.
    """
    turn = Camera(azimuth=azimuth, elevation=elevation, distance=0.0).pose[:3, :3]
    ways = np.vstack([turn, camera.pose[2, :3]])
    axes = turn @ camera.pose[:3, :3].T
    right, down, ahead = (axes / [camera.focal, camera.focal, 1.0]).T
    eye, rays = turn @ camera.position, []
    for u in (-0.5, camera.width - 0.5):
        for v in (-0.5, camera.height - 0.5):
            side = (u - camera.centre[0]) * right + (v - camera.centre[1]) * down
            ray = (eye, side + ahead) if camera.is_perspective else (eye + side, ahead)
            rays.append(tuple(one.tolist() for one in ray))
    begin = -right * camera.centre[0] - down * camera.centre[1]
    if camera.is_perspective:
        begin, ahead = begin + ahead, 0.0 * ahead
    origin = -axes @ camera.pose[:3, 3]
    return turn, ways, rays, np.column_stack([begin, right, down, ahead, origin]).tolist()


@late_kernel
def _extremes(points, is_casting, ways, extremes):
    """
    Write how far points (n, 3) that are not too far reach along ways (k, 3).

    extremes: (2, 2, k), of those that are casting and of all, at least and at most.
    """
    extremes[:, 0], extremes[:, 1] = np.inf, -np.inf
    for i in range(np.uint64(points.shape[0])):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        if abs(x) < FARTHEST and abs(y) < FARTHEST and abs(z) < FARTHEST:
            for k in range(ways.shape[0]):
                along = ways[k, 0] * x + ways[k, 1] * y + ways[k, 2] * z
                for which in range(0 if is_casting[i] else 1, 2):
                    extremes[which, 0, k] = min(extremes[which, 0, k], along)
                    extremes[which, 1, k] = max(extremes[which, 1, k], along)


def shadows_of(depth: np.ndarray, view: SunView, camera: Camera, places: np.ndarray,
               triangles: np.ndarray) -> Shadows:
    """
    Return the Shadows of triangles (m, 3), with the sun's depth map.

    view: the sun's; camera: the one that sees the shadows; places: of Shadows.
    """
    slopes = np.empty((len(places), 2, 4))
    _slopes_at_vertices(places, triangles, 1.0 / view.focal, slopes)
    return Shadows(depth, places, slopes, 1.0 / view.focal, ROUNDING * (view.farthest + 1.0),
                   _ways(camera, view))


def _ways(camera, view):
    """Return the ways from what a camera sees into the sun's map: see Shadows."""
    ways, transform = [], view.transform
    rows = _turned(camera, *view.sun)[3]
    offsets = transform.matrix[:3, 3].tolist()
    for scale, middle, offset, row in zip(
            (view.focal, view.focal, 1.0), (transform.centre_u, transform.centre_v, 0.0), offsets,
            rows):
        *steps, origin = row
        ways.append((*(np.float32(scale * step) for step in steps),
                     np.float32(scale * origin + offset + middle)))
    return tuple(ways)


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
