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

"""What all peers move: the default cloth, flat and at rest in a wind from the side."""
from typing import NamedTuple

from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import Material
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model

import numpy as np

LENGTH, WIDTH, HOIST_TOP = 2.25, 1.5, (0.05, 0.0, 8.9)


class Case(NamedTuple):
    """
    A grid and whether it resists bending; all else is the default flag's.

    wind [m/s]: oblique, so that the cloth moves from the first step on. dt [s]: the step that all
    take, stable for every peer on the finest grid here.
    """

    rows: int = 41
    columns: int = 61
    has_bending: bool = False
    wind: tuple = (6.0, 2.0, 0.0)
    dt: float = 1e-4

    @property
    def nodes(self):
        """Return how many nodes the grid has."""
        return self.rows * self.columns

    @property
    def material(self):
        """Return the cloth's Material."""
        return Material() if self.has_bending else Material(bend_stiffness=0.0)


class Sheet:
    """
    The case in numbers, for peers that are told everything.

    positions: (rows, columns, 3) [m]. mass: (rows, columns) [kg]. springs: for each of the four
    directions its (rows, columns) offset, spring constant [N/m], dashpot [N s/m], length at rest
    [m]; springs on a border stand for half a strip and count by half: share_across (rows, 1),
    share_down (1, columns). drag: of a face [kg/m3]. hold: by flux, of the implicit drag [s/m3].
    bend: across, down and twist [N/m]. gravity [m/s2].
    """

    def __init__(self, case):
        mesh = Mesh(case.rows, case.columns, LENGTH, WIDTH)
        model = Model(mesh, case.material)
        forcing = Forcing(case.wind)
        coefficients = model.coefficients(forcing, order=1)
        self.dx, self.dy = mesh.dx, mesh.dy
        self.positions = mesh.rest(HOIST_TOP)
        self.mass = mesh.grid(model.mass).copy()
        across, down, diagonal = zip(model.spring_k, model.spring_c, model.spring_rest)
        self.springs = [((0, 1), *across), ((1, 0), *down),
                        ((1, 1), *diagonal), ((1, -1), *diagonal)]
        self.share_across = np.ones((case.rows, 1))
        self.share_down = np.ones((1, case.columns))
        self.share_across[[0, -1]] = self.share_down[:, [0, -1]] = 0.5
        self.drag = coefficients.wind.drag
        self.hold = case.dt * coefficients.wind.drag_rate
        self.bend = model.bend
        self.bend_stiffness = case.material.bend_stiffness
        self.gravity = forcing.gravity
        # C66 and C12 of the membrane that the springs make (see springs.spring_constants).
        self.shear_stiffness = case.material.shear_stiffness
        self.stiffness = case.material.stiffness

    def triangles(self):
        """Return the corners of the faces, upper ones first, the right angle first: (faces, 3)."""
        index = np.arange(self.mass.size).reshape(self.mass.shape)
        i, e, s, d = index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]
        return np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3)
                               for corners in ((i, e, s), (d, s, e))])
