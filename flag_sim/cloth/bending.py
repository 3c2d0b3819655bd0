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
The plate: resistance to bending, linear in the positions.

Springs between nodes two apart would not do: their length changes with the square of the
curvature, their energy with its fourth power, and no choice of constants makes them one plate at
every resolution. So the energy is taken from the second differences themselves,

    E = B/2 sum over nodes of (|x_uu|^2 + |x_vv|^2 + 2 |x_uv|^2) dx dy,

u along rows and v down columns. For a sheet that bends without stretching it is the energy of a
plate, B/2 (curvature)^2 per area, in whatever direction it is rolled; the mixed term sees to that.
It is zero in any flat state and does not change when the sheet moves or turns.

It is Kirchhoff's plate with Poisson's ratio zero, B/2 ((w_uu + w_vv)^2 - 2 (w_uu w_vv - w_uv^2))
for a deflection w. The quadratic bending of Bergou, Wardetzky, Harmon, Zorin and Grinspun (A
Quadratic Bending Model for Inextensible Surfaces, 2006) is the first of the two terms alone,
|x_uu + x_vv|^2. The second is the Gaussian curvature, whose integral depends on the edges alone:
the forces inside are the same. But a free edge here bears a moment of the curvature across it
alone, and a twist w = t u v costs B t^2 per area, where the first term costs nothing.
"""
from flag_sim.cloth.records import Band, Field, NEXT, Vector, Weights
from flag_sim.jit.kernels import inner_kernel, lean_kernel, wide_kernel
import numpy as np


def bend_constants(bend_stiffness: float, dx: float, dy: float) -> Vector:
    """
    Return (across, down, twist) constants [N/m] of second differences on cells of dx by dy [m].

    x_uu = (difference) / dx2 and so on; squared, times the cell's area.
    """
    return (bend_stiffness * dy / dx**3,
            bend_stiffness * dx / dy**3,
            2.0 * bend_stiffness / (dx * dy))


@wide_kernel
def set_moments(position: Field, weights: Weights, bend: Vector, moments: tuple,
                band: Band) -> None:
    """
    Fill the moments [N] at each node: the constants times second differences of the positions.

    moments: for each axis x, y and z three flat arrays, across, down and twist. Differences of
    neighbours come first: they are exact where positions are rounded.
    """
    b_across, b_down, b_twist = bend
    x, y, z = position
    across_x, down_x, twist_x = moments[0]
    across_y, down_y, twist_y = moments[1]
    across_z, down_z, twist_z = moments[2]
    first, last, stride = band
    for i in range(first, last):
        e, w, s, n, d = i + NEXT, i - NEXT, i + stride, i - stride, i + stride + NEXT
        b = b_across * weights.bend_across[i]
        across_x[i] = b * ((x[e] - x[i]) - (x[i] - x[w]))
        across_y[i] = b * ((y[e] - y[i]) - (y[i] - y[w]))
        across_z[i] = b * ((z[e] - z[i]) - (z[i] - z[w]))
        b = b_down * weights.bend_down[i]
        down_x[i] = b * ((x[s] - x[i]) - (x[i] - x[n]))
        down_y[i] = b * ((y[s] - y[i]) - (y[i] - y[n]))
        down_z[i] = b * ((z[s] - z[i]) - (z[i] - z[n]))
        b = b_twist * weights.cell[i]
        twist_x[i] = b * ((x[i] - x[e]) - (x[s] - x[d]))
        twist_y[i] = b * ((y[i] - y[e]) - (y[s] - y[d]))
        twist_z[i] = b * ((z[i] - z[e]) - (z[s] - z[d]))


@inner_kernel
def bending_force(moments: tuple, i: np.uint64, stride: np.uint64) -> float:
    """
    Return the force [N] of bending on node i along one axis: minus the gradient of E.

    moments: across, down and twist [N] of that axis. The force is the same differences of the
    moments as these are of the positions.
    """
    across, down, twist = moments
    e, w, s, n = i + NEXT, i - NEXT, i + stride, i - stride
    return -(((across[e] - across[i]) - (across[i] - across[w]))
             + ((down[s] - down[i]) - (down[i] - down[n]))
             + ((twist[i] - twist[w]) - (twist[n] - twist[n - NEXT])))


@lean_kernel
def add_bending_forces(moments: tuple, force: Field, band: Band) -> None:
    """Add the force of bending [N] on each node; moments: as set_moments fills them."""
    for axis in range(3):
        _add_along(moments[axis], force[axis], band)


@wide_kernel
def _add_along(moments, f, band):
    first, last, stride = band
    for i in range(first, last):
        f[i] += bending_force(moments, i, stride)
