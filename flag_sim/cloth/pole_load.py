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
What the flag does to its pole: the force and the moment by which the hoist holds it.

The hoist's nodes stay on the pole, which bears the sum of all forces on them: springs, bending,
wind and weight (eq. 1.6). What it takes to move their own half cells, and the air around these,
along with a pole that moves is left out. In plain numpy, as it is asked for once a frame; only the
cells beside the hoist have a part in it. Where cloth is pressed against the pole beyond its hoist
it pushes too; that is no force of the model, and is left out.
"""
from typing import NamedTuple

from flag_sim.cloth.drag import DRAG_LAWS, LINEAR, QUADRATIC, SEED
from flag_sim.cloth.mesh import LEAST_AREA2
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Vector
from flag_sim.cloth.simulation import Cloth, MAX_WIND
from flag_sim.parameters import checks
import numpy as np


class PoleLoad(NamedTuple):
    """
    What the flag does to its pole, along the axes of the world.

    force: (3,) [N]; moment: (3,) [N m], about the upper hoist corner.
    """

    force: np.ndarray
    moment: np.ndarray


def pole_load(cloth: Cloth, wind: Vector) -> PoleLoad:
    """
    Return the load of this moment, in a wind (x, y, z) [m/s]; zero of a cloth without pins.

    Raises ValueError for what is no Cloth, and for a wind beyond MAX_WIND.
    """
    checks.instance('cloth', cloth, Cloth)
    wind = np.array(checks.vector('wind', wind, MAX_WIND))
    if not cloth.mesh.pinned:
        return PoleLoad(np.zeros(3), np.zeros(3))
    beside = cloth.positions[:, :3], cloth.velocities[:, :3]
    force = _springs(cloth.model, *beside) + _bending(cloth.model, beside[0])
    force += _wind(*beside, wind, cloth.air)
    force[:, 2] -= cloth.mesh.grid(cloth.model.mass)[:, 0] * cloth.gravity           # eq. 1.1
    pose = cloth.pose
    arm = beside[0][:, 0] - (pose[:3, :3] @ cloth.hoist_top + pose[:3, 3])
    return PoleLoad(force.sum(axis=0), np.cross(arm, force).sum(axis=0))


def _springs(model: Model, x, v):
    """Return the force of springs and their dashpots on the hoist's nodes (eqs. 1.2, 1.5)."""
    force, grid, weights = np.zeros_like(x[:, 0]), model.mesh.grid, model.mesh.weights

    def tension(kind, weight, a, b):
        ends, moving = x[b] - x[a], v[b] - v[a]
        length = np.linalg.norm(ends, axis=-1, keepdims=True)
        n = ends / length
        growth = np.sum(moving * n, axis=-1, keepdims=True)
        return weight * (model.spring_k[kind] * (length - model.spring_rest[kind])
                         + model.spring_c[kind] * growth) * n

    upper, lower = slice(None, -1), slice(1, None)
    force += tension(0, grid(weights.across)[:, :1], np.s_[:, 0], np.s_[:, 1])
    along = tension(1, grid(weights.down)[:-1, :1], (upper, 0), (lower, 0))
    force[:-1] += along
    force[1:] -= along
    force[:-1] += tension(2, 1.0, (upper, 0), (lower, 1))
    force[1:] += tension(2, 1.0, (lower, 0), (upper, 1))
    return force


def _bending(model: Model, x):
    """Return the force of bending on the hoist's nodes (see bending)."""
    force, grid, weights = np.zeros_like(x[:, 0]), model.mesh.grid, model.mesh.weights
    across, down, twist = model.bend
    if x.shape[1] > 2:
        force -= across * grid(weights.bend_across)[:, 1:2] * (x[:, 0] - 2.0 * x[:, 1] + x[:, 2])
    moment = down * grid(weights.bend_down)[1:-1, :1] * (
        x[:-2, 0] - 2.0 * x[1:-1, 0] + x[2:, 0])
    force[:-2] -= moment
    force[1:-1] += 2.0 * moment
    force[2:] -= moment
    moment = twist * (x[:-1, 0] - x[:-1, 1] - x[1:, 0] + x[1:, 1])
    force[:-1] -= moment
    force[1:] += moment
    return force


def _wind(x, v, wind, air):
    """Return the part of the hoist's nodes in the wind on the faces beside (eqs. 1.3, 1.4)."""
    force, law = np.zeros_like(x[:, 0]), DRAG_LAWS[air.law]
    upper, lower = slice(None, -1), slice(1, None)
    north_west, north_east = (upper, 0), (upper, 1)
    south_west, south_east = (lower, 0), (lower, 1)
    for a, b, c, shares in (
            (north_west, north_east, south_west, ((upper, 0.5), (lower, 0.25))),
            (south_east, south_west, north_east, ((lower, 0.25),))):
        area = 0.5 * np.cross(x[b] - x[a], x[c] - x[a])
        own = 0.0 if law == SEED else 0.5 * v[a] + 0.25 * (v[b] + v[c])
        flux = np.sum((wind - own) * area, axis=-1, keepdims=True)
        area2 = np.maximum(np.sum(area**2, axis=-1, keepdims=True), LEAST_AREA2)
        s = {QUADRATIC: np.abs(flux), LINEAR: np.sqrt(area2), SEED: 1.0}[law]
        face_force = air.drag * s * flux / area2 * area
        for rows, share in shares:
            force[rows] += share * face_force
    return force
