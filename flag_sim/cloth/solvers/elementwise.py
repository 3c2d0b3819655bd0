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
Sums and products of fields, node by node: what the methods put their steps together from.

A field here is x, y and z at each node, three flat arrays (see records), of one unit.
"""
from flag_sim.cloth.records import Band, Field
from flag_sim.jit.kernels import wide_kernel
import numpy as np


@wide_kernel
def fill(field: Field, value: float, band: Band) -> None:
    """Set a field to one value."""
    first, last, _ = band
    for axis in range(3):
        f = field[axis]
        for i in range(first, last):
            f[i] = value


@wide_kernel
def copy(field: Field, out: Field, band: Band) -> None:
    """Set out to a field."""
    first, last, _ = band
    for axis in range(3):
        f, o = field[axis], out[axis]
        for i in range(first, last):
            o[i] = f[i]


@wide_kernel
def scale(field: Field, factor: float, band: Band) -> None:
    """Multiply a field by a factor."""
    first, last, _ = band
    for axis in range(3):
        f = field[axis]
        for i in range(first, last):
            f[i] *= factor


@wide_kernel
def add(field: Field, factor: float, other: Field, band: Band) -> None:
    """Add a factor times another field to a field."""
    first, last, _ = band
    for axis in range(3):
        f, o = field[axis], other[axis]
        for i in range(first, last):
            f[i] += factor * o[i]


@wide_kernel
def add_weighted(field: Field, factor: float, weight: np.ndarray, other: Field,
                 band: Band) -> None:
    """Add a factor times a weight of each node times another field to a field."""
    first, last, _ = band
    for axis in range(3):
        f, o = field[axis], other[axis]
        for i in range(first, last):
            f[i] += factor * weight[i] * o[i]


@wide_kernel
def set_weighted(weight: np.ndarray, field: Field, out: Field, band: Band) -> None:
    """Set out to a weight of each node times a field."""
    first, last, _ = band
    for axis in range(3):
        f, o = field[axis], out[axis]
        for i in range(first, last):
            o[i] = f[i] * weight[i]


@wide_kernel
def set_difference(a: Field, b: Field, out: Field, band: Band) -> None:
    """Set out to a - b."""
    first, last, _ = band
    for axis in range(3):
        u, v, o = a[axis], b[axis], out[axis]
        for i in range(first, last):
            o[i] = u[i] - v[i]


@wide_kernel
def set_sum(a: Field, factor: float, b: Field, out: Field, band: Band) -> None:
    """Set out to a + factor b."""
    first, last, _ = band
    for axis in range(3):
        u, v, o = a[axis], b[axis], out[axis]
        for i in range(first, last):
            o[i] = u[i] + factor * v[i]


@wide_kernel
def set_combination(f: float, a: Field, g: float, b: Field, out: Field, band: Band) -> None:
    """Set out to f a + g b."""
    first, last, _ = band
    for axis in range(3):
        u, v, o = a[axis], b[axis], out[axis]
        for i in range(first, last):
            o[i] = f * u[i] + g * v[i]
