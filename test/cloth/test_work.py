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
Work and energy: what the wind does is what the cloth gains and loses.

The powers are written here in plain numpy, from the forces' definitions, and integrated over the
states that a run goes through. What is left of work - change of energy - loss is the method's
error, and falls with its step at its order, down to the error of the quadrature.
"""
from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.energy import kinetic_energy
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest
from scipy.integrate import romb
from support import moving_air
from support.cloths import energy, model_of

WIND = (6.0, 8.0, 1.0)
FRAME, SAMPLES = 0.1, 2**8
"""Seconds of a run, and intervals between its samples: 12 of the fastest wave's a period."""
FIRST = {1: 16, 2: 2, 4: 1}
"""Steps an interval from which on a method of an order shows it."""
HALVINGS = 2
FLOOR = 1e-9
"""
Part of the work below which the quadrature is what is seen.

The balance of rk4 closes to 1e-10, and with twice as many samples to 3e-11.
"""
UPPER = (np.s_[:-1, :-1], np.s_[:-1, 1:], np.s_[1:, :-1])
LOWER = (np.s_[1:, 1:], np.s_[1:, :-1], np.s_[:-1, 1:])
"""Corners of the faces, the right angle first."""


def wind_power(air, positions, velocities):
    """Return the power of the wind on the faces [W]: eq. 1.3 with the drag laws."""
    power = 0.0
    for right, second, third in (UPPER, LOWER):
        area = 0.5 * np.cross(positions[second] - positions[right],
                              positions[third] - positions[right])
        size = np.linalg.norm(area, axis=-1, keepdims=True)
        moves = 0.5 * velocities[right] + 0.25 * (velocities[second] + velocities[third])
        u = np.array(WIND) - (moves if air.law != 'seed' else 0.0)
        u_n = np.sum(u * area, axis=-1, keepdims=True) / size
        pressure = (u_n / size if air.law == 'seed'
                    else 0.5 * air.density * air.drag_coefficient * np.abs(u_n) * u_n)
        power += np.sum(pressure * area * moves)
    return power


def lost_power(model, positions, velocities):
    """Return what dashpots and the nodes' own damping take [W]: c (dl/dt)^2, nu m v^2."""
    across, down, diagonal = model.spring_c
    share_across = model.mesh.grid(model.mesh.weights.across)[:, :-1]
    share_down = model.mesh.grid(model.mesh.weights.down)[:-1]
    power = 2.0 * model.material.node_damping * kinetic_energy(model, velocities)
    for c, share, begin, end in (
            (across, share_across, np.s_[:, :-1], np.s_[:, 1:]),
            (down, share_down, np.s_[:-1], np.s_[1:]),
            (diagonal, 1.0, np.s_[:-1, :-1], np.s_[1:, 1:]),
            (diagonal, 1.0, np.s_[1:, :-1], np.s_[:-1, 1:])):
        along = positions[end] - positions[begin]
        rate = np.sum(along * (velocities[end] - velocities[begin]), axis=-1)
        power += np.sum(c * share * (rate / np.linalg.norm(along, axis=-1))**2)
    return power


def balance(solver, count, node_damping, added_mass=0.0):
    """Return the air's work [J], and what change of energy and losses leave of it."""
    # The seed's friction vanishes with the step, and eq. 1.3 ignores the cloth's velocity.
    letter = solver == 'seed'
    air = Air(law='seed' if letter else 'quadratic', added_mass=added_mass)
    cloth = Cloth(5, 7, solver=solver, air=air,
                  material=Material(bend_stiffness=0.01, damping=0.0 if letter else 0.3,
                                    node_damping=node_damping),
                  stepping=Stepping(substeps=count, substeps_limit=10**4))
    bent = cloth.positions
    bent[..., 1] += 0.02 * bent[..., 0]**2
    cloth.place(bent)
    model = model_of(cloth)
    mass = model.mesh.grid(model.mass)[..., None]
    before = energy(cloth, 9.81)
    powers = []
    for n in range(SAMPLES + 1):
        if n > 0:
            assert cloth.advance(FRAME / SAMPLES, WIND).granted == count
        at = cloth.positions, cloth.velocities
        inertia = moving_air.momentary(model, Forcing(WIND, air=air), *at) if added_mass else 0.0
        power = float(np.sum(mass * inertia * at[1]))
        powers.append((wind_power(air, *at) + power, lost_power(model, *at)))
    work, loss = romb(np.array(powers), dx=FRAME / SAMPLES, axis=0)
    return work, work - (energy(cloth, 9.81) - before) - loss


@pytest.mark.parametrize('solver, node_damping, added_mass', [
    *((solver, nu, 0.0) for solver in SOLVERS for nu in (0.0, 2.0)
      if solver != 'seed' or nu == 0.0), ('symplectic', 0.0, 0.5)])
def test_work_of_the_wind_is_change_of_energy_and_loss(solver, node_damping, added_mass):
    """What is missing falls with the step as the method claims; see test_cloth_order."""
    order = SOLVERS[solver].order if node_damping == 0.0 else min(SOLVERS[solver].order, 2)
    missing = []
    for n in range(HALVINGS + 1):
        work, rest = balance(solver, FIRST[SOLVERS[solver].order] * 2**n, node_damping,
                             added_mass)
        missing.append(abs(rest) / work)
    assert missing[0] < 0.01
    for coarse, fine in zip(missing, missing[1:]):
        if fine > FLOOR:
            # Where iterations end changes from step to step, and moves implicit's thousandth.
            slack = 0.25 if solver == 'implicit' else 0.1
            assert np.log2(coarse / fine) == pytest.approx(order, abs=slack)


@pytest.mark.parametrize('solver', ['xpbd', 'rk4', 'implicit'])
def test_methods_that_lose_energy_never_give_any(solver):
    """Without damping and wind it falls in every frame, in steps that resolve the motion."""
    cloth = Cloth(6, 8, solver=solver, air=VACUUM, material=Material(damping=0.0),
                  stepping=Stepping(substeps=40))
    rng = np.random.default_rng(4)
    cloth.place(cloth.positions, rng.normal(size=(6, 8, 3)))
    energies = [energy(cloth, 9.81)]
    for _ in range(300):
        cloth.advance(0.01)
        energies.append(energy(cloth, 9.81))
    assert np.all(np.diff(energies) < 0.0)


@pytest.mark.parametrize('stiffness', [1e6, 1e9])
def test_a_system_that_is_not_solved_to_the_end_gives_no_energy(stiffness):
    """
    So stiff that implicit's iterations end early, and so still that the cloth is linear.

    Without the rule that sees to it, the energy rises by half of all there is, and by a thousand
    times that. Positions, rounded to 1e-16 m, are felt by springs of 1e9 N/m as 1e-7 of it.
    """
    cloth = Cloth(15, 20, hoist_top=(0.0, 0.0, 0.0), solver='implicit', air=VACUUM, gravity=0.0,
                  material=Material(0.2, stiffness, 0.5 * stiffness, 0.0, damping=0.0),
                  stepping=Stepping(substeps=1, substeps_limit=1))
    cloth.place(cloth.positions, 1e-7 * np.random.default_rng(4).normal(size=(15, 20, 3)))
    energies = [energy(cloth, 0.0)]
    for _ in range(100):
        cloth.advance(0.01)
        energies.append(energy(cloth, 0.0))
    assert np.diff(energies).max() < 1e-6 * energies[0]
