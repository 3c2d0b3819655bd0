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

"""How much longer than the bound of theory each method's longest stable step truly is."""
from collections.abc import Iterator
import itertools
import math

from flag_sim.cloth import Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.study.measures import stability_trial as trial
from flag_sim.study.measures.summary import Rows
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 8, 'limits', 0.2

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


def batches(store: Store) -> Iterator[Batch]:
    """Measure the limits of every method, material and forcing."""
    del store
    for material, solver, forcing in itertools.product(MATERIALS, SOLVERS, FORCINGS):
        yield Batch(f'limit of {solver}, {material}', [
            {'material': material, 'solver': solver, 'forcing': forcing}], measured)


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


def text(rows: Rows) -> str:
    """Return the text with the table of limits over bounds."""
    ratios = {(row['material'], row['forcing'], row['solver']): _ratio(row) for row in rows}
    lines = [[*place, *(ratios.get((*place, solver)) for solver in SOLVERS)]
             for place in itertools.product(MATERIALS, FORCINGS)
             if any((*place, solver) in ratios for solver in SOLVERS)]
    return TEXT + '\n\n' + table(['material', 'forcing', *SOLVERS], lines)


def _ratio(row):
    """Return limit over bound, or in words that it has no end."""
    if math.isinf(row['limit_s']):
        return 'none'
    return round(row['limit_s'] / row['bound_s'], 2) if row['limit_s'] else 'always'


TEXT = f"""## The measured limit over the bound

The longest stable step of the same trials, found by bisection to {100 * (PRECISION - 1):.1f} %,
over the bound that the planner uses: never below 1 where the bound is a promise. "First growth":
a noise of {trial.NOISE:g} cells grows {GROWN:g} times. "None": no step diverges; "always":
every one does.

Undamped springs alone show by how much the bound is too low for this mesh: it covers the waves of
an infinite grid, of which the stiffest cannot exist between the pins and edges of this small one.
For rk4 the bound also takes half a disc (2.6 of the 2.83 along the imaginary axis), and a growing
wave crumples the cloth, which makes it less stiff, until it grows no more. The reserve for drag
(symplectic 1.15 to 1.33, verlet 1.22 to 1.48, rk4 1.19) is not used in a light wind; and with
dashpots, springs and dashpots are each taken at their worst. Below 1 are euler without damping,
which no step makes stable, only slow to diverge, and seed in a storm, whose drag is explicit and
not in its bound. Far above are seed's dashpots, weaker by the factor of the step."""
