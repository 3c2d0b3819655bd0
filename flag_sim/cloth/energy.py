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
The energies of the cloth, written from their definitions in plain numpy.

Slower than the forces' kernels, and independent of them: the forces are minus their gradients. All
raise ValueError for other shapes, and for numbers that are not finite.
"""
from flag_sim.cloth.model import Model
from flag_sim.parameters import checks
import numpy as np


def kinetic_energy(model: Model, velocities: np.ndarray) -> float:
    """Return the kinetic energy [J] of nodes with velocities (rows, columns, 3) [m/s]."""
    mass, velocities = model.mesh.grid(model.mass), _of_nodes('velocities', velocities, model)
    return 0.5 * float(np.sum(mass[..., None] * velocities**2))


def elastic_energy(model: Model, positions: np.ndarray) -> float:
    """Return the energy [J] of the springs at positions (rows, columns, 3) [m] (eq. 1.2)."""
    k_across, k_down, k_diagonal = model.spring_k
    rest_across, rest_down, rest_diagonal = model.spring_rest
    weights = model.mesh.weights
    p = _of_nodes('positions', positions, model)
    return sum(0.5 * k * float(np.sum(weight * (np.linalg.norm(ends, axis=-1) - rest)**2))
               for k, rest, weight, ends in (
        (k_across, rest_across, model.mesh.grid(weights.across)[:, :-1], p[:, 1:] - p[:, :-1]),
        (k_down, rest_down, model.mesh.grid(weights.down)[:-1], p[1:] - p[:-1]),
        (k_diagonal, rest_diagonal, 1.0, p[1:, 1:] - p[:-1, :-1]),
        (k_diagonal, rest_diagonal, 1.0, p[1:, :-1] - p[:-1, 1:])))


def bending_energy(model: Model, positions: np.ndarray) -> float:
    """Return the energy [J] of bending at positions (rows, columns, 3) [m] (see bending)."""
    b_across, b_down, b_twist = model.bend
    weights = model.mesh.weights
    p = _of_nodes('positions', positions, model)
    return sum(0.5 * b * float(np.sum(weight[..., None] * differences**2))
               for b, weight, differences in (
        (b_across, model.mesh.grid(weights.bend_across)[:, 1:-1],
         p[:, 2:] - 2.0 * p[:, 1:-1] + p[:, :-2]),
        (b_down, model.mesh.grid(weights.bend_down)[1:-1],
         p[2:] - 2.0 * p[1:-1] + p[:-2]),
        (b_twist, model.mesh.grid(weights.cell)[:-1, :-1],
         p[1:, 1:] - p[1:, :-1] - p[:-1, 1:] + p[:-1, :-1])))


def _of_nodes(name, values, model):
    """Return vectors of a model's nodes as float64: (rows, columns, 3)."""
    return checks.array(name, values, (model.mesh.rows, model.mesh.columns, 3), checks.LARGEST)
