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
Bending of xpbd: one plate on every grid, also where it outweighs a node's mass by far.

The steps are long: h^2 B dy / dx^3, what bending does to a node in a step, is up to 5,000 times
the node's mass on the finest grids here. Where curvatures are met one after the other, the
frequencies of those are too low by a factor.
"""
import math

from flag_sim.cloth import Cloth, Material, Stepping
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.mesh import PRECISIONS
import numpy as np
import pytest
from support.cloths import FACTORS, ring

DENSITY = 0.2
GRIDS = [(11, 16), (21, 31), (41, 61), (81, 121)]


def free_plate(grid, size, bend, **parameters):
    """Return a cloth that resists nothing but bending, in space."""
    return Cloth(*grid, *size, (0.0, 0.0, 0.0), pinned=False, air=VACUUM, gravity=0.0,
                 material=Material(DENSITY, 0.0, 0.0, bend, damping=0.0), **parameters)


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('grid', GRIDS, ids=str)
@pytest.mark.parametrize('axis', [0, 1], ids=['down', 'along'])
def test_it_bends_as_a_beam_does_in_backward_euler(axis, grid, precision):
    """
    The first mode of a free sheet, 40 steps to 1.5 / omega: lines are met exactly.

    omega is less than a beam's by 4.0 / cells^2 of it, see test_cloth_refinement: that much is
    known to a twentieth. Rounding is felt as the matrix magnifies it, whose eigenvalues reach
    16 h^2 B / (density dx^4).
    """
    root, bend, size = 4.730040744862704, 0.1, (2.25, 1.5)
    cells = grid[axis] - 1
    omega = ((root / size[1 - axis])**2 * math.sqrt(bend / DENSITY) * (1.0 - 4.0 / cells**2))
    cloth = free_plate(grid, size, bend, solver='xpbd', precision=precision)
    x = root * np.linspace(0.0, 1.0, grid[axis])
    part = (math.cosh(root) - math.cos(root)) / (math.sinh(root) - math.sin(root))
    beam = np.cosh(x) + np.cos(x) - part * (np.sinh(x) + np.sin(x))
    shape = np.zeros((*grid, 3))
    shape[..., 1] = beam if axis else beam[:, None]
    cloth.place(cloth.positions + shape)
    factor, count, z = ring(cloth, shape, omega, count=40)
    assert count == 40
    error = abs(np.log(factor / FACTORS['xpbd'](z)**count)) / (count * z)
    spacing = size[1 - axis] / cells
    largest = 16.0 * (z / omega)**2 * bend / (DENSITY * spacing**4)
    assert error < 0.2 / cells**2 + np.finfo(precision).eps * largest


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('grid', [(11, 11), (41, 41)], ids=str)
def test_it_twists_as_it_does_with_other_methods(grid, precision):
    """
    A free square's slowest mode, x y, in steps of h omega = 0.008: within 3 % on every grid.

    That is what the splitting of rows from columns costs by the module's docstring.
    """
    def frequency(solver):
        cloth = free_plate(grid, (1.5, 1.5), 0.1, solver=solver, precision=precision)
        shape = np.zeros((*grid, 3))
        shape[..., 1] = 0.01 * np.outer(*(np.linspace(-1.0, 1.0, count) for count in grid))
        cloth.place(cloth.positions + shape)
        factor, _, _ = ring(cloth, shape, 1.5 / 0.12, count=0 if solver == 'verlet' else 72)
        return np.angle(factor) / 0.12

    slow = 1.0 - frequency('xpbd') / frequency('verlet')
    assert abs(slow) < 0.03


@pytest.mark.parametrize('precision', PRECISIONS)
def test_a_long_strip_of_great_stiffness_stays_bounded(precision):
    """Rounding outweighs the last pivots of float32, which must not make energy of it."""
    cloth = free_plate((2, 1001), (1.12, 0.1), 1e6, solver='xpbd', precision=precision,
                       stepping=Stepping(substeps=4, substeps_limit=4))
    bent = cloth.positions
    bent[..., 1] = 0.1 * np.sin(4.0 * bent[..., 0])
    cloth.place(bent)
    for _ in range(50):
        cloth.advance(0.02)
        assert np.abs(cloth.positions[..., 1]).max() < 0.2
        assert np.ptp(cloth.positions[..., 0]) < 2.3
