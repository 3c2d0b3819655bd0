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
One step of the cloth in plain numpy, to be read before the kernels, which compute the same.

The cloth is a grid of nodes with masses m at positions x, moving at velocities v. On each of them
act these forces (equations are numbered as in the source text, see docs/source.md):

    weight      F = m g                                                                   (eq. 1.1)
    springs     F = k (l - l_0) n along rows, columns and diagonals: Hooke's law          (eq. 1.2)
    wind        F = 1/2 rho C_d A |u_n| u_n n on a triangular face, u_n = (w - v) . n     (eq. 1.3)
                the wind normal to it, divided among the three nodes at its corners       (eq. 1.4)
    friction    F = c (dl/dt) n in every spring, and F = -nu m v on every node            (eq. 1.5)
    bending     F = minus the gradient of B/2 |second differences of x|^2  (not in the source)

Their sum (eq. 1.6) moves the node over a step h, by symplectic Euler (eq. 1.11):

    v' = v + h F / m     (eqs. 1.7 to 1.9)
    x' = x + h v'       (eq. 1.10)

Drag could reverse a velocity in one long step, so it is taken implicitly: that divides a node's
velocity by 1 + h nu, and the wind on a face by 1 + h (dF/du_n) / m, with m the face's mass.
Springs and curvatures on the border of the cloth have half weight, because only half a cell lies
beside them.
"""
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.model import Model
import numpy as np


def take_step(positions: np.ndarray, velocities: np.ndarray, model: Model, forcing: Forcing,
              dt: float) -> tuple[np.ndarray, np.ndarray]:
    """
    Return the positions and velocities after a step, as new arrays.

    positions, velocities: (rows, columns, 3) [m], [m/s]. model: the cloth's Model. forcing: pole,
    stretch_limit and spin are ignored; only the quadratic drag law is supported. dt: [s].
    """
    mesh, grid = model.mesh, model.mesh.grid
    x, v, mass = positions.reshape(-1, 3), velocities.reshape(-1, 3), grid(model.mass).ravel()
    force = mass[:, None] * (-forcing.gravity * np.array(forcing.up))               # eq. 1.1
    node = np.arange(mesh.rows * mesh.columns).reshape(mesh.rows, mesh.columns)
    # The corners of all cells, named as on a map: the upper edge is north, the hoist west.
    nw, ne, sw, se = node[:-1, :-1], node[:-1, 1:], node[1:, :-1], node[1:, 1:]
    across = grid(mesh.weights.across)[:, :-1, None], node[:, :-1], node[:, 1:]
    down = grid(mesh.weights.down)[:-1, :, None], node[:-1], node[1:]

    for (weight, a, b), kind in ((across, 0), (down, 1), ((1.0, nw, se), 2), ((1.0, sw, ne), 2)):
        k, c, rest = model.spring_k[kind], model.spring_c[kind], model.spring_rest[kind]
        length = np.linalg.norm(x[b] - x[a], axis=-1, keepdims=True)
        n = (x[b] - x[a]) / length
        growth = np.sum((v[b] - v[a]) * n, axis=-1, keepdims=True)
        spring_force = weight * (k * (length - rest) + c * growth) * n              # eqs. 1.2, 1.5
        force[a] += spring_force
        force[b] -= spring_force

    drag, face_mass = forcing.air.drag, 0.5 * model.cell_mass
    for a, b, c in ((nw, ne, sw), (se, sw, ne)):  # the right angle of the face is at a
        area_vector = 0.5 * np.cross(x[b] - x[a], x[c] - x[a])
        area = np.linalg.norm(area_vector, axis=-1, keepdims=True)
        n = area_vector / area
        u_n = np.sum((forcing.wind - 0.5 * v[a] - 0.25 * (v[b] + v[c])) * n, -1, keepdims=True)
        face_force = drag * area * np.abs(u_n) * u_n * n                            # eq. 1.3
        face_force /= 1.0 + dt * drag * area * 2.0 * np.abs(u_n) / face_mass
        for corner, share in ((a, 0.5), (b, 0.25), (c, 0.25)):
            force[corner] += share * face_force                                     # eq. 1.4

    bend_across = grid(mesh.weights.bend_across)[:, 1:-1, None]
    bend_down = grid(mesh.weights.bend_down)[1:-1, :, None]
    for b, corners, signs in (
            (model.bend[0] * bend_across, (node[:, :-2], node[:, 1:-1], node[:, 2:]), (1, -2, 1)),
            (model.bend[1] * bend_down, (node[:-2], node[1:-1], node[2:]), (1, -2, 1)),
            (model.bend[2], (nw, ne, sw, se), (1, -1, -1, 1))):
        moment = b * sum(sign * x[corner] for corner, sign in zip(corners, signs))
        for corner, sign in zip(corners, signs):
            force[corner] -= sign * moment

    free = grid(mesh.free).reshape(-1, 1)  # 0 at the hoist, which does not move
    v = free * (v + dt * force / mass[:, None])                                         # eq. 1.9
    v /= 1.0 + dt * model.material.node_damping
    x = x + dt * v                                                                      # eq. 1.10
    return x.reshape(positions.shape), v.reshape(positions.shape)
