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

"""The states that a cloth's frame is computed in: the present, the next, and one to go back to."""
from flag_sim.cloth.constraints import constrain
from flag_sim.cloth.contact import Limits
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.pole_frame import PoleFrame
from flag_sim.cloth.records import Vector
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.state import State
from flag_sim.parallel.thread_pool import ThreadPool
import numpy as np


class States:
    """The states of a mesh whose positions are measured from origin, (x, y, z) [m]."""

    def __init__(self, mesh: Mesh, origin: Vector):
        self.now, self._spare = State(mesh, origin), State(mesh, origin)
        self._last_good = self.now.data.copy()

    def keep(self) -> None:
        """Remember the present state, for go_back."""
        self._last_good[...] = self.now.data

    def go_back(self) -> None:
        """Return to the state that was kept, also when threads were interrupted steps apart."""
        self.now.data[...] = self._last_good

    def take(self, solver: Solver, forcing: Forcing, frame: PoleFrame, step: float, count: int,
             pool: ThreadPool) -> None:
        """
        Take count steps of step [s] in a frame of reference; forcing: as it is in the world.

        solver.contact.brought_back then tells of all of them.
        """
        brought_back = 0.0
        with pool.frame(count):
            for there, number in frame.pieces(count, step):
                state = solver.advance(self.now, self._spare, there.seen(forcing), step, number,
                                       pool)
                if state is not self.now:
                    self.now, self._spare = self._spare, self.now
                brought_back = np.maximum(brought_back, solver.contact.brought_back)
        solver.contact.brought_back[...] = brought_back

    def constrain(self, solver: Solver, limits: Limits) -> int:
        """Bring back what is not within limits; return how many nodes a frame brought back."""
        constrain(self.now, self._spare, limits, solver.contact)
        return int(np.count_nonzero(solver.contact.brought_back))
