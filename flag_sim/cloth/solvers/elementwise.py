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

A field here is x, y and z at each node, three flat arrays (see records), of one unit. Sums are
made node after node: in vectors, a fifth faster for the methods with sums in them, their order and
so their last digits would be those of one kind of processor.
"""
from flag_sim.cloth.records import Band, Field
from flag_sim.jit.kernels import inner_kernel, wide_kernel
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


@inner_kernel
def dot(a: Field, b: Field, band: Band) -> float:
    """Return the sum of a . b over all nodes, in float64 whatever the fields are."""
    ax, ay, az = a
    bx, by, bz = b
    first, last, _ = band
    total = 0.0
    for i in range(first, last):
        total += (np.float64(ax[i]) * bx[i] + np.float64(ay[i]) * by[i]
                  + np.float64(az[i]) * bz[i])
    return total


@inner_kernel
def norm2(a: Field, weight: np.ndarray, band: Band) -> float:
    """Return the sum of weight a . a over all nodes, in float64 whatever the fields are."""
    x, y, z = a
    first, last, _ = band
    total = 0.0
    for i in range(first, last):
        ax, ay, az = np.float64(x[i]), np.float64(y[i]), np.float64(z[i])
        total += weight[i] * (ax * ax + ay * ay + az * az)
    return total
