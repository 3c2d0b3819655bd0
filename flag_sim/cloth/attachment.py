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
The long range attachment: no node gets farther from the hoist than the cloth reaches.

Kim, Chentanez and Mueller-Fischer, Long Range Attachments, 2012: a node in column c stays within c
times a reach of the node that begins its row; one that does not is brought back straight, and
loses the velocity that took it there.
"""
import math

from flag_sim.cloth.contact import Limits
from flag_sim.cloth.records import Band, Nodes, Vector
from flag_sim.jit.kernels import lean_inner_kernel, lean_kernel
import numpy as np


@lean_inner_kernel
def bring_back(place: Vector, velocity: Vector, start: Vector,
               longest: float) -> tuple[Vector, Vector, float]:
    """
    Return (place, velocity, excess): within longest [m] of start, without what led out of that.

    excess: how far the node was beyond it [m], or zero.
    """
    dx, dy, dz = place[0] - start[0], place[1] - start[1], place[2] - start[2]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    zero = type(distance)(0.0)
    if not distance > longest:
        return place, velocity, zero
    dx, dy, dz = dx / distance, dy / distance, dz / distance
    out = max(velocity[0] * dx + velocity[1] * dy + velocity[2] * dz, zero)
    return ((start[0] + longest * dx, start[1] + longest * dy, start[2] + longest * dz),
            (velocity[0] - out * dx, velocity[1] - out * dy, velocity[2] - out * dz),
            distance - longest)


@lean_kernel
def attach(nodes: Nodes, limits: Limits, brought_back: np.ndarray, band: Band) -> None:
    """
    Bring back every node that is farther from its row's beginning than the cloth reaches.

    brought_back: a flat field, set to 1 where that was by more than rounding.
    """
    x, y, z = nodes.position
    vx, vy, vz = nodes.velocity
    number = type(limits.reach)
    first, last, stride = band
    for hoist in range(first, last, stride):
        start = x[hoist], y[hoist], z[hoist]
        for i in range(hoist, min(hoist + limits.columns, last)):
            longest = limits.reach * number(np.int64(i - hoist))
            if limits.free[i] > 0.0:
                place, v, excess = bring_back((x[i], y[i], z[i]), (vx[i], vy[i], vz[i]), start,
                                              longest)
                if excess > 0.0:
                    x[i], y[i], z[i] = place
                    vx[i], vy[i], vz[i] = v
                    if excess > limits.rounding:
                        brought_back[i] = number(1.0)
