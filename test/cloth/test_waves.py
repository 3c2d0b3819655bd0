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
Waves against theory: modes of a hanging chain and dispersion along a sheet, for every solver.

A wave of a lattice that is linear in small motion is known exactly, and so is what a method makes
of it: each step multiplies the mode by a complex number lambda(i omega dt) of the method's own.
So the lattice's frequency is not compared within a solver's error but through it, and what is left
is rounding. The lattice's own distance from the continuum is its discretisation error.
"""
import math

from flag_sim.cloth import Material
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest
from scipy.special import jn_zeros
from support.cloths import FACTORS, flat, hanging, highest_frequency, ring


def rounding(solver, z_highest):
    """
    Return by how much a step may differ from theory, over omega dt.

    A sweep of xpbd passes over what neighbours do to a spring within it, k dt^2 / m of the force,
    that is (dt omega_highest)^2 / 4; nobody else passes over anything, and
    a mode 1e-8 m large is linear to some 1e-11.
    """
    return {'xpbd': 0.25 * z_highest**2, 'implicit': 1e-3}.get(solver, 1e-10)


def assert_rings(cloth, shape, omega, is_swing=False):
    """
    Assert that the mode which the cloth has been placed in rings as the method says.

    is_swing: whether the cloth turns about its hinge in it. What turns fades in implicit by less
    than h omega^2 / 2, as it keeps the angular momentum that backward Euler would lose.
    """
    found, count, z = ring(cloth, shape, omega)
    error = np.abs(np.log(found / FACTORS[cloth.solver](z)**count)) / (count * z)
    less = 0.5 * z if is_swing and cloth.solver == 'implicit' else 0.0
    assert error < rounding(cloth.solver, z / omega * highest_frequency(cloth)) + less


def lumped_chain(links, length, width, material):
    """
    Return (omega, modes, link lengths) of a chain of lumped masses that hangs at rest.

    modes: (links, links), one a row, of the nodes below the pin. A link bears the weight below it,
    T = k x, and draws its ends together sideways by T / l. The last node has half a cell below it.
    """
    spacing = length / links
    mass = np.full(links, material.area_density * spacing * width)
    mass[-1] *= 0.5
    tension = 9.81 * np.cumsum(mass[::-1])[::-1]
    lengths = spacing + tension * spacing / (material.stiffness * width)
    above = tension / lengths
    below = np.append(above[1:], 0.0)
    stiffness = np.diag(above + below) - np.diag(below[:-1], 1) - np.diag(below[:-1], -1)
    root = 1.0 / np.sqrt(mass)
    squares, vectors = np.linalg.eigh(stiffness * np.outer(root, root))
    return np.sqrt(squares), vectors.T * root, lengths


LINKS = 30


@pytest.mark.parametrize('mode', [1, 2, 3, LINKS])
@pytest.mark.parametrize('solver', [name for name in SOLVERS if name != 'euler'])
def test_modes_of_a_hanging_chain(solver, mode):
    """
    A strip hung by its end, moved sideways by 1e-8 m in one of its modes; the shortest too.

    Euler's method, which feeds waves across a taut sheet, does not claim them; nor does implicit
    the shortest, as its iterations end where a thousandth of the weight is unsolved.
    """
    if solver == 'implicit' and mode == LINKS:
        pytest.skip('implicit does not solve for forces so much smaller than the weight')
    length, width, material = 1.0, 0.1, Material(0.2, 1000.0, 0.0, 0.0, damping=0.0)
    omega, modes, lengths = lumped_chain(LINKS, length, width, material)
    cloth = flat(2, LINKS + 1, length, width, (0.0, 0.0, 0.0), material=material, air=VACUUM,
                 solver=solver)
    shape = np.zeros((2, LINKS + 1, 3))
    shape[:, 1:, 1] = 1e-8 * modes[mode - 1] / np.abs(modes[mode - 1]).max()
    positions = hanging(cloth)
    positions[..., 2] = -np.append(0.0, np.cumsum(lengths))
    cloth.place(positions + shape)
    assert_rings(cloth, shape, omega[mode - 1], is_swing=True)


@pytest.mark.parametrize('mode, error', [(1, 0.30), (2, 3.9), (3, 15.6)])
def test_a_lumped_chain_is_a_chain(mode, error):
    """Its omega is (j0n / 2) sqrt(g / L) to second order: less by error / links^2."""
    taut = Material(0.2, 1e9, 0.0, 0.0)
    exact = 0.5 * jn_zeros(0, mode)[-1] * math.sqrt(9.81)
    for links in (30, 60, 120):
        omega = lumped_chain(links, 1.0, 0.1, taut)[0][mode - 1]
        assert omega == pytest.approx(exact * (1.0 - error / links**2), rel=0.1 * error / links**2)


@pytest.mark.parametrize('part', [1, 5, 10, 15, 20])
@pytest.mark.parametrize('axis', [0, 2], ids=['along', 'down'])
@pytest.mark.parametrize('solver', SOLVERS)
def test_dispersion_of_longitudinal_waves(solver, axis, part):
    """
    Omega = 2 sqrt(k/m) sin(kappa h / 2) with k/m = K / (density h^2), up to the zone boundary.

    Standing waves cos(kappa j h), kappa h = pi part / 20, of a free sheet whose cells are oblong:
    half masses at its ends mirror them. Springs in line are linear, so a wave may be large.
    """
    material = Material(0.2, 800.0, 0.0, 0.0, damping=0.0)
    grid, size = ((3, 21), (2.0, 0.3)) if axis == 0 else ((21, 3), (0.3, 2.0))
    cloth = flat(*grid, *size, (0.0, 0.0, 0.0), pinned=False, material=material, air=VACUUM,
                 gravity=0.0, solver=solver)
    kappa_h = math.pi * part / 20
    omega = 2.0 * math.sqrt(800.0 / 0.2) / 0.1 * math.sin(0.5 * kappa_h)
    node = np.indices(grid)[1 if axis == 0 else 0]
    shape = np.zeros((*grid, 3))
    shape[..., axis] = 0.01 * np.cos(kappa_h * node)
    cloth.place(cloth.positions + shape)
    assert_rings(cloth, shape, omega)
