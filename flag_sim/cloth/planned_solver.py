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

"""A solver whose material is softened where a frame's steps could not carry it."""
import functools

from flag_sim.cloth.divergence import Diverged, stability_hint, validate
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.cloth.stability import damping_bound, Plan, plan, SHORTEST_STEP
from flag_sim.cloth.state import State
from flag_sim.cloth.stepping import Stepping


class PlannedSolver:
    """
    A solver for a material on a mesh, planned anew for each frame.

    kind: a subclass of Solver. solver: one of that kind, its model softened as the last plan asks.
    """

    def __init__(self, mesh: Mesh, material: Material, kind: type[Solver]):
        self._mesh, self._material, self._kind = mesh, material, kind
        model = Model(mesh, material)
        self.solver = kind(model)
        self._bounds = kind.frequency_bound(model), damping_bound(model)

    def __reduce__(self):
        """Let a copy, also one of a file, have arrays of its own to compute in."""
        return _restored, (self._mesh, self._material, self._kind, self.solver.model.factors)

    def plan(self, dt: float, air: Air, stepping: Stepping) -> Plan:
        """Return how a frame of dt [s] is divided, and make the solver ready for these steps."""
        largest_step = functools.partial(self._kind.largest_step, air=air)
        steps = plan(dt, *self._bounds, largest_step, stepping, self._kind.useful_step,
                     SHORTEST_STEP[self._mesh.precision])
        factors = (steps.stiffness_factor, steps.damping_factor)
        if factors != self.solver.model.factors:
            self._soften(factors)
        return steps

    def _soften(self, factors):
        """Make the solver for the material times the factors."""
        self.solver = self._kind(Model(self._mesh, self._material, *factors))

    def validate(self, state: State, name: str, count: int, step: float, safety: float,
                 air: Air) -> None:
        """Raise Diverged if a state is out of bounds after count steps of step [s]; name: ours."""
        try:
            validate(state)
        except Diverged as broken:
            hint = stability_hint(name, step, safety, *self._bounds, air)
            raise Diverged(f'{broken} with solver {name} in {count} steps of {step:.3g} s; '
                           f'the cloth is held where the frame began; {hint}') from None


def _restored(mesh, material, kind, factors):
    """Return a PlannedSolver whose model is softened already."""
    planned = PlannedSolver(mesh, material, kind)
    planned._soften(factors)
    return planned
