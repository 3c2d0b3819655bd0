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

"""Refusal of bad numbers, with a message that names the rule and the value."""
import math

import numpy as np

LARGEST = 1e12
"""Beyond any physical value; keeps products and roots of the dials far from overflow."""


def finite(name, value, low=-LARGEST, high=LARGEST, above=None):
    """
    Return value as a float.

    Raises ValueError unless it is a finite number, low <= value <= high and value > above.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f'{name} must be a number, not {value!r}') from None
    if not math.isfinite(number):
        raise ValueError(f'{name} must be finite, not {number}')
    if above is not None and not number > above:
        raise ValueError(f'{name} must be greater than {above:g}, not {number:g}')
    if not low <= number <= high:
        raise ValueError(f'{name} must be between {low:g} and {high:g}, not {number:g}')
    return number


def fields(record, names, prefix='', **limits):
    """Make fields of a frozen dataclass floats within limits, or raise ValueError (see finite)."""
    for name in names:
        object.__setattr__(record, name, finite(prefix + name, getattr(record, name), **limits))


def whole(name, value, low, high):
    """Return value as an int; raises ValueError unless it is whole and low <= value <= high."""
    number = finite(name, value)
    if number != int(number):
        raise ValueError(f'{name} must be a whole number, not {number:g}')
    if not low <= number <= high:
        raise ValueError(f'{name} must be between {low} and {high}, not {int(number)}')
    return int(number)


def wholes(record, names, low, high):
    """Make fields of a frozen dataclass ints within limits, or raise ValueError (see whole)."""
    for name in names:
        object.__setattr__(record, name, whole(name, getattr(record, name), low, high))


def instance(name, value, kind):
    """Return value; raises ValueError unless it is of the kind, a class."""
    if not isinstance(value, kind):
        raise ValueError(f'{name} must be of class {kind.__name__}, not {value!r}')
    return value


def choice(name, value, choices):
    """Return value; raises ValueError unless it is one of the choices, which are words."""
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f'{name} must be one of {sorted(choices)}, not {value!r}')
    return value


def vector(name, value, largest):
    """Return value as three floats; raises ValueError unless they are at most largest in size."""
    numbers = array(name, value, (3,), largest)
    return tuple(float(number) for number in numbers)


def array(name, value, shape, largest=LARGEST):
    """
    Return value as a float64 array.

    Raises ValueError unless it has the shape and all its numbers are at most largest in size.
    """
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f'{name} must hold numbers, not {value!r}') from None
    if numbers.shape != shape:
        raise ValueError(f'{name} must have shape {shape}, not {numbers.shape}')
    if not np.all(np.abs(numbers) <= largest):
        raise ValueError(f'{name} must be finite and at most {largest:g} in size')
    return numbers
