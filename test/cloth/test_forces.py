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

"""Forces against energies and conservation laws, and wind against its law."""
import math

from flag_sim.cloth.drag import DRAG_LAWS
from flag_sim.cloth.energy import bending_energy, elastic_energy
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.model import Model
import numpy as np
import pytest
from support.forces import crumpled, forces


def rounding(mesh, units=500):
    """Return so many units in the last place of the mesh's precision: 1e-13 in float64."""
    return units * np.finfo(mesh.precision).eps


@pytest.fixture(params=PRECISIONS)
def precision(request):
    """Return the precisions that a cloth may have."""
    return request.param


@pytest.fixture(params=[(5, 7), (2, 2), (2, 5), (4, 2), (9, 6)], ids=str)
def mesh(request, precision):
    """Return grids of all shapes, some with oblong cells, free of pins."""
    return Mesh(*request.param, 1.1, 0.9, pinned=False, precision=precision)


def test_elastic_forces_are_minus_the_gradient_of_the_energy(mesh):
    """Central differences of the numpy energies, springs and bending together."""
    model = Model(mesh, Material(stiffness=700.0, shear_stiffness=300.0, bend_stiffness=0.4,
                                 damping=0.0))
    positions, _ = crumpled(mesh)
    found = forces(model, positions)

    def energy(at):
        return elastic_energy(model, at) + bending_energy(model, at)

    step = 1e-6
    expected = np.empty_like(found)
    for index in np.ndindex(positions.shape):
        above, below = positions.copy(), positions.copy()
        above[index] += step
        below[index] -= step
        expected[index] = (energy(below) - energy(above)) / (2.0 * step)
    # The differences are good to 1e-6; the float32 are, to some hundred units, of lengths.
    tolerance = max(1e-6, rounding(mesh, 100))
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max())


def test_internal_forces_have_neither_sum_nor_torque(mesh):
    """Springs, dashpots and bending act between nodes: sum F = 0 and sum x cross F = 0."""
    model = Model(mesh, Material(bend_stiffness=0.1, damping=0.5))
    positions, velocities = crumpled(mesh)
    found = forces(model, positions, velocities)
    size = np.abs(found).sum()
    assert np.abs(found.sum(axis=(0, 1))).max() < rounding(mesh) * size
    assert np.abs(np.cross(positions, found).sum(axis=(0, 1))).max() < rounding(mesh, 5000) * size


def test_dashpots_take_power_and_leave_rigid_motion_alone(mesh):
    """They lower the energy of any deformation, and do not feel a cloth that flies and turns."""
    damped = Model(mesh, Material(damping=0.3))
    elastic = Model(mesh, Material(damping=0.0))
    positions, velocities = crumpled(mesh)
    friction = forces(damped, positions, velocities) - forces(elastic, positions)
    assert np.sum(friction * velocities) < 0.0
    rigid = np.cross((0.4, -1.0, 2.0), positions) + (3.0, 1.0, -2.0)
    friction = forces(damped, positions, rigid) - forces(elastic, positions)
    assert np.abs(friction).max() < rounding(mesh, 5000) * np.abs(forces(elastic, positions)).max()


@pytest.mark.parametrize('law', DRAG_LAWS)
def test_wind_is_the_pressure_on_each_face(mesh, law):
    """
    F = rho C_d / 2 A |u_n| u_n n, shared 1/2, 1/4, 1/4, against a plain loop over faces.

    By the linear law 1 m/s stands for |u_n|; by eq. 1.3 as published F is n (n . w).
    """
    model = Model(mesh, Material(0.2, 0.0, 0.0, 0.0, 0.0))
    positions, velocities = crumpled(mesh)
    wind, air = (4.0, -3.0, 1.0), Air(1.3, 0.9, law)
    expected = np.zeros_like(positions)
    for r in range(mesh.rows - 1):
        for c in range(mesh.columns - 1):
            for face in (((r, c), (r, c + 1), (r + 1, c)),
                         ((r + 1, c + 1), (r + 1, c), (r, c + 1))):
                a, b, d = (positions[node] for node in face)
                area = 0.5 * np.cross(b - a, d - a)
                n = area / np.linalg.norm(area)
                shares = (0.5, 0.25, 0.25)
                v = sum(share * velocities[node] for share, node in zip(shares, face))
                u = np.dot(np.array(wind) - v, n)
                drag = 0.5 * 1.3 * 0.9 * np.linalg.norm(area)
                force = n * {'quadratic': drag * abs(u) * u, 'linear': drag * u,
                             'seed': np.dot(wind, n)}[law]
                for share, node in zip(shares, face):
                    expected[node] += share * force
    found = forces(model, positions, velocities, wind, air=air)
    np.testing.assert_allclose(found, expected, atol=rounding(mesh, 5000) * np.abs(expected).max())


def test_a_flat_sheet_in_wind_is_accelerated_alike_everywhere(mesh):
    """At the borders and corners too: shares of force are those of mass."""
    model = Model(mesh, Material(0.3, 0.0, 0.0, 0.0, 0.0))
    air, wind, dt = Air(1.2, 1.1), (1.0, 7.0, 2.0), 0.01
    found = forces(model, mesh.rest((0.0, 0.0, 0.0)), wind=wind, air=air, dt=dt)
    acceleration = found / mesh.grid(model.mass)[..., None]
    explicit = 0.5 * 1.2 * 1.1 * 7.0**2 / 0.3
    rate = 1.2 * 1.1 * 7.0 / 0.3
    expected = np.broadcast_to([0.0, explicit / (1.0 + dt * rate), 0.0], acceleration.shape)
    np.testing.assert_allclose(acceleration, expected, rtol=rounding(mesh), atol=rounding(mesh))


@pytest.mark.parametrize('dt', [1e-3, 1.0, 1e6])
def test_wind_never_overshoots_however_long_the_step(mesh, dt):
    """A step's change of velocity stays below half the relative wind: drag is implicit."""
    model = Model(mesh, Material(1e-6, 0.0, 0.0, 0.0, 0.0))
    positions, _ = crumpled(mesh, size=3.0)
    found = forces(model, positions, wind=(0.0, 200.0, 0.0), air=Air(), dt=dt)
    change = dt * found / mesh.grid(model.mass)[..., None]
    assert np.abs(change).max() <= 100.0 * (1.0 + rounding(mesh, 10))


def test_power_of_the_wind_is_never_positive_in_still_air(mesh):
    """Air at rest only takes energy away."""
    model = Model(mesh, Material(0.2, 0.0, 0.0, 0.0, 0.0))
    positions, velocities = crumpled(mesh)
    found = forces(model, positions, velocities, air=Air())
    assert np.sum(found * velocities) < 0.0


def test_gravity_is_weight(mesh):
    """Force m g downwards, whatever the state (eq. 1.1)."""
    model = Model(mesh, Material(0.2, 0.0, 0.0, 0.0, 0.0))
    positions, velocities = crumpled(mesh)
    found = forces(model, positions, velocities, gravity=9.81)
    assert np.all(found[..., :2] == 0.0)
    assert found[..., 2].sum() == pytest.approx(-9.81 * 0.2 * 1.1 * 0.9)


def test_collapsed_springs_and_faces_give_zero_not_nan(mesh):
    """All nodes in one point: no direction, no force, no wind."""
    model = Model(mesh, Material(damping=0.5))
    positions = np.zeros((mesh.rows, mesh.columns, 3))
    velocities = np.random.default_rng(3).normal(size=positions.shape)
    found = forces(model, positions, velocities, wind=(math.pi, 2.0, 1.0), air=Air(), dt=1e-3)
    assert np.all(found == 0.0)


def test_a_flag_stays_to_the_bit_in_a_plane_that_holds_wind_and_gravity(precision):
    """No force takes a flat flag out of the plane of the wind: unstable, but an equilibrium."""
    mesh = Mesh(6, 8, 1.2, 0.8, precision=precision)
    model = Model(mesh, Material())
    positions, velocities = crumpled(mesh, size=0.1)
    positions[..., 1], velocities[..., 1] = 0.0, 0.0
    found = forces(model, positions, velocities, (9.0, 0.0, -1.0), 9.81, Air(), 1e-3)
    assert np.all(found[..., 1] == 0.0)
