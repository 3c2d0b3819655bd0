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
Shapes of what stands still: the pole and the platform of the source's scene (sec. 1.2), and a box.

All are closed meshes. The world's origin is the centre of the pole's base, which is the centre of
the platform's lower face; z is up. All round things share their angles, so that the pole fills
the platform's hole without a gap. Hard edges repeat their vertices, one for each face that meets
there.
"""
from collections.abc import Sequence
import dataclasses
import functools
import math

from flag_sim.drawing.camera import Camera
from flag_sim.drawing.mesh import Mesh
from flag_sim.parameters import checks
from flag_sim.parameters.declared import Declared, declared

import numpy as np

# A circle is cut so finely that its chords miss it by at most this [pixel] ...
ROUNDNESS = 0.2
# ... but neither more coarsely nor more finely than this (both divisible by four: the platform's
# corners each see a quarter of the hole).
FEWEST_SEGMENTS = 8
MOST_SEGMENTS = 256
# Rings of the ground [m]: small near the pole, where shadows fall, so that single precision tells
# places in them apart.
GROUND_RINGS = (1000.0, 300.0, 100.0, 30.0, 10.0, 3.0, 0.0)
GROUND_SEGMENTS = 64


@dataclasses.dataclass(frozen=True)
class Dimensions(Declared):
    """
    Dimensions [m] of the pole and the platform, and whether they and the ground are seen.

    The pole is a cylinder of pole_height with a dome on top, a half sphere whose RADIUS is the
    cylinder's DIAMETER, closed below by a flat ring. The platform is a square box of
    platform_side and platform_height with a hole of the pole's radius through its middle.
    Raises ValueError for a value out of its range, and for a hole wider than the platform.
    """

    pole_height: float = declared(9.0, 'height of the pole without its tip', 'm', 0.1, 1000.0,
                                  name='pole.height')
    pole_diameter: float = declared(0.1, 'diameter of the pole; radius of its tip', 'm',
                                    0.001, 10.0, name='pole.diameter')
    platform_side: float = declared(1.0, 'side of the platform, a square', 'm', 0.01, 100.0,
                                    name='platform.side')
    platform_height: float = declared(0.3, 'height of the platform', 'm', 0.01, 100.0,
                                      name='platform.height')
    pole_visible: bool = declared(True, 'draw the pole', name='pole.visible')
    platform_visible: bool = declared(True, 'draw the platform', name='platform.visible')
    ground_visible: bool = declared(False, 'draw the ground, a disc of 1 km around the pole',
                                    name='ground.visible')

    def __post_init__(self):
        """Refuse what cannot be built."""
        super().__post_init__()
        check_hole(self.platform_side, self.pole_diameter)

    def segments(self, camera: Camera) -> int:
        """
        Return in how many chords to cut a circle for `camera`: a multiple of four.

        The dome's circle, the widest, is measured where the pole is nearest to the camera.
        """
        checks.instance('camera', camera, Camera)
        radius = self.pole_diameter
        x, y, z = camera.position
        beside = max(z - self.pole_height, -z, 0.0)
        nearest = max(math.hypot(x, y, beside) - radius, 0.0)
        pixels = radius * camera.pixels_per_metre(nearest)
        # The height of a chord's arc, r (1 - cos(pi / n)), is about r (pi / n)^2 / 2.
        wanted = math.pi * math.sqrt(min(0.5 * pixels / ROUNDNESS, MOST_SEGMENTS ** 2))
        return min(max(4 * math.ceil(wanted / 4), FEWEST_SEGMENTS), MOST_SEGMENTS)


def check_hole(side: float, diameter: float, names=('platform_side', 'pole_diameter')) -> None:
    """Raise ValueError, by these names, unless a platform is wider than its pole [m]."""
    checks.require(side > diameter, names[0], f'greater than {names[1]} {diameter}', side)


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


@functools.lru_cache(maxsize=8)
def pole_mesh(dimensions: Dimensions, segments: int) -> Mesh:
    """
    Build the pole with round parts of `segments` chords, a multiple of four.

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
    """Build the platform with a hole of `segments` chords, as many as the pole's."""
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
