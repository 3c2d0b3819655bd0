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
"""What a pole has to bear: the force and the moment of the flag on it."""
from typing import NamedTuple

from flag_sim.cloth.forces import Forcing, set_forces, Work
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Vector
from flag_sim.cloth.simulation import Cloth
from flag_sim.cloth.state import State
import numpy as np


class PoleLoad(NamedTuple):
    """The force of a cloth on its hoist, and its moment about the upper hoist corner."""

    force: np.ndarray   # (3,) [N]
    moment: np.ndarray  # (3,) [N m]

    def drag(self, wind: Vector) -> float:
        """Return the part of the force along a wind (3,) [N]; 0 where there is none."""
        speed = float(np.linalg.norm(wind))
        return float(self.force @ np.asarray(wind)) / speed if speed > 0.0 else 0.0

    def lift(self, weight: float) -> float:
        """Return the upward force that the air adds to the cloth's weight [N]."""
        return float(self.force[2]) + weight


def weight(cloth: Cloth) -> float:
    """Return the weight of a cloth [N], of the half cells at its hoist too."""
    return float(cloth.model.mass.sum()) * cloth.gravity


def pole_load(cloth: Cloth, wind: Vector = (0.0, 0.0, 0.0)) -> PoleLoad:
    """
    Return the momentary load of a pinned cloth on its pole in a wind (x, y, z) [m/s].

    It is the sum of all forces on the pinned nodes: springs, dashpots, bending, and the weight and
    wind of their own halves of cells. Since pins do not move, it equals the cloth's weight plus
    the wind's force on it, less the rate at which its momentum grows. What a pole that the cloth
    touches below its hoist bears there is not in it, nor is the inertia of the air around the
    hoist's own half cells (air.added_mass).

    Raises ValueError for a cloth without pins.
    """
    if not cloth.mesh.pinned:
        raise ValueError('a cloth that is not pinned has no pole to pull at')
    state = State(cloth.mesh, cloth.hoist_top)
    state.place(cloth.positions, cloth.velocities)
    return load_in_step(cloth.model, state, Forcing(wind, cloth.gravity, cloth.air))


def load_in_step(model: Model, state: State, forcing: Forcing, dt: float = 0.0,
                 order: int = 1) -> PoleLoad:
    """
    Return the load at a state's time, or as a step of dt [s] of a method of an order feels it.

    In a step the wind's drag is implicit, and so weaker (see drag); 0: the momentary force.
    """
    mesh = model.mesh
    work = Work.of(mesh)
    set_forces(state.nodes, model.sheet, model.coefficients(forcing, order), work,
               mesh.number(dt), mesh.band())
    # In float64: sums of forces that balance one another.
    force = np.stack([mesh.grid(axis)[:, 0] for axis in work.force], axis=-1).astype(float)
    arm = np.stack([mesh.grid(axis)[:, 0] for axis in state.position], axis=-1).astype(float)
    return PoleLoad(force.sum(axis=0), np.cross(arm, force).sum(axis=0))
