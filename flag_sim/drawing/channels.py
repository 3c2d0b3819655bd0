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

"""Attributes that people ask for beside the colour, and how all are laid out for the kernels."""
import dataclasses

from flag_sim import checks
from flag_sim.drawing import ranges
from flag_sim.drawing.attributes import THREE, Values
from flag_sim.drawing.lanes import CHANNELS

import numpy as np

AT = ('vertices', 'triangles')
INTERPOLATIONS = ('screen', 'perspective')


@dataclasses.dataclass(frozen=True, eq=False)
class Attribute:
    """
    Values of a scene that become an image: normals, texture coordinates, labels, anything.

    values: for each object of the scene an array of as many numbers as it has `at`, (n, channels)
    or, where the two sides have others, (n, 2, channels), the front first; at: one of AT;
    interpolation: between vertices, 'perspective' is linear in space, 'screen' from pixel to
    pixel; nothing: what pixels show where nothing is. A triangle cut by the near plane is
    linear on the screen in parts. Raises ValueError for other words, shapes and types.
    """

    values: list
    at: str = 'vertices'
    interpolation: str = 'perspective'
    nothing: float = np.nan

    def __post_init__(self):
        """Refuse what cannot be interpolated."""
        checks.choice('at', self.at, AT)
        checks.choice('interpolation', self.interpolation, INTERPOLATIONS)
        checks.require(isinstance(self.nothing, (int, float)), 'nothing', 'a number', self.nothing)
        checks.require(isinstance(self.values, (list, tuple)) and len(self.values) > 0, 'values',
                       'a list with an array for each object', self.values)
        object.__setattr__(self, 'values', [self._two_sided(k, values)
                                            for k, values in enumerate(self.values)])

    def _two_sided(self, number, values):
        array = np.asarray(values)
        name = f'values[{number}]'
        shape = (None, 2, None) if array.ndim == 3 else (None, None)
        array = ranges.points(name, array, shape)
        array = array if array.ndim == 3 else np.repeat(array[:, None], 2, axis=1)
        if number:
            checks.require(array.shape[2] == self.values[0].shape[-1], name,
                           f'of {self.values[0].shape[-1]} channels as values[0]', array.shape[2])
        checks.require(array.shape[2] > 0, name, 'of at least one channel', array.shape)
        return array

    @property
    def channels(self) -> int:
        """How many numbers a pixel shows."""
        return self.values[0].shape[2]


class Layout:
    """
    Where attributes stand in Values: the colour's group first, then those of the others.

    colours: (points or triangles, 2, CHANNELS) float32, for the frame's shading to write; names:
    {name: (first group, channels)} of the others.
    """

    def __init__(self, shape, is_flat, attributes):
        """Lay out for a scene of shape (points, triangles), colours of triangles if is_flat."""
        self.kind = shape, is_flat, [
            (name, one.channels, one.at) for name, one in attributes.items()]
        sizes = dict(zip(AT, shape))
        places, self.names = [AT[is_flat]], {}
        for name, one in attributes.items():
            self.names[name] = len(places), one.channels
            places += [one.at] * -(-one.channels // THREE)
        lengths = [2 * CHANNELS * sizes[at] for at in places]
        self._first = np.cumsum([0] + lengths[:-1]).astype(np.uint64)
        self._numbers = np.zeros(sum(lengths), np.float32)
        self._at_triangles = np.array([at == 'triangles' for at in places])
        self._groups = [self._numbers[first:first + length].reshape(-1, 2, CHANNELS)
                        for first, length in zip(np.cumsum([0] + lengths[:-1]), lengths)]
        self.colours = self._groups[0]

    def values(self, attributes, parts, background, is_perspective) -> Values:
        """
        Return the Values of a frame, whose colours are still to be written.

        parts: of SceneBuffers; background: (3,) colour where nothing is; is_perspective: how
        colours are interpolated. Raises ValueError for values of other numbers than the objects'.
        """
        nothing = np.zeros((len(self._groups), CHANNELS), np.float32)
        nothing[0, :THREE] = background
        flags = np.full(len(self._groups), is_perspective)
        for name, one in attributes.items():
            first, channels = self.names[name]
            checks.require(len(one.values) == len(parts), name,
                           f'of values for {len(parts)} objects', len(one.values))
            for group in range(-(-channels // THREE)):
                some = slice(THREE * group, min(THREE * (group + 1), channels))
                width = some.stop - some.start
                for array, places in zip(one.values, parts):
                    place = places[AT.index(one.at)]
                    checks.require(len(array) == place.stop - place.start, name,
                                   f'of {place.stop - place.start} {one.at}', len(array))
                    self._groups[first + group][place, :, :width] = array[:, :, some]
                nothing[first + group, :THREE] = one.nothing
                flags[first + group] = one.interpolation == 'perspective'
        return Values(self._numbers, self._first, self._at_triangles, flags, nothing.ravel())
