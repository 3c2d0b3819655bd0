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
Attributes: any values of vertices or triangles, interpolated to the pixels that see them.

Normals, texture coordinates, labels, velocities: of any number of channels, and whatever they
are, from the Visibility of a frame alone.
"""
from flag_sim.drawing import ranges
from flag_sim.drawing.visibility import Visibility, weights_of
from flag_sim.jit.kernels import late_kernel
from flag_sim.parameters import checks

import numpy as np

INTERPOLATIONS = ('screen', 'perspective')


def interpolate(visibility: Visibility, values: np.ndarray | list, at: str = 'vertices',
                interpolation: str = 'perspective', nothing: float = np.nan) -> np.ndarray:
    """
    Return what pixels show of an attribute: (height, width, channels) float32.

    values: a list of arrays, one for each object of the scene, or one array for all: (n, channels)
    at vertices or, where `at` is 'triangles', (m, channels) of these; where the two sides differ,
    (n, 2, channels), the front first. interpolation: 'perspective' is linear in space, 'screen'
    linear from pixel to pixel, except where a triangle reaches behind the eye. nothing: what
    pixels show where nothing is. No value leaves the range of its triangle's vertices.
    Raises ValueError for other words, shapes and types, and for what float32 cannot hold.
    """
    checks.instance('visibility', visibility, Visibility)
    checks.choice('at', at, ('vertices', 'triangles'))
    checks.choice('interpolation', interpolation, INTERPOLATIONS)
    nothing = ranges.single('nothing', ranges.number('nothing', nothing))
    parts = values if isinstance(values, (list, tuple)) else [values]
    checks.require(len(parts) > 0, 'values', 'one array or one for each object', values)
    parts = [_two_sided(f'values[{number}]', part) for number, part in enumerate(parts)]
    checks.require(len({part.shape[2] for part in parts}) == 1, 'values',
                   'of as many channels for each object', [part.shape[2] for part in parts])
    joined = np.concatenate(parts)
    count = len(visibility.depths if at == 'vertices' else visibility.corners)
    checks.require(len(joined) == count, 'values', f'for all {count} {at} of the scene',
                   len(joined))
    image = np.empty((*visibility.triangles.shape, joined.shape[2]), np.float32)
    _interpolate(visibility, joined, at == 'triangles', interpolation == 'screen', nothing, image)
    return image


def _two_sided(name, values):
    """Return values as (n, 2, channels) float64."""
    array = ranges.numbers(name, values)
    array = ranges.points(name, array, (None, 2, None) if array.ndim == 3 else (None, None))
    array = array if array.ndim == 3 else np.repeat(array[:, None], 2, axis=1)
    return np.ascontiguousarray(ranges.single(name, array), dtype=np.float64)


@late_kernel
def _interpolate(visibility, values, at_triangles, is_on_screen, nothing, image):
    triangles, is_back, weights, corners, depths = visibility
    for row in range(image.shape[0]):
        for column in range(image.shape[1]):
            t = triangles[row, column]
            if t < 0:
                image[row, column] = nothing
                continue
            side = 1 if is_back[row, column] else 0
            a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
            of_a, of_b, of_c = weights_of(weights, row, column)
            if is_on_screen and min(depths[a], depths[b], depths[c]) > 0.0:
                # Weights in space are those on the screen over depth, brought to a sum of 1.
                of_a, of_b, of_c = of_a * depths[a], of_b * depths[b], of_c * depths[c]
                total = of_a + of_b + of_c
                of_a, of_b, of_c = of_a / total, of_b / total, of_c / total
            for channel in range(image.shape[2]):
                if at_triangles:
                    image[row, column, channel] = values[t, side, channel]
                else:
                    at_a, at_b = values[a, side, channel], values[b, side, channel]
                    at_c = values[c, side, channel]
                    value = of_a * at_a + of_b * at_b + of_c * at_c
                    least, most = min(at_a, at_b, at_c), max(at_a, at_b, at_c)
                    image[row, column, channel] = min(max(value, least), most)
