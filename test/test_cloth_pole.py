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

"""The pole is in the way in every step, not only where a frame ends."""
from flag_sim.cloth import Cloth, Stepping
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest


@pytest.mark.parametrize('solver', SOLVERS)
def test_a_frame_does_not_carry_cloth_through_the_pole(solver):
    """A scrap at 10 m/s would end the frame 1 m beyond the pole, outside of it too."""
    cloth = Cloth(2, 2, 0.1, 0.1, (-1.0, 0.02, 0.0), pinned=False, gravity=0.0, air=VACUUM,
                  solver=solver, stepping=Stepping(substeps=40), pole=(0.0, 0.0, 0.5))
    fling = np.zeros((2, 2, 3))
    fling[..., 0] = 10.0
    cloth.place(cloth.positions, fling)
    cloth.advance(0.2)
    assert np.all(cloth.positions[..., 0] < 0.0)
