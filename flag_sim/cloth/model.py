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

from flag_sim.cloth.bending import bend_constants
from flag_sim.cloth.collision import Limits
from flag_sim.cloth.forces import Coefficients
from flag_sim.cloth.pressure import LAWS
from flag_sim.cloth.springs import dashpot_constants, spring_constants
from flag_sim.parameters.closed import constant


@constant
class Model:
    """
    A material on a mesh.

    stiffness_factor, damping_factor: by how much springs and bending, and by how much dashpots,
    are lowered below the material's, so that the steps that are granted carry them.

    mass: of each node [kg], flat (mesh.size,), zero at ghosts. inverse_mass: 1 / mass, and zero
    where a node does not move: pins and ghosts.
    """

    def __init__(self, mesh, material, stiffness_factor=1.0, damping_factor=1.0):
        self.mesh = mesh
        self.material = material
        self.factors = (stiffness_factor, damping_factor)
        self.cell_mass = material.area_density * mesh.dx * mesh.dy
        self.mass = self.cell_mass * mesh.mass_share
        self.inverse_mass = mesh.pad(
            mesh.grid(mesh.free) / (self.cell_mass * mesh.grid(mesh.mass_share)))

        spring_k = spring_constants(
            material.stiffness, material.shear_stiffness, mesh.dx, mesh.dy)
        spring_c = dashpot_constants(spring_k, material.damping, self.cell_mass)
        bend = bend_constants(material.bend_stiffness, mesh.dx, mesh.dy)
        self.spring_k = tuple(stiffness_factor * k for k in spring_k)
        self.spring_c = tuple(damping_factor * c for c in spring_c)
        self.spring_rest = (mesh.dx, mesh.dy, math.hypot(mesh.dx, mesh.dy))
        self.bend = tuple(stiffness_factor * b for b in bend)

    def coefficients(self, forcing, order):
        """Return the numbers that kernels of a method of this order need under the forcing."""
        drag = forcing.air.drag
        face_mass = 0.5 * self.cell_mass
        number = self.mesh.number
        return Coefficients(
            number(self.spring_k), number(self.spring_c), number(self.spring_rest),
            number(self.bend), number(forcing.gravity), number(drag), number(drag / face_mass),
            LAWS[forcing.air.law], order, number(self.material.node_damping),
            Limits.of(self.mesh, forcing.pole, forcing.stretch_limit))
