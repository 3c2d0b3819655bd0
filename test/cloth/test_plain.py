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

"""The kernels against the page for learners, step by step."""
from flag_sim.cloth import Cloth, Material, Stepping
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.plain import take_step
import numpy as np
import pytest
from support.forces import crumpled

WIND = (7.0, 4.0, -1.0)


@pytest.mark.parametrize('material', [
    Material(), Material(bend_stiffness=0.0, damping=0.0), Material(node_damping=3.0)],
    ids=['all', 'elastic alone', 'node damping'])
@pytest.mark.parametrize('rows, columns', [(2, 2), (5, 7)])
def test_some_steps_of_a_crumpled_cloth(material, rows, columns):
    cloth = Cloth(rows, columns, material=material, stepping=Stepping(substeps=20),
                  stretch_limit=1e6)
    positions, velocities = crumpled(cloth.mesh)
    cloth.place(positions, velocities)
    velocities[:, 0] = 0.0  # the hoist
    plan = cloth.advance(0.004, WIND)
    assert plan.demanded <= plan.granted == 20  # so that nothing is softened
    forcing = Forcing(WIND, cloth.gravity, cloth.air)
    for _ in range(plan.granted):
        positions, velocities = take_step(positions, velocities, cloth.model, forcing,
                                          0.004 / plan.granted)
    # The same sums in another order: each step rounds accelerations of 1e5 m/s2 otherwise, by
    # 1e-11 or so, which comes to 1e-13 m/s in 20 steps of 0.2 ms. Allowed are ten times as much.
    np.testing.assert_allclose(cloth.velocities, velocities, rtol=0.0, atol=5e-12)
    np.testing.assert_allclose(cloth.positions, positions, rtol=0.0, atol=2e-14)
