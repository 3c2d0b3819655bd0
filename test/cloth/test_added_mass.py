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
"""The inertia of the air that moves with the cloth: theory, work, and what is refused."""
import math

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.added_mass import AddedMass
from flag_sim.cloth.drag import DRAG_LAWS
from flag_sim.cloth.energy import kinetic_energy
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.mesh import PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.pole_frame import PoleFrame
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stations import Stations
from flag_sim.declarations.physics import check_method, PHYSICS
import numpy as np
import pytest
from support import moving_air
from support.forces import crumpled

LIMP = Material(0.5, 0.0, 0.0, 0.0, 0.0)
HARDLY = 1e-12  # a drag coefficient of hardly any drag: the wind is on, and only inertia acts


def inertia(air, width):
    """Return the added mass of an area [kg/m2]."""
    return air.added_mass * air.density * math.pi * width / 4.0


def flat(rows, columns, **options):
    """Return a limp cloth that is free, of 2 x 0.5 m, and lies level at rest."""
    cloth = Cloth(rows, columns, 2.0, 0.5, pinned=False, start_noise=0.0, material=LIMP, **options)
    positions = cloth.positions
    positions[..., 1], positions[..., 2] = positions[..., 2].copy(), 0.0
    cloth.place(positions)
    return cloth


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('grid', [(5, 9), (2, 2), (3, 40)], ids=str)
def test_a_level_sheet_falls_with_the_air_below_it(grid, precision):
    """By g m / (m + M), all of it alike."""
    air = Air(drag_coefficient=HARDLY, added_mass=0.7)
    cloth = flat(*grid, air=air, precision=precision)
    cloth.advance(1e-3)
    expected = -9.81e-3 * 0.5 / (0.5 + inertia(air, 0.5))
    tolerance = {'float64': 1e-9, 'float32': 1e-4}[precision]
    np.testing.assert_allclose(cloth.velocities[..., 2], expected, rtol=tolerance)
    np.testing.assert_allclose(cloth.velocities[..., :2], 0.0, atol=1e-9)


@pytest.mark.parametrize('grid, precision', [
    ((21, 31), 'float64'), ((21, 31), 'float32'), ((5, 2), 'float64'), ((2, 40), 'float64')])
def test_a_step_is_that_in_plain_numpy(grid, precision):
    """What the term adds to velocities of a crumpled cloth, its hoist pinned."""
    wind, dt = (3.0, -1.0, 0.5), 1e-5
    plain, moving = (Cloth(*grid, air=Air(added_mass=share), precision=precision)
                     for share in (0.0, 0.6))
    at = crumpled(plain.mesh)
    for cloth in (plain, moving):
        cloth.place(*at)
        cloth.advance(dt, wind)
    velocities = at[1] * plain.mesh.grid(plain.mesh.free)[..., None]
    expected = moving_air.accelerations(
        plain.model, Forcing(wind, air=moving.air), at[0], velocities,
        (plain.velocities - velocities) / dt, dt)
    found = (moving.velocities - plain.velocities) / dt
    close = {'float64': 1e-6, 'float32': 1e-2}[precision]
    np.testing.assert_allclose(found, expected, atol=close * np.abs(expected).max())


@pytest.mark.parametrize('law', DRAG_LAWS)
def test_the_wind_is_that_past_the_pole_by_every_law(law):
    """Also where the drag itself knows no motion."""
    model = Model(Cloth(5, 7).mesh, Material())
    forcing = Forcing((6.0, 2.0, 0.5), air=Air(law=law, added_mass=0.5))
    moving = PoleFrame(velocity=np.array([1.0, -3.0, 0.25]))
    air = AddedMass.of(Stations.of(model), model, moving.seen(forcing))
    np.testing.assert_allclose(air.wind, (5.0, 5.0, 0.25))


def pressure(columns, width):
    """Return the found and the expected pressure [Pa] on the middle of a wave that travels."""
    length, wind, size = 2.0, 7.0, 1e-4
    k, omega = 2.0 * math.pi / length, 30.0
    air = Air(drag_coefficient=HARDLY, added_mass=1e-6)  # so that the cloth's own answer is small
    cloth = Cloth(5, columns, length, width, pinned=False, start_noise=0.0, gravity=0.0, air=air,
                  material=LIMP)
    positions = cloth.positions
    phase = k * (positions[..., 0] - positions[0, 0, 0])
    positions[..., 1] += size * np.sin(phase)
    velocities = np.zeros_like(positions)
    velocities[..., 1] = -size * omega * np.cos(phase)
    cloth.place(positions, velocities)
    dt = 1e-7
    cloth.advance(dt, (wind, 0.0, 0.0))
    found = (cloth.velocities - velocities)[2, :, 1] / dt * 0.5
    # Of y = size sin(k x - omega t), without its y_tt: that is what the cloth does itself.
    expected = -inertia(air, width) * (
        2.0 * wind * size * omega * k - wind**2 * size * k**2) * np.sin(phase[2])
    return found, expected


def test_the_force_on_a_small_wave_is_lighthills():
    """
    It is p = -M (2 U y_xt + U^2 y_xx), to first order in the distance of the stations.

    The normal of the cloth, by which it is seen, is -y here: both signs cancel.
    """
    errors = []
    for width in (0.625, 0.3125):  # 17 and 33 stations
        found, expected = pressure(129, width)
        inner = slice(20, -20)
        errors.append(np.abs(found - expected)[inner].max() / np.abs(expected).max())
    assert errors[0] < 0.5
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize('speed', [0.0, 20.0])
def test_the_air_gives_no_more_energy_than_it_may(speed):
    """In one step of crumpled, limp cloths: at most rho / 2 L H W^3 dt; none in calm air."""
    gains = []
    for seed in range(30):
        cloth = Cloth(6, 9, 1.1, 0.9, air=Air(drag_coefficient=HARDLY, added_mass=0.8),
                      material=LIMP, gravity=0.0, stretch_limit=1e6)
        positions, velocities = crumpled(cloth.mesh, seed, size=0.2 + 0.05 * seed)
        cloth.place(positions - positions[0, 0] + cloth.hoist_top, 5.0 * velocities)
        before = kinetic_energy(cloth.model, cloth.velocities)
        cloth.advance(1e-3, (speed, 0.0, 0.0))
        gains.append(kinetic_energy(cloth.model, cloth.velocities) - before)
    assert max(gains) <= 0.5 * 1.2 * 1.1 * 0.9 * speed**3 * 1e-3 * (1.0 + 1e-9) + 1e-12
    assert min(gains) < 0.0


def test_without_added_mass_nothing_is_made_ready():
    """The term at zero costs nothing: there are no stations, and kernels without it."""
    cloth = Cloth(5, 7, air=Air(drag_coefficient=0.0, added_mass=0.5))
    cloth.advance(0.01)
    assert cloth._planned.solver._stations is None and cloth._planned.solver._scratch is None
    cloth.air = Air(added_mass=0.5)
    cloth.advance(0.01)
    assert len(cloth._planned.solver._stations.mass) == 7
    cloth.air = Air()
    cloth.advance(0.01)
    assert cloth._planned.solver._scratch is None


def test_stations_are_a_fifth_of_the_width_apart_and_not_too_many():
    def count(columns, length, width):
        stations = Stations.of(Model(Cloth(3, columns, length, width).mesh, LIMP))
        assert stations.mass.sum() == pytest.approx(0.5 * length * width)
        assert np.linalg.eigvalsh(stations.compliance).min() > -1e-12
        return len(stations.mass)

    assert count(31, 2.25, 1.5) == 9
    assert count(5, 2.25, 1.5) == 5 and count(2, 2.25, 1.5) == 2
    assert count(101, 50.0, 1.0) == 33 and count(31, 0.01, 10.0) == 2


@pytest.mark.parametrize('solver', [name for name, kind in SOLVERS.items() if not kind.moves_air])
def test_other_methods_refuse_it_where_it_is_set_and_leave_the_cloth(solver):
    """When the cloth is made, gets other air, or another method; not only when it moves."""
    moving, rule = Air(added_mass=0.5), 'added_mass above 0 needs solver symplectic'
    with pytest.raises(ValueError, match=rule):
        Cloth(5, 7, solver=solver, air=moving)
    cloth = Cloth(5, 7, solver=solver)
    with pytest.raises(ValueError, match=rule):
        cloth.air = moving
    assert cloth.air == Air()
    cloth.advance(0.01, (5.0, 1.0, 0.0))
    cloth = Cloth(5, 7, air=moving)
    with pytest.raises(ValueError, match=rule):
        cloth.solver = solver
    assert cloth.solver == 'symplectic'
    cloth.advance(0.01, (5.0, 1.0, 0.0))
    values = {declaration.name: declaration.default for declaration in PHYSICS}
    with pytest.raises(ValueError, match='solver symplectic'):
        check_method({**values, 'solver': solver, 'air.added_mass': 0.1})
    check_method({**values, 'solver': solver})
    check_method({**values, 'air.added_mass': 0.1})


@pytest.mark.parametrize('share', [-0.1, 1.1, math.nan])
def test_other_shares_are_refused(share):
    with pytest.raises(ValueError, match='added_mass'):
        Air(added_mass=share)


@pytest.mark.parametrize('grid', [(21, 31), (9, 2), (2, 2)], ids=str)
@pytest.mark.parametrize('wind, density', [
    ((0.0, 0.0, 0.0), 1.2), ((0.0, 0.0, -9.0), 1.2), ((200.0, 0.0, 0.0), 1.2),
    ((-200.0, 3.0, 0.0), 1.2), ((12.0, 4.0, 0.0), 0.0), ((12.0, 4.0, 0.0), 1000.0)], ids=str)
def test_odd_scenes_stay_bounded(grid, wind, density):
    """At a pole, which the cloth is blown against too: within reach, not much faster than W."""
    cloth = Cloth(*grid, pole=(0.0, 0.0, 0.05), air=Air(density=density, added_mass=1.0),
                  stepping=Stepping(substeps_limit=100))
    for _ in range(30):
        cloth.advance(1.0 / 30.0, wind)
    speeds = np.linalg.norm(cloth.velocities, axis=-1)
    assert np.linalg.norm(cloth.positions - cloth.positions[:, :1], axis=-1).max() <= 4.5
    assert np.sqrt(np.mean(speeds**2)) < 2.0 * np.linalg.norm(wind) + 10.0
