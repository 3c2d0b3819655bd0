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

"""The longest step that is stable, measured by bisection, beside the bound of theory."""
import math

from flag_sim.cloth import Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import VACUUM
from flag_sim.study.measures import stability_trial as trial

PRECISION = 1.005  # of a measured limit, as a factor
GROWN = 30.0  # times its first noise that a wave must grow by, where nothing else moves the cloth

STILL = Forcing((0.0, 0.0, 0.0), 0.0, VACUUM)  # nothing acts from outside: the springs alone
FORCINGS = {
    'springs alone, first growth': STILL,
    'springs alone': STILL,
    'wind 6 m/s': Forcing(trial.wind_of(6.0)),
    'wind 40 m/s': Forcing(trial.wind_of(40.0)),
}
MATERIALS = {
    'undamped': trial.sheet(Material.stiffness, damping=0.0),
    'default': trial.sheet(Material.stiffness),
    'critically damped': trial.sheet(Material.stiffness, damping=1.0),
    'overdamped': trial.sheet(Material.stiffness, damping=100.0),
}


def measured(material, solver, forcing):
    """
    Return the bound and the longest step found stable [s], of one of MATERIALS and of FORCINGS.

    The latter is zero where even a thousandth of the bound diverges, and infinite where a
    thousand times it does not (where there is no bound: a hundred seconds).
    """
    sheet, acting = MATERIALS[material], FORCINGS[forcing]
    far = GROWN * trial.NOISE * trial.MESH.dx if 'growth' in forcing else None
    bound = trial.largest_step(solver, sheet, acting.air)
    low, high = (1e-3 * bound, 1e3 * bound) if math.isfinite(bound) else (1e-6, 100.0)

    def stable(dt):
        return trial.solver_alone(solver, sheet, acting, dt, far) == trial.STABLE

    if not stable(low):
        low = 0.0
    elif stable(high):
        low = math.inf
    else:
        while high > PRECISION * low:
            middle = math.sqrt(low * high)
            low, high = (middle, high) if stable(middle) else (low, middle)
    return {'bound_s': bound, 'limit_s': low}
