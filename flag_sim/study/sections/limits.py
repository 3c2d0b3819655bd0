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
import functools
import math

from flag_sim.cloth import Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.study.measures import stability_trial as trial
from flag_sim.study.report import table
from flag_sim.study.runner import Batch

PLACE, NAME, SHARE = 8, 'limits', 0.2

PRECISION = 1.005  # of a measured limit, as a factor
GROWN = 30.0  # times its first noise that a wave must grow by, where nothing else moves the cloth

STILL = Forcing((0.0, 0.0, 0.0), 0.0, VACUUM)  # nothing acts from outside: the springs alone
FORCINGS = {
    'springs alone, first growth': STILL,
    'springs alone': STILL,
    'wind 6 m/s': Forcing(trial.blowing(6.0)),
    'wind 40 m/s': Forcing(trial.blowing(40.0)),
}
MATERIALS = {
    'undamped': trial.sheet(Material.stiffness, damping=0.0),
    'default': trial.sheet(Material.stiffness),
    'critically damped': trial.sheet(Material.stiffness, damping=1.0),
    'overdamped': trial.sheet(Material.stiffness, damping=100.0),
}


def batches(store):
    """Measure the limits of every method, material and forcing."""
    del store
    for material in MATERIALS:
        for solver in SOLVERS:
            for forcing in FORCINGS:
                yield Batch(f'limit of {solver}, {material}', {
                    f'{material}/{solver}/{forcing}': functools.partial(
                        _row, material, solver, forcing)})


def _row(material, solver, forcing):
    bound, limit = measured(solver, MATERIALS[material], forcing)
    return {'material': material, 'solver': solver, 'forcing': forcing, 'bound_s': bound,
            'limit_s': limit}


def measured(solver, material, name):
    """
    Return the bound and the longest step found stable [s], under a forcing of FORCINGS.

    The latter is zero where even a thousandth of the bound diverges, and infinite where a
    thousand times it does not (where there is no bound: a hundred seconds).
    """
    forcing = FORCINGS[name]
    far = GROWN * trial.NOISE * trial.MESH.dx if 'growth' in name else None
    bound = trial.largest_step(solver, material, forcing.air)
    low, high = (1e-3 * bound, 1e3 * bound) if math.isfinite(bound) else (1e-6, 100.0)

    def stable(dt):
        return trial.raw(solver, material, forcing, dt, far) == trial.STABLE

    if not stable(low):
        return bound, 0.0
    if stable(high):
        return bound, math.inf
    while high > PRECISION * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return bound, low


def text(rows: list[dict]) -> str:
    """Return the text with the table of limits over bounds."""
    by_key = {row['key']: row for row in rows}
    lines = []
    for material in MATERIALS:
        for forcing in FORCINGS:
            found = [by_key.get(f'{material}/{solver}/{forcing}') for solver in SOLVERS]
            if any(found):
                lines.append([material, forcing, *(_ratio(row) for row in found)])
    return TEXT + '\n\n' + table(['material', 'forcing', *SOLVERS], lines,
                                 'll' + 'r' * len(SOLVERS))


def _ratio(row):
    """Return limit over bound as text."""
    if row is None:
        return None
    if math.isinf(row['limit_s']):
        return 'none'
    return 'always' if row['limit_s'] == 0.0 else f'{row["limit_s"] / row["bound_s"]:.2f}'


TEXT = f"""## The measured limit over the bound

The longest stable step of the same trials, found by bisection to {100 * (PRECISION - 1):.1f} %,
over the bound that the planner uses: never below 1 where the bound is a promise. "First growth":
a noise of {trial.NOISE:g} cells grows {GROWN:g} times. "None": no step diverges; "always":
every one does.

Undamped springs alone show what the bound gives away to the mesh: it counts the waves of an
endless grid, and the pins and hems of this small one shut the stiffest out. On top of that come
rk4's half disc (2.6 of the 2.83 along the imaginary axis) and its saturation (a wave that grows
crumples the cloth, which makes it less stiff, and grows no more); then the reserve for drag
(symplectic 1.15 to 1.33, verlet 1.22 to 1.48, rk4 1.19), which a light wind leaves unused; and
with dashpots that springs and dashpots are each taken at their worst. Below 1 are euler without
damping, which no step makes stable, only slow to diverge, and seed in a storm, whose drag is
explicit and not in its bound. Far above are seed's dashpots, weaker by the factor of the step."""
