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

"""What is constant while the cloth moves: mesh and material, and what follows from both."""
import math

from flag_sim.cloth.aerodynamics import Wind
from flag_sim.cloth.bending import bend_constants
from flag_sim.cloth.contact import Limits
from flag_sim.cloth.drag import DRAG_LAWS
from flag_sim.cloth.forces import Coefficients, Forcing
from flag_sim.cloth.material import Material
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.records import Sheet
from flag_sim.cloth.springs import dashpot_constants, spring_constants, Springs
from flag_sim.parameters.closed import constant
import numpy as np


@constant
class Model:
    """
    A material on a mesh.

    stiffness_factor, damping_factor: by how much springs and bending, and by how much dashpots,
    are lowered below the material's, so that the steps that are granted carry them.

    mass: of each node [kg], flat (mesh.size,), zero at ghosts. inverse_mass: 1 / mass, and zero
    where a node does not move: pins and ghosts. sheet: both and the mesh's weights, for kernels.
    spring_k, spring_c, spring_rest: constants [N/m], dashpots [N s/m] and lengths at rest [m] of
    the springs across, down and diagonal. bend: constants [N/m] across, down and of twist.
    """

    def __init__(self, mesh: Mesh, material: Material, stiffness_factor: float = 1.0,
                 damping_factor: float = 1.0):
        self.mesh = mesh
        self.material = material
        self.factors = (stiffness_factor, damping_factor)
        self.cell_mass = material.area_density * mesh.dx * mesh.dy
        self.mass = self.cell_mass * mesh.mass_share
        self.inverse_mass = mesh.pad(
            mesh.grid(mesh.free) / (self.cell_mass * mesh.grid(mesh.mass_share)))
        self.sheet = Sheet(self.mass, self.inverse_mass, mesh.weights)

        spring_k = spring_constants(
            material.stiffness, material.shear_stiffness, mesh.dx, mesh.dy)
        spring_c = dashpot_constants(spring_k, material.damping, self.cell_mass)
        bend = bend_constants(material.bend_stiffness, mesh.dx, mesh.dy)
        self.spring_k = tuple(stiffness_factor * k for k in spring_k)
        self.spring_c = tuple(damping_factor * c for c in spring_c)
        self.spring_rest = (mesh.dx, mesh.dy, math.hypot(mesh.dx, mesh.dy))
        self.bend = tuple(stiffness_factor * b for b in bend)

    def coefficients(self, forcing: Forcing, order: int) -> Coefficients:
        """Return the numbers that kernels need under a forcing; order: see Wind."""
        number = self.mesh.number
        drag = forcing.air.drag
        drag_rate = drag / (0.5 * self.cell_mass)
        wind = Wind(number(_wind_at_origin(forcing)), number(drag), number(drag_rate),
                    DRAG_LAWS[forcing.air.law], order, number(_wind_spin(forcing)))
        springs = Springs(number(self.spring_k), number(self.spring_c), number(self.spring_rest))
        return Coefficients(
            springs, number(self.bend), number(tuple(forcing.gravity * up for up in forcing.up)),
            wind,
            number(self.material.node_damping),
            Limits.of(self.mesh, forcing.pole, forcing.stretch_limit))


def _wind_spin(forcing):
    """Return the spin [rad/s] of what faces feel the wind against; the law of seed knows none."""
    return (0.0, 0.0, 0.0) if forcing.air.law == 'seed' else forcing.spin


def _wind_at_origin(forcing):
    """Return the wind [m/s] as what turns with the pole feels it where positions begin."""
    if not any(_wind_spin(forcing)):
        return tuple(forcing.wind)
    return tuple((np.asarray(forcing.wind) - np.cross(forcing.spin, forcing.lever)).tolist())
