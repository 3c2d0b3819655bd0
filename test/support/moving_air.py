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
"""The inertia of the air that moves with a cloth, in plain numpy, in the world, not limited."""
import math

from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.stations import STATION
import numpy as np
from support.forces import forces


def accelerations(model: Model, forcing: Forcing, positions, velocities, other, dt):
    """
    Return what the air's inertia adds to accelerations, of all nodes: (rows, columns, 3) [m/s2].

    positions, velocities, other: (rows, columns, 3); other: accelerations by all other forces. dt:
    the step that convection is kept from overshooting in, 0 for the momentary force.
    """
    mesh, air = model.mesh, forcing.air
    mass = mesh.grid(model.mass).astype(float)
    count = min(math.ceil(mesh.length / (STATION * mesh.width) - 1e-9) + 1, mesh.columns)
    spacing = mesh.length / (count - 1)
    s = mesh.dx * np.arange(mesh.columns)
    hats = np.array([np.maximum(0.0, 1.0 - np.abs(s / spacing - j)) for j in range(count)])
    share = hats[:, None] * mass                     # (stations, rows, columns)
    total = share.sum(axis=(1, 2))

    def mean(vectors):
        return np.einsum('jrc,rcd->jd', share, vectors) / total[:, None]

    def spread(columns):
        return np.broadcast_to(columns, positions.shape)

    rows = np.average(positions, axis=0, weights=mass[:, 0])
    along = mean(spread(np.gradient(rows, mesh.dx, axis=0)))
    along /= np.maximum(1.0, np.linalg.norm(along, axis=1, keepdims=True))
    chord = mean(spread((positions[-1] - positions[0]) / mesh.width))
    n = np.cross(along, chord)
    n /= np.maximum(1.0, np.linalg.norm(n, axis=1, keepdims=True))
    v = mean(velocities)
    flow = np.maximum(0.0, np.sum((forcing.wind - v) * along, axis=1))
    w = np.sum((v - forcing.wind) * n, axis=1)
    convection = np.zeros(count)
    convection[1:] = flow[1:] * np.sum((v[1:] - v[:-1]) * n[1:], axis=1) + np.diff(flow * w)
    convection /= spacing + 2.0 * flow * dt
    inertia = (np.pi / 4.0 * air.added_mass * air.density * mesh.width
               / model.material.area_density * total)
    b = np.einsum('jrc,jd->jrcd', share / total[:, None, None], n).reshape(count, -1)
    by_mass = b * np.repeat((mesh.grid(mesh.free) / mass).ravel(), 3)
    force = np.linalg.solve(np.eye(count) + inertia[:, None] * (by_mass @ b.T),
                            -inertia * (b @ other.ravel() + convection))
    return (by_mass.T @ force).reshape(positions.shape)


def unpinned(model: Model) -> Model:
    """Return the same model without pins: of these a State would not keep velocities."""
    mesh = model.mesh
    return Model(Mesh(mesh.rows, mesh.columns, mesh.length, mesh.width, False, mesh.precision),
                 model.material, *model.factors)


def momentary(model: Model, forcing: Forcing, positions, velocities):
    """Return accelerations of this moment, with weight, springs, bending and drag as the rest."""
    mass = model.mesh.grid(model.mass)[..., None]
    other = forces(unpinned(model), positions, velocities, forcing.wind, forcing.gravity,
                   forcing.air) / mass
    return accelerations(model, forcing, positions, velocities,
                         other * model.mesh.grid(model.mesh.free)[..., None], 0.0)
