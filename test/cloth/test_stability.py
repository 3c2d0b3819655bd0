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

"""The stability bound against true eigenvalues, and the division of frames into steps."""
import math

from flag_sim.cloth import Air, Cloth, Diverged, Material, Stepping
from flag_sim.cloth.energy import bending_energy, elastic_energy
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import rk4, SOLVERS
from flag_sim.cloth.stability import damping_bound, frequency_bound, plan
import numpy as np
import pytest
from support.forces import jacobian, largest_eigenvalue

MATERIALS = {
    'default': Material(),
    'threads': Material(shear_stiffness=0.0, bend_stiffness=0.0),
    'shear': Material(stiffness=0.0, shear_stiffness=800.0, bend_stiffness=0.0),
    'plate': Material(stiffness=0.0, shear_stiffness=0.0, bend_stiffness=2.0),
    'both': Material(bend_stiffness=1.0),
}


@pytest.mark.parametrize('grid', [(2, 2), (5, 6), (3, 9), (7, 4)], ids=str)
@pytest.mark.parametrize('name', MATERIALS)
@pytest.mark.parametrize('size', [0.0, 0.02, 0.4])
def test_no_state_has_a_higher_frequency_than_the_bound(grid, name, size):
    """At rest, deformed and crumpled, with pins and without; and the bound is close at rest."""
    for pinned in (False, True):
        mesh = Mesh(*grid, 1.2, 0.8, pinned)
        model = Model(mesh, MATERIALS[name])
        rng = np.random.default_rng(5)
        rest = mesh.rest((0.0, 0.0, 0.0))
        positions = rest + size * mesh.dx * rng.normal(size=rest.shape)
        matrix = jacobian(model, positions, np.zeros_like(rest), 'positions')
        true = math.sqrt(largest_eigenvalue(model, matrix, mesh.grid(mesh.free)))
        bound = frequency_bound(model)
        assert true <= bound * (1.0 + 1e-6)
        if size == 0.0 and not pinned and min(grid) > 2:
            assert true > 0.6 * bound


@pytest.mark.parametrize('grid', [(2, 2), (5, 6), (3, 9)], ids=str)
@pytest.mark.parametrize('size', [0.0, 0.4])
def test_no_state_is_damped_faster_than_the_bound(grid, size):
    """The dashpots' matrix, likewise."""
    mesh = Mesh(*grid, 1.2, 0.8, pinned=False)
    model = Model(mesh, Material(damping=0.7))
    rng = np.random.default_rng(5)
    rest = mesh.rest((0.0, 0.0, 0.0))
    positions = rest + size * mesh.dx * rng.normal(size=rest.shape)
    matrix = jacobian(model, positions, rng.normal(size=rest.shape), 'velocities')
    true = largest_eigenvalue(model, matrix, mesh.grid(mesh.free))
    bound = damping_bound(model)
    assert true <= bound * (1.0 + 1e-6)
    if size == 0.0:
        assert true > 0.4 * bound


def test_the_bound_of_damping_is_reached():
    """By neighbours in a row that move against each other, where cells are 100 times as wide."""
    mesh = Mesh(3, 9, 0.08, 2.0, pinned=False)
    model = Model(mesh, Material(shear_stiffness=0.0, damping=0.7))
    rest = mesh.rest((0.0, 0.0, 0.0))
    matrix = jacobian(model, rest, np.zeros_like(rest), 'velocities')
    # Columns have springs, and with the root of stiffness dashpots, that add a part 1/100 to it.
    true = largest_eigenvalue(model, matrix, mesh.grid(mesh.free))
    assert 0.98 < true / damping_bound(model) < 1.0 + 1e-6


@pytest.mark.parametrize('omega, gamma', [(1.0, 0.0), (30.0, 1.0), (1.0, 5.0), (0.0, 3.0)])
def test_the_symplectic_step_is_stable_up_to_its_largest_and_not_beyond(omega, gamma):
    """The eigenvalues of one step's amplification matrix."""
    def growth(h):
        v_row = (-h * omega**2, 1.0 - h * gamma)
        matrix = np.array([[1.0 + h * v_row[0], h * v_row[1]], v_row])
        return np.abs(np.linalg.eigvals(matrix)).max()

    largest = SOLVERS['symplectic'].largest_step(omega, gamma, VACUUM)
    assert growth(0.999 * largest) <= 1.0 + 1e-12
    assert growth(1.001 * largest) > 1.0 + 1e-6


def test_nothing_to_resist_needs_one_step():
    """Without springs every step is stable."""
    cloth = Cloth(4, 5, material=Material(stiffness=0.0, shear_stiffness=0.0, bend_stiffness=0.0))
    assert cloth.advance(1.0) == (1, 1, 1.0, 1.0)


def test_plans_ask_for_what_the_material_needs():
    """Fixed substeps are taken where they are stable, and refined where they are not."""
    def planned(dt=0.01, omega=1000.0, gamma=0.0, **parameters):
        return plan(dt, omega, gamma,
                    lambda w, g: SOLVERS['symplectic'].largest_step(w, g, VACUUM),
                    Stepping(step_safety=0.5, **parameters))

    assert planned() == (10, 10, 1.0, 1.0)
    assert planned(substeps=25) == (10, 25, 1.0, 1.0)
    assert planned(substeps=3) == (10, 10, 1.0, 1.0)
    assert planned(substeps_limit=5) == (10, 5, pytest.approx(0.25), 1.0)
    damped = planned(gamma=1e6, substeps_limit=100)
    assert damped.stiffness_factor == 1.0 and 0.0 < damped.damping_factor < 0.1
    both = planned(gamma=1e6, substeps_limit=5)
    assert both.stiffness_factor < 0.25 and 0.0 < both.damping_factor < 1e-3


@pytest.mark.parametrize('gamma', [0.0, 10.0, 1500.0, 1e4, 1e8])
@pytest.mark.parametrize('limit', [1, 7, 50])
def test_a_softened_cloth_is_stable_in_the_steps_granted(gamma, limit):
    """And keeps its damping ratio up to the critical."""
    def largest(omega, rate):
        return SOLVERS['symplectic'].largest_step(omega, rate, Air())

    omega, dt = 4000.0, 0.04
    steps = plan(dt, omega, gamma, largest, Stepping(step_safety=1.0, substeps_limit=limit))
    assert steps.demanded > steps.granted == limit
    softened = (omega * math.sqrt(steps.stiffness_factor), gamma * steps.damping_factor)
    assert largest(*softened) * (1.0 + 1e-9) >= dt / limit
    if gamma:
        assert softened[1] / softened[0] == pytest.approx(min(gamma / omega, 2.0))


@pytest.mark.parametrize('solver', ['verlet', 'rk4'])
@pytest.mark.parametrize('omega, gamma', [(1.0, 0.0), (30.0, 1.0), (1.0, 5.0), (0.0, 3.0)])
def test_the_largest_steps_of_higher_orders_are_stable(solver, omega, gamma):
    """The spectral radius of one step for a single mode, by the method's own definition."""
    h = 0.999 * SOLVERS[solver].largest_step(omega, gamma, VACUUM)

    def rate(x, v):
        return -omega**2 * x - gamma * v

    def verlet(x, v, a):
        x, predicted = x + h * v + 0.5 * h * h * a, v + h * a
        after = rate(x, predicted)
        return x, v + 0.5 * h * (a + after), after

    if solver == 'verlet':
        matrix = np.array([verlet(*unit) for unit in np.eye(3)]).T
    else:
        step = h * np.array([[0.0, 1.0], [-omega**2, -gamma]])
        matrix = sum(np.linalg.matrix_power(step, n) / math.factorial(n) for n in range(5))
    assert np.abs(np.linalg.eigvals(matrix)).max() <= 1.0 + 1e-9


def test_the_region_of_rk4_holds_the_half_disc_that_it_is_taken_for():
    """R(z) = sum z^n / n! to the fourth order; and a half disc larger by a twentieth not."""
    def growth(radius):
        z = radius * np.exp(1j * np.linspace(0.5, 1.5, 2001) * np.pi)
        return np.abs(sum(z**n / math.factorial(n) for n in range(5))).max()

    assert growth(rk4.STABILITY_RADIUS) <= 1.0 < growth(1.05 * rk4.STABILITY_RADIUS)


@pytest.mark.parametrize('solver', ['euler', 'seed'])
def test_what_diverges_by_nature_is_held_and_goes_on(solver):
    """Light cloth in a storm by eq. 1.3 as published: the message has the bound and a way out."""
    cloth = Cloth(5, 7, solver=solver, air=Air(law='seed'), stretch_limit=1e6,
                  material=Material(1e-6, damping=0.0), stepping=Stepping(substeps_limit=5))
    told = f'beyond .* solver {solver} .*; no step is stable for {solver}; symplectic is stable'
    with pytest.raises(Diverged, match=told):
        for _ in range(100):
            good = cloth.positions
            cloth.advance(0.1, (0.0, 200.0, 0.0))
    assert np.array_equal(cloth.positions, good)
    cloth.material = Material()
    cloth.air = Air()
    cloth.reset()
    cloth.advance(0.01, (0.0, 2.0, 0.0))
    assert np.isfinite(cloth.positions).all()


def test_a_cloth_without_stiffness_falls_for_minutes():
    """Nothing holds it, so it flies away; its numbers stay numbers."""
    cloth = Cloth(5, 7, material=Material(stiffness=0.0, shear_stiffness=0.0))
    for _ in range(600):
        cloth.advance(0.5, (100.0, 20.0, 0.0))
    assert np.isfinite(cloth.positions).all()
    assert np.isfinite(cloth.normals()).all()


SIDE = 9
"""Nodes along either side of the sheet with the stiffest wave."""


@pytest.mark.parametrize('name, along, part', [
    ('plate', 1, ((SIDE - 2) / (SIDE - 1) + 1.0) / 2.0), ('threads', 0, 1.0 / 2.0)])
def test_the_energies_and_the_bound_speak_of_the_same_springs(name, along, part):
    """
    The stiffest wave, put on a free sheet of square cells, has the frequency that the bound says.

    Of a plate: but for the borders, which have no curvature across them; half of the bound is of
    curvatures and half of twist. Of threads: in the plane, where a wave moves one of the two
    families. The energies are those of small waves to 1e-8, the square of their height.
    """
    mesh = Mesh(SIDE, SIDE, 1.0, 1.0, pinned=False)
    model = Model(mesh, MATERIALS[name])
    rows, columns = np.indices((SIDE, SIDE))
    rest = mesh.rest((0.0, 0.0, 0.0))
    wave = rest.copy()
    wave[..., along] += 1e-4 * mesh.dx * (-1.0)**(columns + (rows if name == 'plate' else 0))
    energy = bending_energy(model, wave) + elastic_energy(model, wave)
    inertia = 0.5 * (1e-4 * mesh.dx)**2 * model.mass.sum()
    assert energy / inertia == pytest.approx(part * frequency_bound(model)**2, rel=2e-8)
