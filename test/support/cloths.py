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

"""Cloths in simple places, and the numbers that theory speaks of."""
from flag_sim.cloth.energy import bending_energy, elastic_energy, kinetic_energy
from flag_sim.cloth.model import Model
from flag_sim.cloth.stability import frequency_bound
import numpy as np


def hanging(cloth):
    """Return positions that let the cloth hang down from its hoist: columns become heights."""
    flat = cloth.positions - cloth.hoist_top
    return np.stack([-flat[..., 2], flat[..., 1], -flat[..., 0]], axis=-1) + cloth.hoist_top


def model_of(cloth):
    """Return the mesh and material of a cloth, neither softened."""
    return Model(cloth.mesh, cloth.material)


def highest_frequency(cloth):
    """Return the bound of the cloth's angular frequencies [rad/s]."""
    return frequency_bound(model_of(cloth))


def potential_energy(model, positions, gravity):
    """Return the energy [J] of height above z = 0 in gravity [m/s2] (1.1)."""
    return gravity * float(np.sum(model.mesh.grid(model.mass) * positions[..., 2]))


def energy(cloth, gravity):
    """Return all the energy that the cloth has [J]."""
    model = model_of(cloth)
    return (kinetic_energy(model, cloth.velocities) + elastic_energy(model, cloth.positions)
            + bending_energy(model, cloth.positions)
            + potential_energy(model, cloth.positions, gravity))
