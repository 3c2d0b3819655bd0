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
How many steps a frame needs so that the cloth cannot diverge, and what to give up if it may not.

The largest frequency of the mesh has a bound that no state exceeds. A spring's Hessian is at most
k along every axis, whatever its direction and stretch, so the mesh is never stiffer than the
scalar lattice of the same springs. On the infinite grid a wave of phases theta_x and theta_y has,
with p = 1 - cos(theta_x) and q = 1 - cos(theta_y), each from 0 to 2,

    m omega^2 = 2 k_x p + 2 k_y q + 4 k_d (p + q - p q) + 4 b_x p^2 + 4 b_y q^2 + 4 b_xy p q,

which is convex in p and in q and so greatest in a corner, where p and q are 0 or 2. Borders add
nothing: their half weights go with half masses, so that the same waves, standing, are the modes of
the bounded grid; pins only take modes away. (Irons and Treharne, A Bound Theorem in
Eigenvalues, 1971, is the argument for elements.)
"""
from collections.abc import Callable
import math
from typing import NamedTuple

from flag_sim.cloth.model import Model
from flag_sim.cloth.stepping import Stepping


SHORTEST_STEP = {'float64': 0.0, 'float32': 1e-5}
"""
Shortest step [s] that the precision of the positions resolves.

Each step rounds them, in float32 by up to 0.1 micrometres two metres from the hoist: that is what
a node of 1 cm/s moves in 10 microseconds. More steps would make the motion worse, not better.
"""


class Plan(NamedTuple):
    """The steps of a frame; factors below 1 tell by how much the cloth had to be softened."""

    demanded: int            # steps that the material needs to be stable
    granted: int             # steps that are taken
    stiffness_factor: float  # of springs and bending
    damping_factor: float    # of the springs' dashpots


def frequency_bound(model: Model) -> float:
    """Return an upper bound of the mesh's largest angular frequency [rad/s], in every state."""
    return math.sqrt(_largest_wave(model.spring_k, model.bend) / model.cell_mass)


def membrane_frequency_bound(model: Model) -> float:
    """Return an upper bound of the largest angular frequency [rad/s] of the springs alone."""
    return math.sqrt(_largest_wave(model.spring_k, (0.0, 0.0, 0.0)) / model.cell_mass)


def damping_bound(model: Model) -> float:
    """Return an upper bound of the rate at which the dashpots slow a node down [1/s]."""
    return _largest_wave(model.spring_c, (0.0, 0.0, 0.0)) / model.cell_mass


def _largest_wave(spring, bend):
    """Return the greatest m omega^2 of the module's formula, for springs or for dashpots."""
    across, down, diagonal = spring
    bend_across, bend_down, twist = bend
    return max(4.0 * across + 8.0 * diagonal + 16.0 * bend_across,
               4.0 * down + 8.0 * diagonal + 16.0 * bend_down,
               4.0 * (across + down) + 16.0 * (bend_across + bend_down + twist))


def plan(dt: float, omega: float, gamma: float, largest_step: Callable, stepping: Stepping,
         useful_step: float = math.inf, shortest_step: float = 0.0) -> Plan:
    """
    Divide a frame of dt [s] into steps.

    omega, gamma: the bounds above. largest_step(omega, gamma) and useful_step: the solver's [s].
    shortest_step: the precision's [s].

    Over budget, the cloth is softened to what the granted steps carry. First its damping beyond
    the critical, 2 omega, is given up, since what is overdamped already creeps; then stiffness,
    and damping with its root, which keeps the damping ratio. As largest_step has the dimension of
    time, lowering omega and gamma by a factor lengthens it by the same.
    """
    demanded = _count(dt / min(stepping.step_safety * largest_step(omega, gamma), useful_step))
    limit = stepping.substeps_limit
    if shortest_step > 0.0:
        limit = min(limit, max(1, math.floor(dt / shortest_step * (1.0 + 1e-12))))
    granted = min(max(demanded, stepping.substeps), limit)
    if granted >= demanded:
        return Plan(demanded, granted, 1.0, 1.0)
    needed = dt / (granted * stepping.step_safety)
    if largest_step(omega, gamma) >= needed:
        return Plan(demanded, granted, 1.0, 1.0)
    kept = min(gamma, 2.0 * omega)
    if largest_step(omega, kept) >= needed:
        kept = _bisect(lambda rate: largest_step(omega, rate) >= needed, kept, gamma)
        return Plan(demanded, granted, 1.0, kept / gamma)
    factor = largest_step(omega, kept) / needed
    return Plan(demanded, granted, factor**2, factor * kept / gamma if gamma > 0.0 else 1.0)


def _count(ratio):
    """Return the steps for a ratio of times: whole, at least one, forgiving the last bits."""
    return max(1, math.ceil(ratio * (1.0 - 1e-12)))


def _bisect(is_enough, low, high):
    """Return the greatest value known to be enough, between low, which is, and high."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_enough(middle) else (low, middle)
    return low
