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
Cloth in the true wind instead of the apparent one: for the ablation alone, no dial asks for it.

The apparent wind is the true wind less the cloth's own velocity. All else is as it is by default:
the quadratic law, the symplectic steps and their length.
"""
import dataclasses

from flag_sim.cloth import Cloth, Material
from flag_sim.cloth.forces import set_forces, Work
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers.symplectic import Symplectic


class TrueWind(Symplectic):
    """
    Symplectic steps (1.7 to 1.11) under a wind on the faces as if they stood still.

    The wind's force then depends on the positions alone, like that of a spring. So it is taken as
    it is at a step's start, without the drag's implicit part, and added to a step in still air.
    """

    def __init__(self, model):
        super().__init__(model)
        limp = Material(model.material.area_density, 0.0, 0.0, 0.0, 0.0)
        self._limp = Model(model.mesh, limp)
        self._still = tuple(model.mesh.fields(3))
        self._wind = Work.of(model.mesh)

    def advance(self, state, spare, forcing, dt, count, crew=None):
        """Take count steps of dt [s] from state; return the one of the two with the result."""
        air = dataclasses.replace(forcing.air, density=0.0)
        number = self.model.mesh.number
        kept = number(dt / (1.0 + dt * self.model.material.node_damping))
        for _ in range(count):
            force = self.force(state, forcing)
            state, spare = super().advance(state, spare, forcing._replace(air=air), dt, 1), state
            for x, v, f in zip(state.position, state.velocity, force):
                gained = kept * f * self.model.inverse_mass
                v += gained
                x += number(dt) * gained
        return state

    def force(self, state, forcing):
        """Return the wind's force on every node, x, y and z, flat [N]: that of a limp sheet."""
        limp, number = self._limp, self.model.mesh.number
        coefficients = limp.coefficients(forcing._replace(gravity=0.0), self.order)
        set_forces(state.position, self._still, number(forcing.wind), limp.mass,
                   limp.mesh.weights, coefficients, self._wind, number(0.0), limp.mesh.span)
        return self._wind.force


class TrueWindCloth(Cloth):
    """A Cloth that steps by TrueWind, whatever the name of its solver."""

    @classmethod
    def like(cls, cloth):
        """Return one of the same dials as a Cloth's, at rest."""
        mesh = cloth.mesh
        return cls(mesh.rows, mesh.columns, mesh.length, mesh.width, cloth.hoist_top,
                   material=cloth.material, air=cloth.air, gravity=cloth.gravity,
                   stepping=cloth.stepping, stretch_limit=cloth.stretch_limit, pole=cloth.pole,
                   precision=cloth.precision)

    def _remodel(self, mesh, material, solver_name):
        """Make the solver; plans, which make another for a softened model, keep its type."""
        super()._remodel(mesh, material, solver_name)
        self._solver = TrueWind(self._solver.model)
