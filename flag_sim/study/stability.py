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

A map is a field of trials, from the smallest to the largest value that the dials take. It is
measured line by line, first coarse for every method, then finer, each time anew.
"""
import math
import time
from typing import NamedTuple

from flag_sim.cloth import Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import Air, VACUUM
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stability import Stepping
from flag_sim.study import breaking, maps, report
from flag_sim.study.settings import WEATHER
from flag_sim.study.shot import LEAST_HZ, MAX_GAP, MOST_HZ

NAME = 'stability'
SHARE = 1.0

LEVELS = 4
"""Of refinement; a level has FIRST * 2^level + 1 values along each axis, and zero."""
FIRST = 6
WIND = WEATHER['speed']
"""Of the maps without an axis for it [m/s]."""
RAW_STEP = 1e-3
"""Of the raw map of wind against stiffness [s]."""
FRAME = 1.0 / WEATHER['rate']
"""Of the same map through Cloth [s]."""

DEFAULT = (Material.stiffness, Material.area_density)
LIMPEST, STIFFEST = (1e-3, 1e6), (1e9, 1e-6)
"""(stiffness [N/m], area density [kg/m2]): by default, and as far as the dials go from there."""


class Axis(NamedTuple):
    """An axis of a map: its label with unit, its range, and whether zero is on it too."""

    label: str
    low: float
    high: float
    has_zero: bool = False

    def values(self, level):
        """Return the axis' values at a level, evenly spaced by their logarithm; zero first."""
        count = FIRST * 2**level
        ratio = self.high / self.low
        values = [self.low * ratio**(i / count) for i in range(count + 1)]
        return [0.0] * self.has_zero + values


def light_and_stiff(ratio):
    """
    Return a Material of stiffness over area density [m2/s2].

    Both change, evenly by their logarithms, from the default to the limpest and heaviest, or to
    the stiffest and lightest that the dials allow.
    """
    if ratio == 0.0:
        return breaking.sheet(0.0)
    default = DEFAULT[0] / DEFAULT[1]
    end = STIFFEST if ratio >= default else LIMPEST
    part = math.log(ratio / default) / math.log(end[0] / end[1] / default)
    return breaking.sheet(*(begin * (to / begin)**part for begin, to in zip(DEFAULT, end)))


class Map(NamedTuple):
    """
    A field of trials; of(x, y) gives a trial's (material, wind speed [m/s], step or frame [s]).

    is_raw: the method alone, or through Cloth. along_y: whether y is the step, so that the bound
    is a y for each x; otherwise it is an x, the same for all y.
    """

    name: str
    title: str
    is_raw: bool
    x: Axis
    y: Axis
    of: object
    along_y: bool = True


RATIO = Axis('stiffness / area density [m²/s²]', 1e-9, 1e15, True)
STIFFNESS = Axis('stiffness [N/m]', 1e-3, 1e9, True)
DAMPING = Axis('damping ratio [-]', 1e-3, 1e6, True)
SPEED = Axis('wind [m/s]', 0.1, 200.0, True)
STEP = Axis('step [s]', 1e-9, 100.0)
FRAME_TIME = Axis('frame time [s]', 1.0 / MOST_HZ, 1.0 / LEAST_HZ)


def _by_ratio(x, y):
    return light_and_stiff(x), WIND, y


def _by_damping(x, y):
    return breaking.sheet(*DEFAULT, damping=x), WIND, y


MAPS = (
    Map('steps', 'each method alone, in steps of a fixed length', True, RATIO, STEP, _by_ratio),
    Map('frames', 'what a user gets: frames divided into steps', False, RATIO, FRAME_TIME,
        _by_ratio),
    Map('damping-steps', 'each method alone, damped', True, DAMPING, STEP, _by_damping),
    Map('damping-frames', 'what a user gets of damped cloth', False, DAMPING, FRAME_TIME,
        _by_damping),
    Map('wind-steps', f'each method alone, in steps of {1e3 * RAW_STEP:g} ms', True, STIFFNESS,
        SPEED, lambda x, y: (breaking.sheet(x), y, RAW_STEP), False),
    Map('wind-frames', 'what a user gets in frames of 1/30 s', False, STIFFNESS, SPEED,
        lambda x, y: (breaking.sheet(x), y, FRAME), False),
)
BY_NAME = {one.name: one for one in MAPS}


def run(store, budget):
    """Measure line after line, the coarse maps of all methods first."""
    mesh = breaking.small_mesh()
    for level in range(LEVELS):
        for chart in MAPS:
            for solver in SOLVERS:
                if not _measure(store, budget, mesh, chart, solver, level):
                    return
                budget.say(f'map {chart.name} of {solver}, level {level + 1} of {LEVELS}')


def _measure(store, budget, mesh, chart, solver, level):
    """Add the lines of a map that are missing; return whether it is whole."""
    took = 0.0
    for number, y in enumerate(chart.y.values(level)):
        key = f'{chart.name}/{solver}/{level}/{number}'
        if store.has(NAME, key):
            continue
        if not budget.allows(took):
            return False
        begin = time.perf_counter()
        cells = ''.join(maps.LETTERS[outcome(chart, solver, x, y, mesh)]
                        for x in chart.x.values(level))
        store.add(NAME, {'key': key, 'map': chart.name, 'solver': solver, 'level': level, 'y': y,
                         'cells': cells})
        took = time.perf_counter() - begin
    return True


def outcome(chart, solver, x, y, mesh):
    """Return what becomes of the trial in one place of a map."""
    material, speed, dt = chart.of(x, y)
    if chart.is_raw:
        return breaking.raw(solver, material, Forcing(breaking.blowing(speed)), dt, mesh)
    return breaking.through_cloth(solver, material, breaking.blowing(speed), dt)


def bound(chart, solver, x, y, mesh):
    """
    Return how long the step or the frame may be in theory, over what it is in this place.

    A frame may be as long as the steps that Cloth grants, each at step_safety of the largest.
    """
    material, speed, dt = chart.of(x, y)
    largest = breaking.largest_step(solver, material, mesh, Air() if speed > 0.0 else VACUUM)
    stepping = Stepping()
    granted = 1.0 if chart.is_raw else stepping.substeps_limit * stepping.step_safety
    return granted * largest / dt


def finest(rows):
    """Return {(map, solver): [row of each y]} of the finest level whose lines are all there."""
    found = {}
    for row in rows:
        found.setdefault((row['map'], row['solver'], row['level']), []).append(row)
    whole = {}
    for (name, solver, level), lines in found.items():
        before = whole.get((name, solver))
        if len(lines) == len(BY_NAME[name].y.values(level)) and (
                before is None or before[0]['level'] < level):
            whole[name, solver] = sorted(lines, key=lambda row: row['y'])
    return whole


def plots(rows, folder):
    """Draw each map, one panel a method."""
    whole = finest(rows)
    mesh = breaking.small_mesh()
    drawn = []
    for chart in MAPS:
        panels = {solver: lines for (name, solver), lines in whole.items() if name == chart.name}
        if panels:
            file = f'stability-{chart.name}.png'
            maps.draw(folder / file, chart, panels,
                      lambda solver, x, y, chart=chart: bound(chart, solver, x, y, mesh),
                      MAX_GAP if chart.y is FRAME_TIME else None)
            drawn.append((file, SEEN[chart.name]))
    return drawn


SEEN = {
    'steps': 'Below the line symplectic, verlet and rk4 never diverge, and above it they soon do, '
             'over 24 powers of ten; xpbd and implicit never do. Seed breaks below its '
             'line, where cloth is limp or light, because its drag is explicit.',
    'frames': 'Above the line the cloth is softened (blue) and stays bounded; cloth too limp to '
              'carry itself hangs at stretch_limit (yellow). Only euler and seed lose frames '
              '(orange). The physics node takes no frame above the dotted line by default.',
    'damping-steps': 'From a damping ratio of about 0.1 the dashpots, not the springs, set the '
                     'step, and the measured border bends down with the line. Seed hardly bends: '
                     'its dashpots are too weak by the factor of the step.',
    'damping-frames': 'Overdamped cloth keeps its stiffness as long as giving up damping is '
                      'enough, and stays bounded up to the largest ratio that the dial takes. '
                      'Xpbd, always stable, may stretch to stretch_limit instead. Euler needs '
                      'damping: without it, it has no stable step.',
    'wind-steps': 'Wind moves no border of symplectic, verlet, rk4, xpbd and implicit, whose '
                  'drag is implicit: in 200 m/s it is where it is in still air. Seed, whose '
                  'drag is explicit, diverges in strong wind however limp the cloth.',
    'wind-frames': 'In frames of 1/30 s every stiffness is bounded in every wind; limp cloth '
                   'hangs at stretch_limit, stiff cloth beyond the line is softened. Only seed '
                   'loses frames.',
}
"""What there is to see in each map."""


def section(rows):
    """Return the text on the maps, with the count of what became of the trials."""
    whole = finest(rows)
    mesh = breaking.small_mesh()
    lines = []
    for chart in MAPS:
        for solver in SOLVERS:
            if (chart.name, solver) not in whole:
                continue
            cells, kept, broken = _count(chart, solver, whole[chart.name, solver], mesh)
            lines.append([chart.name, solver, sum(cells.values()),
                          *(cells[letter] for letter in maps.LETTERS.values()),
                          f'{broken} of {kept}'])
    head = ['map', 'method', 'trials', *maps.LETTERS, 'broken below the bound']
    return TEXT + '\n\n' + report.table(head, lines, 'll' + 'r' * (len(head) - 2))


def _count(chart, solver, lines, mesh):
    """Return {letter: trials}, the trials within the bound, and how many of those broke."""
    cells = dict.fromkeys(maps.LETTERS.values(), 0)
    kept = broken = 0
    for row in lines:
        for x, letter in zip(chart.x.values(row['level']), row['cells']):
            cells[letter] += 1
            if bound(chart, solver, x, row['y'], mesh) >= 1.0:
                kept += 1
                broken += letter in maps.BROKEN
    return cells, kept, broken


TEXT = f"""## Where each method breaks

A flag of {breaking.COLUMNS} x {breaking.ROWS} nodes is laid flat with a noise of
{breaking.NOISE:g} cells, in a wind of {WIND:g} m/s where the map has no axis for it. Axes go to
the ends of the dials' ranges. Along "stiffness / area density" both change, from the default to
the limpest and heaviest cloth and to the stiffest and lightest; shear and bending go with
stiffness.

"Steps": the method alone takes {breaking.STEPS} steps of a fixed length. It diverges where a node
is not finite or {breaking.FAR:g} times farther away than wind and free fall can carry it. What
diverges grows exponentially, so that another threshold hardly moves a border; growth as slow as
euler's undamped waves needs more steps to be seen.

"Frames": what a user gets of {breaking.FRAMES} frames or more, until they have {breaking.STEPS}
steps, with at most {Stepping().substeps_limit} steps a frame. Nothing diverges there: a frame
that did is refused (Diverged), and the cloth stays where it was. The physics node adds max_gap:
by default it simulates no frame longer than {MAX_GAP:g} s (dotted line).

The line is the bound that the planner uses: below it theory promises stability (for frames: with
{Stepping().substeps_limit} steps at a step_safety of {Stepping().step_safety:g}, so that nothing
need be lowered). The last column counts the places below it that diverged or were refused."""
