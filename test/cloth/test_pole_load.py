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
"""The load on the pole against the change of momentum, and against statics."""
from flag_sim.cloth import Cloth, Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import Air, VACUUM
from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.pole_load import load_in_step, pole_load, weight
from flag_sim.cloth.state import State
import numpy as np
import pytest
from support.forces import crumpled, forces


def momentum(cloth):
    """Return m v of all nodes together (3,) [kg m/s]."""
    return (cloth.mesh.grid(cloth.model.mass)[..., None] * cloth.velocities).sum(axis=(0, 1))


@pytest.mark.parametrize('precision', PRECISIONS)
def test_the_load_is_what_the_momentum_lacks(precision):
    """
    The load in a step is weight + wind - change of momentum, and the same of moments.

    Weight and wind are those of a sheet without springs, dashpots and bending.
    """
    wind, air, step = (9.0, 3.0, -1.0), Air(), 1e-4
    material = Material(bend_stiffness=0.1, damping=0.3)
    cloth = Cloth(5, 7, 1.1, 0.9, material=material, air=air, precision=precision)
    positions, velocities = crumpled(Mesh(5, 7, 1.1, 0.9))
    cloth.place(positions + np.array(cloth.hoist_top), velocities)
    state = State(cloth.mesh, cloth.hoist_top)
    state.place(cloth.positions, cloth.velocities)
    found = load_in_step(cloth.model, state, Forcing(wind, cloth.gravity, air), step)
    outside = forces(Model(cloth.mesh, Material(stiffness=0.0, shear_stiffness=0.0,
                                                bend_stiffness=0.0, damping=0.0)),
                     cloth.positions - cloth.hoist_top, cloth.velocities, wind, cloth.gravity, air,
                     step)
    arm, moved = cloth.positions - cloth.hoist_top, cloth.velocities
    assert cloth.advance(step, wind).granted == 1
    mass = cloth.mesh.grid(cloth.model.mass)[..., None]
    gained = mass * (cloth.velocities - moved) / step
    lacks = outside - gained  # at the arms before the step, in which the forces are taken
    tolerance = {'float64': 1e-9, 'float32': 3e-3}[precision] * np.abs(gained).sum()
    np.testing.assert_allclose(found.force, lacks.sum(axis=(0, 1)), atol=tolerance)
    np.testing.assert_allclose(found.moment, np.cross(arm, lacks).sum(axis=(0, 1)),
                               atol=tolerance)


def test_over_a_frame_the_mean_load_is_what_the_momentum_lacks():
    """Without air: the mean of momentary loads, step by step, is weight less mean change."""
    cloth, dt, loads = Cloth(5, 7, air=VACUUM, stretch_limit=1e6), 1e-4, []
    before = momentum(cloth)
    for _ in range(300):
        loads.append(pole_load(cloth).force)
        cloth.advance(dt)
    change = (momentum(cloth) - before) / (len(loads) * dt)
    np.testing.assert_allclose(np.mean(loads, axis=0), [0.0, 0.0, -weight(cloth)] - change,
                               atol=1e-6 * weight(cloth))


def test_a_flag_that_hangs_weighs_on_its_pole():
    """At rest the load is the weight, and its moment that of the weight at the flag's centre."""
    cloth = Cloth(5, 7, 0.6, 0.4, material=Material(node_damping=5.0), start_noise=0.01)
    for _ in range(600):
        cloth.advance(1 / 30)
    found, own = pole_load(cloth), weight(cloth)
    assert own == pytest.approx(0.2 * 0.6 * 0.4 * 9.81)
    np.testing.assert_allclose(found.force, [0.0, 0.0, -own], atol=1e-3 * own)
    mass = cloth.mesh.grid(cloth.model.mass)
    centre = np.average((cloth.positions - cloth.hoist_top).reshape(-1, 3), axis=0,
                        weights=mass.ravel())
    np.testing.assert_allclose(found.moment, np.cross(centre, [0.0, 0.0, -own]), atol=1e-3 * own)
    assert found.lift(own) == pytest.approx(0.0, abs=1e-3 * own)


def test_drag_is_the_part_along_the_wind():
    cloth, wind = Cloth(5, 7), (3.0, 4.0, 0.0)
    for _ in range(10):
        cloth.advance(1 / 30, wind)
    found = pole_load(cloth, wind)
    assert found.drag(wind) == pytest.approx(0.6 * found.force[0] + 0.8 * found.force[1])
    assert found.drag((0.0, 0.0, 0.0)) == 0.0


def test_a_cloth_that_flies_free_has_no_load():
    with pytest.raises(ValueError, match='not pinned'):
        pole_load(Cloth(5, 7, pinned=False))
