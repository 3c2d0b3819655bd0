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
One trial of a method: a small flag, some steps, and what became of it.

solver_alone tries the method itself, Solver.advance in steps of a fixed length; through_cloth
what a user gets, Cloth.advance, which divides frames into steps, softens, limits the stretch.
"""
import math
from typing import NamedTuple

from flag_sim.animation.wind_vector import wind_vector
from flag_sim.cloth import Air, Cloth, Diverged, Material
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stability import damping_bound, frequency_bound
from flag_sim.cloth.state import State
from flag_sim.declarations.factories import hang_of
from flag_sim.study.measures.settings import defaults, WIND_DEFAULTS
import numpy as np

ROWS, COLUMNS = 9, 13
"""Of the flag: what becomes unstable is the finest wave of a grid, which every grid has."""
HOIST_TOP, LENGTH, WIDTH = hang_of(defaults())
MESH = Mesh(ROWS, COLUMNS, LENGTH, WIDTH)
NOISE = 1e-3
"""Of the first positions, in parts of a cell: something for an unstable wave to grow from."""
STEPS = 500  # in which a method must diverge, or counts as stable
CHUNK = 50  # steps between two looks at the state
ESCAPE_FACTOR = 100.0  # times farther than wind and gravity can carry a free cloth: diverged
FRAMES = 2  # that a cloth is moved by at least, and on until it has taken STEPS steps


class Outcome(NamedTuple):
    """What can become of a trial: its name, its letter in the rows of a map, and in words."""

    name: str
    letter: str
    text: str


STABLE = Outcome('stable', 's', 'stable')
SOFTENED = Outcome('softened', 'f', 'bounded, stiffness or damping lowered')
LIMITED = Outcome('limited', 'l', 'bounded, held back at stretch_limit')
REFUSED = Outcome('refused', 'r', 'frame refused (Diverged), cloth stays as it was')
DIVERGING = Outcome('diverging', 'd', 'diverging')
OUTCOMES = (STABLE, SOFTENED, LIMITED, REFUSED, DIVERGING)


def wind_of(speed: float) -> tuple[float, float, float]:
    """Return the wind (3) [m/s] of a speed, in the direction of the default shot."""
    return tuple(wind_vector(speed, WIND_DEFAULTS['azimuth'], WIND_DEFAULTS['elevation']).tolist())


def sheet(stiffness: float, area_density: float = Material.area_density,
          damping: float = Material.damping) -> Material:
    """
    Return a Material of a stiffness [N/m] and a mass [kg/m2] that keeps its proportions.

    Shear and bending stiffness are to stiffness as they are by default.
    """
    default = Material()
    part = stiffness / default.stiffness
    return Material(area_density, stiffness, part * default.shear_stiffness,
                    part * default.bend_stiffness, damping)


def first_positions() -> np.ndarray:
    """Return the cloth laid flat, with noise, but for its pins: (rows, columns, 3) [m]."""
    rest = MESH.rest(HOIST_TOP)
    noise = np.random.default_rng(1).normal(size=rest.shape)
    return rest + NOISE * MESH.dx * noise * MESH.grid(MESH.free)[..., None]


def largest_step(solver: str, material: Material, air: Air, mesh: Mesh = MESH) -> float:
    """Return the step [s] that theory promises to be stable: the planner's, at step_safety 1."""
    model = Model(mesh, material)
    return SOLVERS[solver].largest_step(frequency_bound(model), damping_bound(model), air)


def solver_alone(solver: str, material: Material, forcing: Forcing, dt: float,
                 far: float | None = None) -> Outcome:
    """
    Return DIVERGING or STABLE for STEPS steps of dt [s] of a method, without planner or limits.

    Diverging: a node is not finite, or farther than `far` [m] from where it was. By default that
    is ESCAPE_FACTOR times what the flag's size, the wind and free fall together account for; where
    springs do not diverge nothing else can be so far, however soft they are.
    """
    method = SOLVERS[solver](Model(MESH, material))
    state, spare = State(MESH), State(MESH)
    state.place(first_positions())
    begin = state.data[:3].copy()
    size, wind = math.hypot(LENGTH, WIDTH), math.hypot(*forcing.wind)
    for done in range(CHUNK, STEPS + 1, CHUNK):
        if method.advance(state, spare, forcing, dt, CHUNK) is spare:
            state, spare = spare, state
        time = done * dt
        allowed = far or ESCAPE_FACTOR * (size + wind * time + 0.5 * forcing.gravity * time**2)
        # A NaN compares false, and so counts as far.
        if not np.abs(state.data[:3] - begin).max() <= allowed:
            return DIVERGING
    return STABLE


def through_cloth(solver: str, material: Material, wind: tuple, dt: float) -> Outcome:
    """Return the worst that some frames of dt [s] show: STABLE, LIMITED, SOFTENED or REFUSED."""
    cloth = Cloth(ROWS, COLUMNS, LENGTH, WIDTH, HOIST_TOP, material=material, solver=solver)
    cloth.place(first_positions())
    seen = {STABLE}
    frames = taken = 0
    while frames < FRAMES or taken < STEPS:
        try:
            steps = cloth.advance(dt, wind)
        except Diverged:
            return REFUSED
        frames += 1
        taken += steps.granted
        if min(steps.stiffness_factor, steps.damping_factor) < 1.0:
            seen.add(SOFTENED)
        if cloth.held:
            seen.add(LIMITED)
    return next(outcome for outcome in (SOFTENED, LIMITED, STABLE) if outcome in seen)
