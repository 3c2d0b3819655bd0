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

"""What the flag does to its pole, against the balance of momentum."""
from flag_sim.cloth import Air, Cloth, Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.pole_load import pole_load
from flag_sim.drawing.transforms import rotate_y, rotate_z, translate
import numpy as np
import pytest
from support import moving_air
from support.forces import crumpled, forces

WIND = (7.0, 4.0, 1.0)


def still(time):
    """Return the pose of a pole that stands."""
    return np.eye(4)


def swaying(time):
    """Return the pose of a pole that drives, turns and leans."""
    return translate((2.0 * time, -time * time, 0.0)) @ rotate_z(1.5 * time) @ rotate_y(0.3 * time)


def moved(way=still, **arguments):
    """Return a cloth in the midst of its motion, on a pole on its way for a second."""
    cloth = Cloth(9, 13, start_noise=0.02, **arguments)
    for frame in range(1, 31):
        cloth.advance(1 / 30, WIND, way(frame / 30))
    return cloth


def momenta(cloth, centre):
    """Return the momentum [N s] of the nodes that are not pinned, and its moment."""
    p = cloth.mesh.grid(cloth.model.mass * cloth.mesh.free)[..., None] * cloth.velocities
    return p.sum(axis=(0, 1)), np.cross(cloth.positions - centre, p).sum(axis=(0, 1))


def outside(cloth, centre):
    """Return the force [N] of wind, weight and the air's inertia on a cloth, and its moment."""
    mass = cloth.mesh.grid(cloth.model.mass)[..., None]
    model, at = moving_air.unpinned(cloth.model), (cloth.positions, cloth.velocities)
    force = forces(model, *at, WIND, 0.0, cloth.air) - forces(model, *at)
    force += mass * [0.0, 0.0, -cloth.gravity]
    if cloth.air.added_mass:
        force += mass * moving_air.momentary(cloth.model, Forcing(WIND, air=cloth.air), *at)
    return force.sum(axis=(0, 1)), np.cross(at[0] - centre, force).sum(axis=(0, 1))


@pytest.mark.parametrize('way', [still, swaying])
@pytest.mark.parametrize('air', [
    Air(), Air(law='linear'), Air(law='seed'), Air(added_mass=0.5)], ids=str)
def test_it_is_what_changes_the_momentum_beside_air_and_weight(air, way):
    """Force and moment over a frame of a microsecond, by the mean of its ends."""
    cloth, dt = moved(way, air=air), 1e-6
    cloth.advance(dt, WIND, way(1.0 + dt))
    centre = cloth.positions[0, 0]
    before, loads = momenta(cloth, centre), [pole_load(cloth, WIND)]
    acting = [outside(cloth, centre)]
    cloth.advance(dt, WIND, way(1.0 + 2.0 * dt))
    loads.append(pole_load(cloth, WIND))
    acting.append(outside(cloth, centre))
    for k, after in enumerate(momenta(cloth, centre)):
        change = (after - before[k]) / dt
        expected = 0.5 * (acting[0][k] + acting[1][k]) - change
        load = 0.5 * (loads[0][k] + loads[1][k])
        assert np.linalg.norm(load) > 0.5
        assert np.linalg.norm(load - expected) < 1e-3 * np.linalg.norm(load)


@pytest.mark.parametrize('shape', [(2, 2), (3, 2), (2, 3), (6, 9)])
@pytest.mark.parametrize('law', ['quadratic', 'linear', 'seed'])
def test_it_is_the_sum_of_the_kernels_forces_on_the_hoist(shape, law):
    """Of a crumpled cloth, each force in it."""
    cloth = Cloth(*shape, air=Air(law=law), material=Material(bend_stiffness=0.1))
    cloth.place(*crumpled(cloth.mesh))
    force = forces(cloth.model, cloth.positions, cloth.velocities, WIND, cloth.gravity,
                   cloth.air)[:, 0]
    load = pole_load(cloth, WIND)
    assert np.allclose(load.force, force.sum(axis=0), rtol=1e-6)
    arm = cloth.positions[:, 0] - cloth.hoist_top
    assert np.allclose(load.moment, np.cross(arm, force).sum(axis=0), rtol=1e-5, atol=1e-6)


def test_a_flag_that_hangs_still_is_borne_by_its_pole():
    """With its weight, which pulls it down and turns it over."""
    cloth = Cloth(9, 13, material=Material(node_damping=6.0))
    for _ in range(200):
        cloth.advance(0.1)
    load = pole_load(cloth, (0.0, 0.0, 0.0))
    weight = cloth.model.mass.sum() * cloth.gravity
    assert np.allclose(load.force, [0.0, 0.0, -weight], atol=0.02 * weight)
    assert load.moment[1] > 0.05 * weight


def test_a_free_cloth_has_none():
    cloth = Cloth(5, 7, pinned=False)
    assert not np.any(pole_load(cloth, WIND))


@pytest.mark.parametrize('arguments', [('cloth', WIND), (Cloth(5, 7), (1.0, 2.0)),
                                       (Cloth(5, 7), (np.nan, 0.0, 0.0))])
def test_what_cannot_be_asked_is_refused(arguments):
    with pytest.raises(ValueError):
        pole_load(*arguments)


def test_the_forcing_of_a_cloth_is_that_of_its_load():
    """A stronger wind pulls more."""
    cloth = moved()
    weak, strong = (np.linalg.norm(pole_load(cloth, factor * np.array(WIND)).force)
                    for factor in (1.0, 3.0))
    assert strong > weak and Forcing(WIND).gravity == cloth.gravity
