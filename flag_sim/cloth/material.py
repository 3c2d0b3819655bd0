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

"""What the cloth is made of, and the air around it."""
from dataclasses import dataclass

from flag_sim.cloth.drag import DRAG_LAWS, GREATEST_RATE
from flag_sim.parameters.declared import Declared, declared


@dataclass(frozen=True)
class Material(Declared):
    """
    A thin elastic sheet; every value belongs to the material, none to the grid.

    area_density: mass of a square metre [kg/m2], above zero.
    stiffness: K, tension per width of the threads per strain [N/m] (Hooke's law, eq. 1.2).
    shear_stiffness: G = C66 [N/m]. The sheet has C11 = C22 = K + G and C12 = G, and is isotropic
    where K = 2 G (Poisson's ratio 1/3), as it is by default.
    bend_stiffness: B, the plate's [N m]. The wrinkles that it allows are about
    (B / (area_density g))^(1/3) long; by default that is 8 cm, the spacing of the default grid,
    which could not show smaller ones. Light flag cloth has some 1e-5 and asks for a finer grid.
    damping: ratio of critical damping of one spring between two nodes; acts along springs.
    node_damping: nu in the force -nu m v on every node [1/s].
    Raises ValueError for a value out of its range.
    """

    area_density: float = declared(0.2, 'mass of the cloth per area', 'kg/m2', 1e-6, 1e6)
    stiffness: float = declared(1000.0, 'stiffness along the threads', 'N/m', 0.0, 1e9)
    shear_stiffness: float = declared(500.0, 'stiffness against shear', 'N/m', 0.0, 1e9)
    bend_stiffness: float = declared(1e-3, 'stiffness against bending', 'N m', 0.0, 1e6)
    damping: float = declared(0.05, 'damping ratio of every spring', '', 0.0, 1e6)
    node_damping: float = declared(0.0, 'rate at which nodes lose speed', '1/s', 0.0, 1e6)


@dataclass(frozen=True)
class Air(Declared):
    """
    The air that carries the wind.

    density: rho [kg/m3]; dry air at 20 degrees Celsius and sea level has 1.2.
    drag_coefficient: C_d of a face square to the wind; a square plate has 1.17 (Hoerner,
    Fluid-Dynamic Drag, 1965, chapter 3).
    Zero in either switches the wind off.
    law: the drag law, of the force on a face. quadratic: 1/2 rho C_d A |u_n| u_n n; linear:
    1/2 rho C_d A u_n n times 1 m/s; seed: n (n . w), newtons for metres per second (eq. 1.3
    exactly as published), which ignores the face's area and velocity, and of density and
    drag_coefficient all but whether they are zero.
    The first two never make the cloth faster than the wind; nothing weakens the third,
    which may fling light cloth out of all bounds (see divergence).
    added_mass: of the air that moves with the cloth, by that of a flag much longer than it is wide
    (see added_mass); waves of 1.87 lengths on a flag of 3 : 2 have 0.53. Solvers that cannot move
    it refuse it.
    Raises ValueError for a value out of its range and for an unknown law.
    """

    density: float = declared(1.2, 'density of the air', 'kg/m3', 0.0, 1000.0)
    drag_coefficient: float = declared(1.17, 'drag of the faces across the wind', '', 0.0, 100.0)
    law: str = declared('quadratic', 'how the force on a face grows with the wind across it',
                        choices=tuple(DRAG_LAWS))
    added_mass: float = declared(
        0.0, 'inertia of the air that moves with the cloth, by that of a narrow one; only with '
        'solver symplectic', '', 0.0, 1.0)

    @property
    def moves_along(self) -> bool:
        """Return whether any air moves with the cloth."""
        return self.added_mass > 0.0 and self.drag > 0.0

    @property
    def drag(self) -> float:
        """Return the drag law's factor [kg/m3]: 1/2 rho C_d, 1 for seed; 0 if the wind is off."""
        drag = 0.5 * self.density * self.drag_coefficient
        return 1.0 if self.law == 'seed' and drag > 0.0 else drag

    def greatest_rate(self, order: int) -> float:
        """Return the greatest fraction of a velocity that the drag takes in a step of a method."""
        return GREATEST_RATE[self.law][order] if self.drag > 0.0 else 0.0


VACUUM = Air(density=0.0)
"""No air: the wind exerts no force."""
