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

"""Checks of what people give for a picture: angles, colours, switches, arrays of points."""
import math

from flag_sim.parameters import checks

import numpy as np

# Angles [rad] go to a turn either way, or from straight down to straight up: what is beyond is
# most often meant in degrees.
TURN, QUARTER = 2.0 * math.pi, 0.5 * math.pi


def angles(record, names, most: float) -> None:
    """Make fields of a frozen dataclass floats from -most to most [rad], or raise ValueError."""
    for name in names:
        angle = checks.finite(f'{name} [rad]', getattr(record, name), -most, most)
        object.__setattr__(record, name, angle)


def levels(record, name: str) -> None:
    """
    Make a field of a frozen dataclass a colour: three floats from 0 to 255.

    Raises ValueError for what is no such colour, and for one whose channels all are from 0 to 1,
    but for black: nobody wants to see that, and other programs count from 0 to 1.
    """
    colour = checks.colour(name, getattr(record, name))
    checks.require(not 0.0 < max(colour) <= 1.0, name,
                   'red, green and blue from 0 to 255, one of them above 1 unless all are 0',
                   colour)
    object.__setattr__(record, name, colour)


def switches(record, names) -> None:
    """Make fields of a frozen dataclass True or False, or raise ValueError."""
    for name in names:
        object.__setattr__(record, name, checks.boolean(name, getattr(record, name)))


def numbers(name: str, value) -> np.ndarray:
    """
    Return value as an array of real numbers, some of which may be nan or infinite.

    Raises ValueError for other types, and for lists of unequal length.
    """
    try:
        array = np.asarray(value)
    except ValueError:
        raise ValueError(f'{name} must be an array of real numbers, not {value!r}') from None
    if array.dtype.kind not in 'fiu':
        checks.require(False, name, 'an array of real numbers',
                       value if array.dtype.kind == 'O' else array.dtype.name)
    return array


def points(name: str, value, shape: tuple) -> np.ndarray:
    """
    Return value as an array of real numbers of a shape, in which None stands for any length.

    Raises ValueError for other shapes and types (see numbers).
    """
    array = numbers(name, value)
    is_fit = len(array.shape) == len(shape)
    for want, have in zip(shape, array.shape):
        is_fit &= want is None or want == have
    if not is_fit:
        shown = str(shape).replace('None', 'any')
        checks.require(False, name, f'of shape {shown}', array.shape)
    return array
