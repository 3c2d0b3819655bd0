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

"""This package's own cloth, through its public call."""
from flag_sim.cloth.simulation import Cloth
from flag_sim.cloth.stepping import Stepping

from peers_cloth.case import HOIST_TOP, LENGTH, WIDTH


class Peer:
    """Cloth.advance: a frame of as many steps as asked for, with all that comes with a frame."""

    def __init__(self, case, **options):
        self.precision = options.get('precision', 'float64')
        self._case = case
        self._cloth = Cloth(case.rows, case.columns, LENGTH, WIDTH, HOIST_TOP,
                            material=case.material, **options)

    def run(self, steps):
        self._cloth.stepping = Stepping(substeps=steps, substeps_limit=steps)
        plan = self._cloth.advance(steps * self._case.dt, self._case.wind)
        assert plan.granted == steps and plan.stiffness_factor == 1.0, plan

    def state(self):
        return self._cloth.positions, self._cloth.velocities
