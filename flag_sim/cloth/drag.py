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
Drag laws: the force of the wind on a face, and how it is kept from overshooting in a step.

With the flux u . a [m3/s] of the wind u that a face of area A feels through its area vector a, the
normal wind is u_n = flux / A, and the force along the normal is F = drag s u_n. The laws differ in
s, and so in how fast F grows with u_n:

    law         s        dF/du_n / drag
    quadratic   |flux|   2 |flux|
    linear      A        A                 s in m3/s: A times 1 m/s
    seed        1        0                 n (n . w), eq. 1.3 as published: w is not relative

Explicit steps overshoot once h is longer than m / (dF/du_n), so F is divided by 1 + r^order,
r = h dF/du_n / m. For order 1 that is drag taken implicitly, linearised (Rosenbrock). It changes F
by the fraction r^order, which is of the same order in h as the method's own error.

What is left, as rate h d(F / (1 + r^order))/du_n / m of a step, is at most

    linear      r / (1 + r^p), greatest where r^p = 1 / (p - 1), for p = 1 where r is infinite
    quadratic   r (1 + (1 - p/2) r^p) / (1 + r^p)^2, as r itself grows with u_n

whatever the wind, the air and the cloth's mass: the methods leave room for that much in their
stable steps. With p = 4 and r above 1 the quadratic law's rate is negative, down to -0.17: the
force still is against the wind, but falls as that grows.

Equation 1.3 as published does not damp any motion, and needs no room. The speed that it gives is
bounded only by its size, at most 2 |w| newtons on a node, as the shares of six faces sum up to 2:
the root of the kinetic energy then grows at most linearly in time, as it does in free fall.
"""
import math

from flag_sim.jit.kernels import inner_kernel

QUADRATIC, LINEAR, SEED = 0, 1, 2
"""The drag laws by number, for the kernels."""
DRAG_LAWS = {'quadratic': QUADRATIC, 'linear': LINEAR, 'seed': SEED}
"""The drag laws by the names that users choose them by."""

GREATEST_RATE = {
    'quadratic': {1: 1.0 / 2.0, 2: 3.0**1.5 / 16.0, 4: 0.4197},
    'linear': {1: 1.0, 2: 1.0 / 2.0, 4: 3.0**0.75 / 4.0},
    'seed': {1: 0.0, 2: 0.0, 4: 0.0}}
"""The greatest rate left over a step, by the law and the method's order; see above."""


@inner_kernel
def drag_factor(flux: float, area2: float, law: int) -> tuple[float, float]:
    """Return s and (dF/du_n) / drag of a face, both [m3/s], given the flux and A squared [m4]."""
    if law == QUADRATIC:
        s = abs(flux)
        return s, s + s
    if law == LINEAR:
        area = math.sqrt(area2)
        return area, area
    number = type(flux)
    return number(1.0), number(0.0)


@inner_kernel
def divisor(r: float, order: int) -> float:
    """Return 1 + r^order, for a method of order 1, 2 or 4."""
    if order > 1:
        r = r * r
    if order > 2:
        r = r * r
    return type(r)(1.0) + r
