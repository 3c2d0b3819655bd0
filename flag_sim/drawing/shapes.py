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
Shapes of the pole and the platform of the source's scene (sec. 1.2), of the ground, and of a box.

All are closed meshes, about an origin of their own: the centre of the pole's base, which is that
of the platform's lower face, or that of the box's; z is up. `placed` brings them to where they
stand (eqs. 2.1 to 2.5). All round things share their angles, so that the pole fills
the platform's hole without a gap. Hard edges repeat their vertices, one for each face that meets
there.
"""
from collections.abc import Sequence
import functools
import math

from flag_sim.drawing.dimensions import Box, Dimensions, FEWEST_SEGMENTS, MOST_SEGMENTS, Place
from flag_sim.drawing.mesh import Mesh
from flag_sim.drawing.transforms import apply
from flag_sim.parameters import checks

import numpy as np

# Rings of the ground [m]: small near the pole, where shadows fall, so that single precision tells
# places in them apart.
GROUND_RINGS = (1000.0, 300.0, 100.0, 30.0, 10.0, 3.0, 0.0)
GROUND_SEGMENTS = 64


def box_mesh(low: Sequence[float], high: Sequence[float]) -> Mesh:
    """
    Build a box with sides along the axes, from the corner `low` to `high`, both (3,) [m].

    Raises ValueError unless `high` is greater on every axis.
    """
    low, high = checks.array('low', low, (3,)), checks.array('high', high, (3,))
    checks.require((low < high).all(), 'high', f'greater than low {low.tolist()}', high.tolist())
    square = np.array([[high[0], high[1]], [low[0], high[1]], [low[0], low[1]],
                       [high[0], low[1]]])
    cut = np.array([[0, 1, 2], [2, 3, 0]])
    parts = [_flat(square, high[2], 1.0, cut), _flat(square, low[2], -1.0, cut[:, ::-1])]
    for side in range(4):
        parts.append(_upright(square[side], square[(side + 1) % 4], high[2], low[2]))
    return _join(parts)


@functools.lru_cache(maxsize=256)
def mesh_of_box(box: Box) -> Mesh:
    """Build a box where it stands."""
    length, width, height = box.size
    return placed(box_mesh((-0.5 * length, -0.5 * width, 0.0),
                           (0.5 * length, 0.5 * width, height)), box.place)


@functools.lru_cache(maxsize=16)
def placed(mesh: Mesh, place: Place) -> Mesh:
    """Return a mesh about the origin at its place: turned and shifted (eqs. 2.1 to 2.5)."""
    if place == Place():
        return mesh
    pose = place.pose
    vertices, normals = apply(pose, mesh.vertices), mesh.normals @ pose[:3, :3].T
    for array in (vertices, normals):
        array.flags.writeable = False
    return Mesh(vertices, mesh.triangles, normals)


@functools.lru_cache(maxsize=8)
def pole_mesh(dimensions: Dimensions, segments: int) -> Mesh:
    """
    Build the pole about the origin, with round parts of `segments` chords, a multiple of four.

    Raises ValueError unless from FEWEST_SEGMENTS to MOST_SEGMENTS of them.
    """
    segments = _check_segments(segments)
    radius, dome = 0.5 * dimensions.pole_diameter, dimensions.pole_diameter
    height = dimensions.pole_height
    angles = np.linspace(0.0, 0.5 * math.pi, segments // 4 + 1)
    # Each strip runs upwards or outwards: radii, heights, normals' parts outwards and upwards.
    return _revolve(segments, [
        ([0.0, radius], [0.0, 0.0], [0.0, 0.0], [-1.0, -1.0]),
        ([radius, radius], [0.0, height], [1.0, 1.0], [0.0, 0.0]),
        ([radius, dome], [height, height], [0.0, 0.0], [-1.0, -1.0]),
        (dome * np.cos(angles), height + dome * np.sin(angles), np.cos(angles), np.sin(angles))])


@functools.lru_cache(maxsize=8)
def platform_mesh(dimensions: Dimensions, segments: int) -> Mesh:
    """Build the platform about the origin; its hole has as many chords as the pole."""
    segments = _check_segments(segments)
    radius, half = 0.5 * dimensions.pole_diameter, 0.5 * dimensions.platform_side
    height = dimensions.platform_height
    wall = _revolve(segments, [([radius, radius], [height, 0.0], [-1.0, -1.0], [0.0, 0.0])])
    square = half * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    outline = np.vstack([square, radius * _circle(segments)])
    cut = _around_hole(segments)
    parts = [wall,
             _flat(outline, height, 1.0, cut),
             _flat(outline, 0.0, -1.0, cut[:, ::-1])]
    for side in range(4):
        parts.append(_upright(square[side], square[(side + 1) % 4], height))
    return _join(parts)


@functools.cache
def ground_mesh() -> Mesh:
    """Build the ground: a disc about the origin, which looks up."""
    level, up = [0.0] * len(GROUND_RINGS), [1.0] * len(GROUND_RINGS)
    return _revolve(GROUND_SEGMENTS, [(GROUND_RINGS, level, level, up)])


def _check_segments(segments):
    segments = checks.whole('segments', segments, FEWEST_SEGMENTS, MOST_SEGMENTS)
    checks.require(segments % 4 == 0, 'segments', 'a multiple of four', segments)
    return segments


def _circle(segments):
    """Return the corners of a regular polygon of radius 1: (segments, 2)."""
    angles = 2.0 * math.pi / segments * np.arange(segments)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _revolve(segments, strips):
    """
    Turn profiles about the z axis.

    strips: for each its radii, heights and the normals' parts outwards and upwards, all (k,);
    the front is to the right of the way along the profile (out of a wall that goes up).
    """
    circle = _circle(segments)
    here = np.arange(segments)
    beside = (here + 1) % segments
    parts = []
    for radii, heights, outwards, upwards in strips:
        vertices = [np.column_stack([r * circle, np.full(segments, z)])
                    for r, z in zip(radii, heights)]
        normals = [np.column_stack([out * circle, np.full(segments, up)])
                   for out, up in zip(outwards, upwards)]
        triangles = []
        for ring in range(len(radii) - 1):
            low, high = ring * segments, (ring + 1) * segments
            # Where a ring has shrunk to the axis, one triangle of each pair is a line.
            if radii[ring] > 1e-9 * max(radii):
                triangles.append(np.column_stack([low + here, low + beside, high + here]))
            if radii[ring + 1] > 1e-9 * max(radii):
                triangles.append(np.column_stack([high + beside, high + here, low + beside]))
        parts.append((np.vstack(vertices), np.vstack(triangles), np.vstack(normals)))
    return _join(parts)


def _around_hole(segments):
    """
    Cut a square with a round hole in triangles: corners are 0 to 3, the hole's 4 and on.

    Each corner sees the quarter of the hole in its quadrant, and each side of the square sees the
    hole's corner between two quadrants.
    """
    triangles = []
    for corner in range(4):
        first = corner * segments // 4
        for k in range(first, first + segments // 4):
            triangles.append((corner, 4 + (k + 1) % segments, 4 + k))
        triangles.append(((corner - 1) % 4, corner, 4 + first))
    return np.array(triangles)


def _flat(outline, height, up, triangles):
    """Lay the points `outline` (n, 2) at `height`, facing up (1.0) or down (-1.0)."""
    vertices = np.column_stack([outline, np.full(len(outline), height)])
    return vertices, triangles, np.tile([0.0, 0.0, up], (len(outline), 1))


def _upright(begin, end, height, base=0.0):
    """Raise a wall from `begin` to `end` (2,), its front to the right of the way."""
    (bx, by), (ex, ey) = begin, end
    vertices = np.array(
        [[bx, by, base], [ex, ey, base], [ex, ey, height], [bx, by, height]])
    triangles = np.array([[0, 1, 2], [2, 3, 0]])
    return vertices, triangles, np.tile([ey - by, bx - ex, 0.0], (4, 1))


def _join(parts):
    """Put meshes, or triples of vertices, triangles and normals, into one mesh."""
    vertices, triangles, normals, count = [], [], [], 0
    for part in parts:
        if isinstance(part, Mesh):
            part = part.vertices, part.triangles, part.normals
        vertices.append(part[0])
        triangles.append(np.add(part[1], count))
        normals.append(part[2])
        count += len(part[0])
    arrays = (np.ascontiguousarray(np.vstack(vertices), dtype=np.float64),
              np.ascontiguousarray(np.vstack(triangles), dtype=np.int32),
              np.ascontiguousarray(np.vstack(normals), dtype=np.float64))
    for array in arrays:
        array.flags.writeable = False  # so that whoever draws it may keep it
    return Mesh(*arrays)
