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

"""Hands on the picture as changes of the camera's parameters. No Qt."""
from collections.abc import Callable
import math

SHIFT = 0.05
"""By how much of the picture's height one key press shifts it."""
ZOOM = 1.1
"""By how much one step of the wheel brings the camera nearer."""
TURN_PER_PIXEL = 0.008
"""How far a drag turns the camera [rad per logical pixel]."""
MOVED = ('camera.target', 'camera.distance', 'camera.scale', 'camera.azimuth',
         'camera.elevation')
"""The parameters that hands change."""

Read = Callable[[str], object]
"""Returns the value of a parameter of the renderer, None if it has none of that name."""


def shift(read: Read, right: float, up: float) -> dict[str, object]:
    """Return the changes that shift the view by parts of the picture's height."""
    azimuth, elevation = read('camera.azimuth'), read('camera.elevation')
    target = read('camera.target')
    if None in (azimuth, elevation, target):
        return {}
    height = _height(read)
    sine, cosine = math.sin(azimuth), math.cos(azimuth)
    # The picture's right and up in the world, for a camera without roll.
    across = -sine, cosine, 0.0
    along = (-math.sin(elevation) * cosine, -math.sin(elevation) * sine, math.cos(elevation))
    roll = read('camera.roll') or 0.0
    right, up = (right * math.cos(roll) + up * math.sin(roll),
                 up * math.cos(roll) - right * math.sin(roll))
    return {'camera.target': [t + height * (right * a + up * b)
                              for t, a, b in zip(target, across, along)]}


def zoom(read: Read, steps: float) -> dict[str, object]:
    """Return the changes that bring the camera nearer by steps of the wheel, or farther."""
    name = ('camera.scale' if read('camera.projection') == 'orthographic' else 'camera.distance')
    value = read(name)
    return {} if value is None else {name: max(value, 1e-3) * ZOOM ** -steps}


def turn(read: Read, right: float, down: float) -> dict[str, object]:
    """Return the changes of a drag by so many logical pixels: what is under the hand follows."""
    azimuth, elevation = read('camera.azimuth'), read('camera.elevation')
    if None in (azimuth, elevation):
        return {}
    elevation = elevation + TURN_PER_PIXEL * down
    return {'camera.azimuth': math.remainder(azimuth - TURN_PER_PIXEL * right, 2.0 * math.pi),
            'camera.elevation': min(max(elevation, -0.5 * math.pi), 0.5 * math.pi)}


def _height(read):
    """Return how many metres of world the height of the picture shows at the target."""
    if read('camera.projection') == 'orthographic':
        return read('camera.scale') or 1.0
    fov, distance = read('camera.vertical_fov') or 0.5, read('camera.distance') or 0.0
    return 2.0 * max(distance, 0.1) * math.tan(0.5 * fov)
