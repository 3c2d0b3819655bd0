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

"""A cloth far from rest, the force on every node of it, and its derivatives as matrices."""
from flag_sim.cloth.forces import Forcing, set_forces, Work
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.state import State
import numpy as np


def crumpled(mesh, seed=0, size=0.3):
    """Return positions far from rest, and velocities: (rows, columns, 3) each."""
    rng = np.random.default_rng(seed)
    spread = size * max(mesh.dx, mesh.dy)
    rest = mesh.rest((0.5, -0.2, 3.0))
    return rest + spread * rng.normal(size=rest.shape), rng.normal(size=rest.shape)


def forces(model, positions, velocities=None, wind=(0.0, 0.0, 0.0), gravity=0.0, air=VACUUM,
           dt=0.0):
    """Return the force on every node: (rows, columns, 3) [N]."""
    mesh = model.mesh
    state, work = State(mesh), Work.of(mesh)
    state.place(positions, velocities)
    set_forces(state.nodes, model.sheet, model.coefficients(Forcing(wind, gravity, air), 1), work,
               mesh.number(dt), mesh.band())
    return np.stack([mesh.grid(axis) for axis in work.force], axis=-1).astype(np.float64)


def jacobian(model, positions, velocities, of):
    """Return minus the derivative of the forces by 'positions' or 'velocities', as a matrix."""
    step = 1e-6
    columns = []
    for index in np.ndindex(positions.shape):
        pair = []
        for sign in (1.0, -1.0):
            p, v = positions.copy(), velocities.copy()
            (p if of == 'positions' else v)[index] += sign * step
            pair.append(forces(model, p, v).ravel())
        columns.append((pair[1] - pair[0]) / (2.0 * step))
    matrix = np.array(columns)
    return 0.5 * (matrix + matrix.T)


def largest_eigenvalue(model, matrix, free):
    """Return the greatest eigenvalue of M^-1 matrix among the nodes that may move."""
    mass = np.repeat(model.mesh.grid(model.mass).ravel(), 3)
    scaled = matrix / np.sqrt(np.outer(mass, mass))
    keep = np.repeat(free.ravel() > 0.0, 3)
    return np.linalg.eigvalsh(scaled[np.ix_(keep, keep)])[-1]
