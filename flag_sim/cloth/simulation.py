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

"""The cloth as its users meet it: parameters outside, a state inside, frame by frame."""
import copy
import functools

from flag_sim.cloth.constraints import constrain
from flag_sim.cloth.contact import Limits
from flag_sim.cloth.divergence import Diverged, validate
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.mesh import Grid, Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.normals import node_normals
from flag_sim.cloth.options import Options
from flag_sim.cloth.planned_solver import PlannedSolver
from flag_sim.cloth.pole import checked_pole, MAX_HOIST, relative_pole
from flag_sim.cloth.records import Vector
from flag_sim.cloth.resampling import carry_over
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stability import Plan
from flag_sim.cloth.start import bump
from flag_sim.cloth.state import State
from flag_sim.cloth.stepping import Stepping
from flag_sim.parallel.thread_pool import ThreadPool
from flag_sim.parameters import checks
from flag_sim.parameters.closed import closed
import numpy as np

MAX_WIND = 1e4
"""Greatest wind along an axis [m/s]: the strongest gusts in a wind of 200 m/s, and to spare."""
MAX_FRAME = 3600.0
"""Longest frame [s]."""


def _setting(name, check, doc):
    """Return a property that check(name, value) has to pass, and that does nothing else."""
    private = f'_{name}'
    return property(lambda self: getattr(self, private),
                    lambda self, value: setattr(self, private, check(name, value)), doc=doc)


@closed
class Cloth:
    """
    A flag that hangs from its hoist and moves in the wind.

    rows, columns: of its grid. length, width: at rest [m]. hoist_top: where its upper hoist corner
    is, (x, y, z) [m]. pinned: whether the hoist is fixed there, or all of the cloth is free.
    stretch_limit: no node of a pinned cloth ends a frame farther from the beginning of its row
    than 1 + stretch_limit times its distance at rest. pole: an upright cylinder (x, y, radius) [m]
    that no edge and no face of the cloth passes through, however thin it is; the hoist is on its
    surface or outside.
    precision: of the numbers inside, float64 or float32; what is given out is float64.
    start_noise, start_seed: the cloth starts flat but for a random bump of at most start_noise
    [m], which its weight or the wind needs to begin with; the same seed, the same bump.
    threads: how many compute the steps, 0 chooses by measuring the first frames; the result is the
    same to the bit. With implicit it is one.

    material, air, gravity, stepping, solver, stretch_limit, pole and precision may be changed
    between frames by assignment, and start_noise and start_seed for the next start; regrid keeps
    the motion too; hang and reset start anew.
    Everything raises ValueError for a value that it cannot take, and then leaves the cloth as it
    was; an attribute that it does not have is an AttributeError. Whatever is set, the state stays
    finite.
    """

    def __init__(self, rows: int = Grid.rows, columns: int = Grid.columns,
                 length: float = 2.25, width: float = 1.5, hoist_top: Vector = (0.05, 0.0, 8.9), *,
                 pinned: bool = True, material: Material | None = None, air: Air | None = None,
                 gravity: float = Options.gravity, stepping: Stepping | None = None,
                 solver: str = Options.solver, stretch_limit: float = Options.stretch_limit,
                 pole: Vector | None = None, precision: str = Grid.precision,
                 start_noise: float = Options.start_noise,
                 start_seed: int = Options.start_seed, threads: int = Options.threads):
        hoist_top = checks.vector('hoist_top', hoist_top, MAX_HOIST)
        self._material = checks.instance('material', _or_default(material, Material), Material)
        self.air = _or_default(air, Air)
        self.gravity = gravity
        self.stepping = _or_default(stepping, Stepping)
        self._pole, self._held = None, 0
        self.start_noise, self.start_seed = start_noise, start_seed
        self._pool = ThreadPool(Options.accepted('threads', threads))
        self._solver_name = checks.choice('solver', solver, SOLVERS)
        self._put_on(Mesh(rows, columns, length, width, pinned, precision), hoist_top)
        self.pole = pole
        self.reset()
        self._stretch_limit = None
        self.stretch_limit = stretch_limit

    air = _setting('air', functools.partial(checks.instance, kind=Air),
                   'The air that carries the wind.')
    stepping = _setting('stepping', functools.partial(checks.instance, kind=Stepping),
                        'How frames are divided into steps.')
    gravity = _setting('gravity', Options.accepted, 'Acceleration g along -z [m/s2].')
    start_noise = _setting('start_noise', Options.accepted,
                           'Greatest distance from flat at which the cloth starts [m].')
    start_seed = _setting('start_seed', Options.accepted,
                          'Which of all random bumps the cloth starts with.')

    def __copy__(self) -> 'Cloth':
        """Return a cloth of its own that goes on as this one would, as copy.deepcopy does."""
        return copy.deepcopy(self)

    @property
    def mesh(self) -> Mesh:
        """Return the grid; see regrid and hang."""
        return self._mesh

    @property
    def hoist_top(self) -> Vector:
        """Where the upper hoist corner is: (x, y, z) [m]."""
        return self._hoist_top

    @property
    def material(self) -> Material:
        """Return what the cloth is made of."""
        return self._material

    @material.setter
    def material(self, material: Material) -> None:
        checks.instance('material', material, Material)
        if material != self._material:
            self._remodel(self._mesh, material, self._solver_name)

    @property
    def model(self) -> Model:
        """Return the material on the mesh as it is simulated: softened, where it had to be."""
        return self._planned.solver.model

    @property
    def stretch_limit(self) -> float:
        """Greatest strain from the hoist to a node; a lower one counts at once."""
        return self._stretch_limit

    @stretch_limit.setter
    def stretch_limit(self, limit: float) -> None:
        limit = Options.accepted('stretch_limit', limit)
        if limit != self._stretch_limit:
            self._stretch_limit = limit
            self._constrain()

    @property
    def held(self) -> int:
        """Return how many nodes stretch_limit brought back in the last frame."""
        return self._held

    @property
    def pole(self) -> Vector | None:
        """Return the cylinder (x, y, radius) [m] that the cloth stays out of, or None."""
        return self._pole

    @pole.setter
    def pole(self, pole: Vector | None) -> None:
        self._pole = checked_pole(pole, self._hoist_top, self._mesh.pinned)

    @property
    def solver(self) -> str:
        """Return the method's name, one of SOLVERS."""
        return self._solver_name

    @solver.setter
    def solver(self, name: str) -> None:
        if checks.choice('solver', name, SOLVERS) != self._solver_name:
            self._remodel(self._mesh, self._material, name)

    @property
    def precision(self) -> str:
        """Return the precision of the numbers inside, float64 or float32."""
        return self._mesh.precision

    @precision.setter
    def precision(self, precision: str) -> None:
        if Grid.accepted('precision', precision) != self._mesh.precision:
            old, positions, velocities = self._mesh, self.positions, self.velocities
            self._put_on(Mesh(old.rows, old.columns, old.length, old.width, old.pinned, precision),
                         self._hoist_top)
            self.place(positions, velocities)

    @property
    def positions(self) -> np.ndarray:
        """Return a copy of the nodes' positions: (rows, columns, 3) float64 [m]."""
        return self._state.positions()

    @property
    def velocities(self) -> np.ndarray:
        """Return a copy of the nodes' velocities: (rows, columns, 3) float64 [m/s]."""
        return self._state.velocities()

    def normals(self) -> np.ndarray:
        """Return the nodes' unit normals: (rows, columns, 3)."""
        return node_normals(self.positions)

    def reset(self) -> None:
        """Lay the cloth flat along +x from the hoist, but for its bump, at rest."""
        positions = self._mesh.rest(self._hoist_top)
        positions[..., 1] += bump(self._mesh.rows, self._mesh.columns, self._start_noise,
                                  self._start_seed)
        self._state.place(positions)

    def place(self, positions: np.ndarray, velocities: np.ndarray | None = None) -> None:
        """Put all nodes, pins too, at positions, with velocities or at rest (see State.place)."""
        self._state.place(positions, velocities)

    def hang(self, hoist_top: Vector, length: float, width: float) -> None:
        """Change the flag's size [m] and where it hangs, (x, y, z) [m]; it starts at rest."""
        hoist_top = checks.vector('hoist_top', hoist_top, MAX_HOIST)
        old = self._mesh
        mesh = Mesh(old.rows, old.columns, length, width, old.pinned, old.precision)
        checked_pole(self._pole, hoist_top, mesh.pinned)
        self._put_on(mesh, hoist_top)
        self.reset()

    def regrid(self, rows: int, columns: int) -> None:
        """Change the grid while the motion goes on, with its strain and momentum (resampling)."""
        old = self._mesh
        mesh = Mesh(rows, columns, old.length, old.width, old.pinned, old.precision)
        positions, velocities = carry_over(
            Model(old, self._material), self.positions, self.velocities,
            Model(mesh, self._material), self._hoist_top)
        self._put_on(mesh, self._hoist_top)
        self.place(positions, velocities)
        self._constrain()

    def advance(self, dt: float, wind: Vector = (0.0, 0.0, 0.0)) -> Plan:
        """
        Move the cloth on by a frame of dt [s] in a steady wind (x, y, z) [m/s]; return its Plan.

        Raises Diverged if the frame went out of bounds: the cloth then still stands at its start.
        """
        dt = checks.finite('dt', dt, high=MAX_FRAME, above=0.0)
        wind = checks.vector('wind', wind, MAX_WIND)
        steps = self._planned.plan(dt, self.air, self.stepping)
        self._last_good[...] = self._state.data
        try:
            self._step(steps.granted, dt / steps.granted, wind)
            self._validate(steps.granted, dt / steps.granted)
        except BaseException:
            self._state.data[...] = self._last_good  # an interrupt: threads may be steps apart
            raise
        self._constrain()
        return steps

    def _step(self, count, step, wind):
        """Take count steps of step [s]."""
        pole = relative_pole(self._pole, self._hoist_top)
        forcing = Forcing(wind, self.gravity, self.air, pole, self._stretch_limit)
        with self._pool.frame(count):
            state = self._planned.solver.advance(self._state, self._spare, forcing, step, count,
                                                 self._pool)
        if state is not self._state:
            self._state, self._spare = self._spare, self._state

    def _validate(self, count, step):
        """Raise Diverged if the state is out of bounds after count steps of step [s]."""
        try:
            validate(self._state)
        except Diverged as broken:
            hint = self._planned.hint(self.solver, step, self.stepping.step_safety, self.air)
            raise Diverged(f'{broken} with solver {self.solver} in {count} steps of {step:.3g} s; '
                           f'the cloth is held where the frame began; {hint}') from None

    def _constrain(self):
        """Bring back what is in the pole or farther from the hoist than stretch_limit allows."""
        pole = relative_pole(self._pole, self._hoist_top)
        contact = self._planned.solver.contact
        constrain(self._state, self._spare, Limits.of(self._mesh, pole, self._stretch_limit),
                  contact)
        self._held = int(np.count_nonzero(contact.brought_back))

    def _put_on(self, mesh, hoist_top):
        """Take a mesh, with room for its state, the next one, and one to fall back on."""
        state, spare = State(mesh, hoist_top), State(mesh, hoist_top)
        last_good = state.data.copy()
        self._remodel(mesh, self._material, self._solver_name)
        self._hoist_top = hoist_top
        self._state, self._spare, self._last_good = state, spare, last_good
        self._pool.measure()

    def _remodel(self, mesh, material, solver_name):
        """Take a mesh, a material and a method, once their solver is made: all three or none."""
        self._planned = PlannedSolver(mesh, material, SOLVERS[solver_name])
        self._mesh, self._material, self._solver_name = mesh, material, solver_name


def _or_default(value, kind):
    """Return value or, for None, what the class makes by default."""
    return kind() if value is None else value
