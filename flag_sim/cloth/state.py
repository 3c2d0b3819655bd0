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

"""What changes from step to step: where the nodes are and how fast they move."""
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Field, Nodes, Vector
from flag_sim.parameters import checks
import numpy as np


class State:
    """
    Positions [m] and velocities [m/s] of a mesh's nodes, as a structure of arrays.

    position, velocity: tuples of three flat arrays (mesh.size,), for x, y and z. position is
    measured from origin, (x, y, z) [m], so that a cloth far away is as exact as one that is near.
    nodes: both as one record, for kernels. data: all six in one array (6, mesh.size).
    """

    def __init__(self, mesh: Mesh, origin: Vector = (0.0, 0.0, 0.0)):
        self.mesh = mesh
        self.origin = origin
        self.data = mesh.fields(6)
        self.nodes = Nodes(tuple(self.data[:3]), tuple(self.data[3:]))

    def __reduce__(self):
        """Let a copy, also one of a file, have its six fields in one array too."""
        return _restored, (self.mesh, self.origin, self.data)

    @property
    def position(self) -> Field:
        """Return x, y and z of the positions [m]: three flat arrays (mesh.size,)."""
        return self.nodes.position

    @property
    def velocity(self) -> Field:
        """Return x, y and z of the velocities [m/s]: three flat arrays (mesh.size,)."""
        return self.nodes.velocity

    def place(self, positions: np.ndarray, velocities: np.ndarray | None = None) -> None:
        """
        Put the nodes at positions (rows, columns, 3) [m], with velocities or at rest.

        Pinned nodes get their positions too, and stand still. Raises ValueError for a wrong shape
        and for numbers that are not finite.
        """
        mesh = self.mesh
        shape = (mesh.rows, mesh.columns, 3)
        positions = checks.array('positions', positions, shape, checks.LARGEST)
        velocities = np.zeros(shape) if velocities is None else velocities
        velocities = checks.array('velocities', velocities, shape, checks.LARGEST)
        for axis in range(3):
            mesh.grid(self.position[axis])[...] = positions[..., axis] - self.origin[axis]
            mesh.grid(self.velocity[axis])[...] = velocities[..., axis]
            self.velocity[axis][...] *= mesh.free

    def accelerate(self, change: np.ndarray) -> None:
        """Add a change (rows, columns, 3) [m/s] to the velocities of all nodes but pins."""
        for axis in range(3):
            self.mesh.grid(self.velocity[axis])[...] += (
                change[..., axis] * self.mesh.grid(self.mesh.free))

    def positions(self) -> np.ndarray:
        """Return a copy of the nodes' positions: (rows, columns, 3) float64 [m]."""
        return self._stack(self.position) + self.origin

    def velocities(self) -> np.ndarray:
        """Return a copy of the nodes' velocities: (rows, columns, 3) float64 [m/s]."""
        return self._stack(self.velocity)

    def _stack(self, axes: Field) -> np.ndarray:
        return np.stack([self.mesh.grid(axis) for axis in axes], axis=-1).astype(np.float64)


def _restored(mesh, origin, data):
    """Return a State that holds a copy of data."""
    state = State(mesh, origin)
    state.data[...] = data
    return state
