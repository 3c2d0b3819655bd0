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
Much time without wind: angular momentum stays, energy does not grow, a damped flag comes to rest.

A frame's error cannot show it: a method may be exact to a millimetre in a frame and turn forever.
Euler's explicit method and the seed scheme claim none of it: the first feeds every wave that is
not damped by dashpots, in the second friction vanishes with the step (see their docstrings).
"""
import itertools

from flag_sim.cloth import Cloth, Material, Stepping
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest
from support.cloths import energy
from support.soak import SOAK

FRAME = 1.0 / 30.0
MINUTE = 1800
"""Frames in a minute."""
FREE = MINUTE if SOAK else MINUTE // 3
"""Frames that a free cloth flies; it flaps most, and rk4 errs most, in the first of them."""
REST = MINUTE if SOAK else MINUTE // 2
"""Frames in which a damped flag comes to rest: half as many with twice the damping."""

CLAIM = [name for name in SOLVERS if name not in ('euler', 'seed')]
GRIDS = [(5, 8), (9, 13)] + ([(21, 31)] if SOAK else [])
STIFF = [100.0, 1000.0] + ([1e5] if SOAK else [])
STEPS = [0, 40]
"""Steps in a frame: the method's own number, or more where that is fewer."""

CASES = [case for case in itertools.product(CLAIM, GRIDS, STIFF, STEPS)
         if SOAK or case[1:] in (((5, 8), 100.0, 0), ((5, 8), 1000.0, 40), ((9, 13), 1000.0, 0))]


def cloth_of(solver, grid, stiffness, steps, **options):
    """Return a cloth whose frames are divided into at least so many steps."""
    material = Material(stiffness=stiffness, shear_stiffness=0.5 * stiffness,
                        node_damping=options.pop('node_damping', 0.0))
    return Cloth(*grid, solver=solver, material=material, stepping=Stepping(substeps=steps),
                 **options)


def looks(frame):
    """Return whether energy is looked at after a frame: at first always, then thrice a second."""
    return frame < 60 or frame % 10 == 0


def angular_momentum(cloth):
    """Return the angular momentum (3,) about the centre of mass [kg m2/s]."""
    mass = cloth.mesh.grid(cloth.model.mass)[..., None]
    center = (mass * cloth.positions).sum(axis=(0, 1)) / mass.sum()
    return (mass * np.cross(cloth.positions - center, cloth.velocities)).sum(axis=(0, 1))


@pytest.mark.parametrize('solver, grid, stiffness, steps', CASES)
def test_a_free_cloth_keeps_its_angular_momentum_and_gains_no_energy(solver, grid, stiffness,
                                                                     steps):
    """
    A sheet that spins and flaps in empty space; its springs are damped.

    Only rk4 is not exact: it errs by the fifth power of the step, a few 1e-6 in a minute.
    Energies of symplectic swing with the step by h omega / 2 of what rings, which is little.
    """
    cloth = cloth_of(solver, grid, stiffness, steps, pinned=False, air=VACUUM, gravity=0.0)
    arms = cloth.positions - cloth.positions.mean(axis=(0, 1))
    velocities = np.cross([0.3, 0.5, 2.0], arms)
    velocities[..., 1] += 1.5 * np.sin(np.linspace(0.0, 9.4, grid[1]))
    velocities += np.random.default_rng(1).normal(scale=0.05, size=velocities.shape)
    cloth.place(cloth.positions, velocities)
    turning, least = angular_momentum(cloth), energy(cloth, 0.0)
    begun = least
    for frame in range(FREE):
        cloth.advance(FRAME)
        if looks(frame):
            now = energy(cloth, 0.0)
            assert now < least + 0.01 * begun
            least = min(least, now)
    lost = np.abs(angular_momentum(cloth) - turning).max() / np.linalg.norm(turning)
    assert lost < (1e-4 if solver == 'rk4' else 1e-10)
    assert least < 0.9 * begun  # it did flap


@pytest.mark.parametrize('solver, grid, stiffness, steps', CASES)
def test_a_damped_flag_comes_to_rest_when_the_wind_stops(solver, grid, stiffness, steps):
    """
    After two seconds of wind, within REST: no node is faster than 1 mm/s in its last second.

    Its energy does not grow meanwhile, but for what swings within a step, a part of the weight
    times the flag's width.
    """
    cloth = cloth_of(solver, grid, stiffness, steps, node_damping=0.5 * MINUTE / REST, pole=None)
    for _ in range(60):
        cloth.advance(FRAME, (10.0, 4.0, 0.0))
    weight = 0.2 * 2.25 * 1.5 * 9.81
    least, fastest = energy(cloth, 9.81), 0.0
    for frame in range(REST):
        cloth.advance(FRAME)
        if looks(frame):
            now = energy(cloth, 9.81)
            assert now < least + 0.01 * weight * 1.5
            least = min(least, now)
        if frame >= REST - 30:
            fastest = max(fastest, np.abs(cloth.velocities).max())
    assert fastest < 1e-3
