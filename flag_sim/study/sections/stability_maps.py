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

"""
Maps of where each method breaks, and of what a user gets there.

A map is a field of trials over the values that people set. It is measured line by line, first
coarse for every method, then finer, each time anew.
"""
import collections
from collections.abc import Callable, Iterator
import itertools
import time
from typing import NamedTuple

from flag_sim.cloth import Air, Material, Stepping
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import VACUUM
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.study import stability_plots
from flag_sim.study.measures import stability_trial as trial, summary
from flag_sim.study.measures.settings import MAX_GAP, WIND_DEFAULTS
from flag_sim.study.report import table
from flag_sim.study.runner import Batch
from flag_sim.study.store import Store

PLACE, NAME, SHARE = 5, 'stability', 1.0

LEVELS = 4  # of refinement; a level has FIRST * 2^level + 1 values along each axis
FIRST = 6
WIND = WIND_DEFAULTS['speed']  # of the maps without an axis for it [m/s]
FRAME = 1.0 / WIND_DEFAULTS['rate']  # of the map of wind [s]


class Axis(NamedTuple):
    """An axis of a map: its label with unit, and its range."""

    label: str
    low: float
    high: float

    def values(self, level: int) -> list[float]:
        """Return the axis' values at a level, evenly spaced by their logarithm."""
        count = FIRST * 2**level
        return [self.low * (self.high / self.low)**(i / count) for i in range(count + 1)]


class Map(NamedTuple):
    """A field of trials, of the method alone (is_alone) or through Cloth."""

    name: str
    title: str
    is_alone: bool
    x: Axis
    y: Axis
    of: Callable  # (x, y) -> a trial's material, wind speed [m/s], step or frame [s]
    what_to_see: str

    def outcome(self, solver: str, x: float, y: float) -> trial.Outcome:
        """Return what becomes of the trial in one place."""
        material, speed, dt = self.of(x, y)
        wind = trial.wind_of(speed)
        if self.is_alone:
            return trial.solver_alone(solver, material, Forcing(wind), dt)
        return trial.through_cloth(solver, material, wind, dt)

    def bound(self, solver: str, x: float, y: float) -> float:
        """
        Return how long the step or the frame may be in theory, over what it is in this place.

        A frame may be as long as the steps that Cloth grants, each at step_safety of the largest.
        """
        material, speed, dt = self.of(x, y)
        largest = trial.largest_step(solver, material, Air() if speed > 0.0 else VACUUM)
        granted = 1.0 if self.is_alone else Stepping().substeps_limit * Stepping().step_safety
        return granted * largest / dt


STIFFNESS = Axis('stiffness [N/m]', 1e2, 1e5)
"""What people set: a limp sheet of rubber, and canvas."""
DAMPING = Axis('damping ratio [-]', 0.01, 10.0)
SPEED = Axis('wind [m/s]', 1.0, 50.0)
STEP = Axis('step [s]', 1e-5, 1e-1)
FRAME_TIME = Axis('frame time [s]', 1e-3, 1.0)


MAPS = (
    Map('steps', 'each method alone, in steps of a fixed length', True, STIFFNESS, STEP,
        lambda x, y: (trial.sheet(x), WIND, y),
        'Below the line symplectic, verlet and rk4 never diverge, and above it they soon do; '
        'implicit never does.'),
    Map('frames', 'what a user gets: frames divided into steps', False, STIFFNESS, FRAME_TIME,
        lambda x, y: (trial.sheet(x), WIND, y),
        'Above the line the cloth is softened (blue) and stays bounded. Only euler and seed may '
        'lose frames. The physics node takes no frame above the dotted line by default.'),
    Map('damping-frames', 'what a user gets of damped cloth', False, DAMPING, FRAME_TIME,
        lambda x, y: (trial.sheet(Material.stiffness, damping=x), WIND, y),
        'From a damping ratio of about 0.1 the dashpots, not the springs, set the step. '
        'Overdamped cloth keeps its stiffness as long as giving up damping is enough.'),
    Map('wind-frames', 'what a user gets in frames of 1/30 s', False, STIFFNESS, SPEED,
        lambda x, y: (trial.sheet(x), y, FRAME),
        'In frames of 1/30 s every stiffness is bounded in every wind; soft cloth may hang at '
        'stretch_limit.'),
)
BY_NAME = {one.name: one for one in MAPS}


def batches(store: Store) -> Iterator[Batch]:
    """Measure line after line, the coarse maps of all methods first."""
    del store
    for level, chart, solver in itertools.product(range(LEVELS), MAPS, SOLVERS):
        taken = 0.0
        for y in chart.y.values(level):
            begin = time.perf_counter()
            yield Batch(f'map {chart.name} of {solver}, level {level + 1} of {LEVELS}', [
                {'chart': chart.name, 'solver': solver, 'level': level, 'y': y}], _line,
                seconds=taken)
            taken = time.perf_counter() - begin


def _line(chart, solver, level, y):
    """Return the outcomes along x, a letter each."""
    one = BY_NAME[chart]
    return {'cells': ''.join(one.outcome(solver, x, y).letter for x in one.x.values(level))}


def finest(rows):
    """Return {map name: {solver: rows by y}} of the finest level whose lines are all there."""
    levels = summary.grouped(rows, 'chart', 'solver', 'level')
    found = {}
    for chart, solver, level in itertools.product(MAPS, SOLVERS, range(LEVELS)):
        lines = levels.get((chart.name, solver, level), [])
        if len(lines) == len(chart.y.values(level)):
            found.setdefault(chart.name, {})[solver] = sorted(lines, key=lambda row: row['y'])
    return found


def plots(store: Store) -> Iterator[tuple[str, str]]:
    """Draw each map, one panel a method."""
    for name, panels in finest(store.rows(NAME)).items():
        chart = BY_NAME[name]
        stability_plots.draw(store.folder / f'stability-{name}.png', chart, panels,
                             MAX_GAP if chart.y is FRAME_TIME else None)
        yield f'stability-{name}.png', chart.what_to_see


def text(store: Store) -> str:
    """Return the text on the maps, with the count of what became of the trials."""
    rows = store.rows(NAME)
    broken = {trial.REFUSED.letter, trial.DIVERGING.letter}
    lines, found = [], finest(rows)
    for name, panels in found.items():
        chart = BY_NAME[name]
        for solver, own in panels.items():
            cells = [(letter, chart.bound(solver, x, row['y']) >= 1.0) for row in own
                     for x, letter in zip(chart.x.values(row['level']), row['cells'])]
            within = [letter for letter, is_within in cells if is_within]
            counts = collections.Counter(letter for letter, _ in cells)
            lines.append([name, solver, len(cells),
                          *(counts[outcome.letter] for outcome in trial.OUTCOMES),
                          f'{sum(one in broken for one in within)} of {len(within)}'])
    if not lines:
        return ''
    missing = [f'{chart.name} of {", ".join(solvers)}' for chart in MAPS if (
        solvers := [solver for solver in SOLVERS if solver not in found.get(chart.name, {})])]
    return TEXT + '\n\n' + table(['map', 'method', 'trials', *(
        outcome.name for outcome in trial.OUTCOMES), 'broken below the bound'], lines) + (
        f'\n\nNot measured for lack of time (map of methods): {"; ".join(missing)}.'
        if missing else '')


TEXT = f"""## Where each method breaks

A flag of {trial.COLUMNS} x {trial.ROWS} nodes is laid flat with a noise of
{trial.NOISE:g} cells, in a wind of {WIND:g} m/s where the map has no axis for it. Axes have what
people set; shear and bending go with stiffness.

"Steps": the method alone takes {trial.STEPS} steps of a fixed length. It diverges where a node
is not finite or {trial.ESCAPE_FACTOR:g} times farther away than wind and free fall can carry it.
"Frames": what a user gets of {trial.FRAMES} frames or more, until they have {trial.STEPS}
steps, with at most {Stepping().substeps_limit} steps a frame. Nothing diverges there: a frame
that did is refused (Diverged), and the cloth stays where it was. The physics node simulates no
frame longer than max_gap, {MAX_GAP:g} s by default (dotted line).

The line is the bound that the planner uses: below it theory promises stability (for frames: with
{Stepping().substeps_limit} steps at a step_safety of {Stepping().step_safety:g}, so that nothing
need be lowered). The last column counts the places below it that diverged or were refused."""
