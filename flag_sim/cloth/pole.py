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

"""The pole that the cloth stays out of, as users give it and as kernels get it."""
import math

from flag_sim.cloth.contact import NO_POLE
from flag_sim.cloth.records import Vector
from flag_sim.parameters import checks

MAX_HOIST = 1e6
"""Greatest coordinate of the hoist, and of the pole [m]."""


def checked_pole(pole: Vector | None, hoist_top: Vector, pinned: bool) -> Vector | None:
    """
    Return a pole (x, y, radius) [m], or None where there is none.

    Raises ValueError for what is no pole, and for one with a pinned hoist inside: cloth could
    leave it only through its side.
    """
    if pole is None:
        return None
    pole = checks.vector('pole', pole, MAX_HOIST)
    checks.finite('radius of the pole', pole[2], above=0.0)
    if pinned:
        x, y, radius = pole
        distance = math.hypot(hoist_top[0] - x, hoist_top[1] - y)
        if distance < radius * (1.0 - 1e-9):
            raise ValueError(f'the hoist must not be inside the pole: it is '
                             f'{checks.text(distance)} m from the axis, whose radius is '
                             f'{checks.text(radius)} m')
    return pole


def relative_pole(pole: Vector | None, origin: Vector) -> Vector:
    """Return a pole as Forcing has it, measured from where positions are."""
    if pole is None:
        return NO_POLE
    x, y, radius = pole
    return x - origin[0], y - origin[1], radius
