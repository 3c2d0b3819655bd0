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

"""Checks of arrays of points that people give for a picture."""
from flag_sim.parameters import checks
import numpy as np

MOST_SINGLE = float(np.finfo(np.float32).max)
"""The greatest number that float32 holds."""


def numbers(name: str, value) -> np.ndarray:
    """
    Return value as an array of real numbers, some of which may be nan or infinite.

    Raises ValueError for other types, and for lists of unequal length.
    """
    try:
        array = np.asarray(value)
    except ValueError:
        array = None
    if array is None or array.dtype.kind not in 'fiu':
        checks.require(False, name, 'an array of real numbers', value)
    return array


def number(name: str, value) -> float:
    """Return value as a float, which may be nan or infinite; raises ValueError for other types."""
    try:
        array = numbers(name, value)
    except ValueError:
        array = None
    if array is None or array.ndim:
        checks.require(False, name, 'a number', value)
    return float(array)


def single(name: str, values: np.ndarray | float) -> np.ndarray | float:
    """Return values; raises ValueError for finite ones that are beyond float32's range."""
    # Of float64: float16 has no such number to be compared with.
    bad = np.extract(np.isfinite(values) & (np.abs(values) > np.float64(MOST_SINGLE)), values)
    if bad.size:
        checks.require(False, name, f'at most {MOST_SINGLE:.6g} in size, as float32 holds it',
                       float(bad[0]))
    return values


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
