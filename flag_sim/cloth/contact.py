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

"""Where nodes may be: out of the pole, and no farther from the hoist than the cloth reaches."""
import math
from typing import NamedTuple

from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Vector
from flag_sim.cloth.turning import in_steps, Turn
from flag_sim.jit.kernels import lean_inner_kernel
import numpy as np

NO_POLE = (0.0, 0.0, 0.0)
"""A pole of radius zero, which nothing can be inside of."""


class Limits(NamedTuple):
    """What keeps the nodes where they may be; measured as the state's positions."""

    pole: Vector       # x, y and radius [m] of an upright cylinder; no pole if that is zero
    rounding: float    # by how much a node may seem to be in the pole without being in it [m]
    reach: float       # how far from its row's beginning a node may be, a column [m]; or infinite
    cell: np.ndarray   # flat (mesh.size,): 1 where the node is a cell's upper hoist corner, or 0
    free: np.ndarray   # flat (mesh.size,): 1 where the node moves, or 0
    columns: np.uint64
    first: np.uint64   # the number of the mesh's first node
    turn: Turn         # of the pole in a step

    @classmethod
    def of(cls, mesh: Mesh, pole: Vector, stretch_limit: float) -> 'Limits':
        """
        Return the limits of a mesh, in its numbers.

        pole: x, y and radius [m]; NO_POLE where there is none. It is taken to be thicker by some
        units in the last place of the cloth's extent, so that what is rounded is still outside.
        stretch_limit: no node of a pinned mesh may get farther from the beginning of its row than
        1 + stretch_limit times its distance at rest. The pole does not turn.
        """
        x, y, radius = pole
        extent = mesh.length + mesh.width + radius + math.hypot(x, y)
        rounding = 4.0 * float(np.finfo(mesh.precision).eps) * extent
        if radius > 0.0:
            radius += 2.0 * rounding
        reach = (1.0 + stretch_limit) * mesh.dx if mesh.pinned else math.inf
        return cls(mesh.number((x, y, radius)), mesh.number(rounding), mesh.number(reach),
                   mesh.weights.cell, mesh.free, np.uint64(mesh.columns), np.uint64(mesh.first),
                   Turn.none(mesh.precision))


@lean_inner_kernel
def limits_in_steps(limits: Limits) -> Limits:
    """Return limits for velocities in metres per step."""
    return Limits(limits.pole, limits.rounding, limits.reach, limits.cell, limits.free,
                  limits.columns, limits.first, in_steps(limits.turn))


class Contact(NamedTuple):
    """Flat fields (mesh.size,) that a step's contact with the pole is worked out in."""

    room: np.ndarray      # how much farther a node could go before the pole matters [m]
    normal_x: np.ndarray  # of the plane of the cell whose upper hoist corner is the node, or zero
    normal_y: np.ndarray
    brought_back: np.ndarray  # 1 where the attachment moved a node in this frame, or 0

    @classmethod
    def of(cls, mesh: Mesh) -> 'Contact':
        """Return the fields of a mesh."""
        return cls(*mesh.fields(4))
