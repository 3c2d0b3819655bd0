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

from flag_sim.cloth.contact import Limits
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.mesh import Grid, Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.normals import node_normals
from flag_sim.cloth.options import Options
from flag_sim.cloth.planned_solver import PlannedSolver
from flag_sim.cloth.pole import checked_pole, MAX_HOIST, relative_pole
from flag_sim.cloth.pole_frame import checked_pose, PoleFrame
from flag_sim.cloth.records import Vector
from flag_sim.cloth.resampling import carry_over
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stability import Plan
from flag_sim.cloth.start import bump
from flag_sim.cloth.states import States
from flag_sim.cloth.stepping import Stepping
from flag_sim.parallel.thread_pool import ThreadPool
from flag_sim.parameters import checks
from flag_sim.parameters.closed import closed
from flag_sim.parameters.properties import setting, view
import numpy as np

MAX_WIND = 1e4
"""Greatest wind along an axis [m/s]: the strongest gusts in a wind of 200 m/s, and to spare."""
MAX_FRAME = 3600.0
"""Longest frame [s]."""


@closed
class Cloth:
    """
    A flag that hangs from its hoist and moves in the wind.

    rows, columns: of its grid. length, width: at rest [m]. hoist_top: where its upper hoist corner
    is, (x, y, z) [m]. pinned: whether the hoist is fixed there, or all of the cloth is free.
    stretch_limit: no node of a pinned cloth ends a frame farther from the beginning of its row
    than 1 + stretch_limit times its distance at rest. pole: an upright cylinder (x, y, radius) [m]
    that no edge and no face of the cloth passes through, however thin it is; the hoist is on its
    surface or outside. Both are told of a pole upright at the world's origin; pose moves it.
    precision: of the numbers inside, float64 or float32; what is given out is float64.
    start_noise, start_seed: the cloth starts flat but for a random bump of at most start_noise
    [m], which its weight or the wind needs to begin with; the same seed, the same bump.
    threads: how many compute the steps, 0 chooses by measuring the first frames; the result is the
    same to the bit. With implicit it is one.

    material, air, gravity, stepping, solver, stretch_limit, pole, pose and precision may be
    changed between frames by assignment, and start_noise and start_seed for the next start;
    regrid keeps the motion too; hang and reset start anew.
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
        self._solver_name = checks.choice('solver', solver, SOLVERS)
        self.air = _or_default(air, Air)
        self.gravity = gravity
        self.stepping = _or_default(stepping, Stepping)
        self._pole, self._held = None, 0
        self._frame, self._is_carried = PoleFrame(), False
        self.start_noise, self.start_seed = start_noise, start_seed
        self._pool = ThreadPool(Options.accepted('threads', threads))
        self._put_on(Mesh(rows, columns, length, width, pinned, precision), hoist_top)
        self.pole = pole
        self.reset()
        self._stretch_limit = None
        self.stretch_limit = stretch_limit

    mesh = view('mesh', 'The grid; see regrid and hang.')
    hoist_top = view('hoist_top', 'Where the upper hoist corner is: (x, y, z) [m].')
    held = view('held', 'How many nodes stretch_limit brought back in the last frame.')
    is_carried = view('is_carried', 'Whether the pole was too fast to follow; see advance.')
    stepping = setting('stepping', functools.partial(checks.instance, kind=Stepping),
                       'How frames are divided into steps.')
    gravity = setting('gravity', Options.accepted, 'Acceleration g along -z [m/s2].')
    start_noise = setting('start_noise', Options.accepted,
                          'Greatest distance from flat at which the cloth starts [m].')
    start_seed = setting('start_seed', Options.accepted,
                         'Which of all random bumps the cloth starts with.')

    def __copy__(self) -> 'Cloth':
        """Return a cloth of its own that goes on as this one would, as copy.deepcopy does."""
        return copy.deepcopy(self)

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
    def air(self) -> Air:
        """Return the air that carries the wind."""
        return self._air

    @air.setter
    def air(self, air: Air) -> None:
        checks.instance('air', air, Air)
        SOLVERS[self._solver_name].require(air)
        self._air = air

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
    def pole(self) -> Vector | None:
        """Return the cylinder (x, y, radius) [m] that the cloth stays out of, or None."""
        return self._pole

    @pole.setter
    def pole(self, pole: Vector | None) -> None:
        self._pole = checked_pole(pole, self._hoist_top, self._mesh.pinned)

    @property
    def pose(self) -> np.ndarray:
        """Where the pole is, a turn and a shift (4, 4); set, it is there at once with its flag."""
        return self._frame.pose.copy()

    @pose.setter
    def pose(self, pose: np.ndarray) -> None:
        self._frame = PoleFrame(checked_pose(pose))

    @property
    def solver(self) -> str:
        """Return the method's name, one of SOLVERS."""
        return self._solver_name

    @solver.setter
    def solver(self, name: str) -> None:
        if checks.choice('solver', name, SOLVERS) != self._solver_name:
            SOLVERS[name].require(self._air)
            self._remodel(self._mesh, self._material, name)

    @property
    def precision(self) -> str:
        """Return the precision of the numbers inside, float64 or float32."""
        return self._mesh.precision

    @precision.setter
    def precision(self, precision: str) -> None:
        if Grid.accepted('precision', precision) != self._mesh.precision:
            old, state = self._mesh, self._states.now
            self._put_on(Mesh(old.rows, old.columns, old.length, old.width, old.pinned, precision),
                         self._hoist_top)
            self._states.now.place(state.positions(), state.velocities())

    @property
    def positions(self) -> np.ndarray:
        """Return a copy of the nodes' positions: (rows, columns, 3) float64 [m]."""
        return self._frame.to_world(self._states.now.positions())

    @property
    def velocities(self) -> np.ndarray:
        """Return a copy of the nodes' velocities: (rows, columns, 3) float64 [m/s]."""
        own = self._states.now.positions()
        return self._frame.velocities_to_world(own, self._states.now.velocities())

    def normals(self) -> np.ndarray:
        """Return the nodes' unit normals: (rows, columns, 3)."""
        return node_normals(self.positions)

    def reset(self) -> None:
        """Lay the cloth flat from the hoist, but for its bump, at rest where the pole is."""
        self.pose = self._frame.pose
        positions = self._mesh.rest(self._hoist_top)
        positions[..., 1] += bump(self._mesh.rows, self._mesh.columns, self._start_noise,
                                  self._start_seed)
        self._states.now.place(positions)

    def place(self, positions: np.ndarray, velocities: np.ndarray | None = None) -> None:
        """Put all nodes, pins too, at positions, with velocities or at rest (see State.place)."""
        self.pose = self._frame.pose
        self._states.now.place(*self._frame.own(positions, velocities, self._mesh))

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
        old, state = self._mesh, self._states.now
        mesh = Mesh(rows, columns, old.length, old.width, old.pinned, old.precision)
        positions, velocities = carry_over(
            Model(old, self._material), state.positions(), state.velocities(),
            Model(mesh, self._material), self._hoist_top)
        self._put_on(mesh, self._hoist_top)
        self._states.now.place(positions, velocities)
        self._constrain()

    def advance(self, dt: float, wind: Vector = (0.0, 0.0, 0.0),
                pose: np.ndarray | None = None) -> Plan:
        """
        Move the cloth on by a frame of dt [s] in a steady wind (x, y, z) [m/s]; return its Plan.

        pose: where the pole is at the end of the frame: its base goes there straight and it turns
        about one axis, both at constant rates. None: it stands still. Where that is faster than
        FASTEST_HOIST or FASTEST_SPIN it is there at once, and the cloth is carried along.
        Raises Diverged if the frame went out of bounds: the cloth then still stands at its start.
        """
        dt = checks.finite('dt', dt, high=MAX_FRAME, above=0.0)
        wind = checks.vector('wind', wind, MAX_WIND)
        end = self._frame.pose if pose is None else checked_pose(pose)
        frame, is_carried = self._frame.way_to(end, dt, self._mesh, self._hoist_top)
        steps = self._planned.plan(dt, self.air, self.stepping)
        step = dt / steps.granted
        pole = relative_pole(self._pole, self._hoist_top)
        forcing = Forcing(wind, self.gravity, self.air, pole, self._stretch_limit,
                          lever=self._hoist_top)
        self._states.keep()
        try:
            if not is_carried:
                self._frame.hand_over(frame, self._states.now)
            self._states.take(self._planned.solver, forcing, frame, step, steps.granted,
                              self._pool)
            self._planned.validate(self._states.now, self._solver_name, steps.granted, step,
                                   self.stepping.step_safety, self._air)
        except BaseException:
            self._states.go_back()
            raise
        self._frame, self._is_carried = frame._replace(pose=end), is_carried
        self._constrain()
        return steps

    def _constrain(self):
        """Bring back what is in the pole or farther from the hoist than stretch_limit allows."""
        pole = relative_pole(self._pole, self._hoist_top)
        self._held = self._states.constrain(
            self._planned.solver, Limits.of(self._mesh, pole, self._stretch_limit))

    def _put_on(self, mesh, hoist_top):
        """Take a mesh, with room for its state, the next one, and one to fall back on."""
        states = States(mesh, hoist_top)
        self._remodel(mesh, self._material, self._solver_name)
        self._hoist_top, self._states = hoist_top, states
        self._pool.measure()

    def _remodel(self, mesh, material, solver_name):
        """Take a mesh, a material and a method, once their solver is made: all three or none."""
        self._planned = PlannedSolver(mesh, material, SOLVERS[solver_name])
        self._mesh, self._material, self._solver_name = mesh, material, solver_name


def _or_default(value, kind):
    """Return value or, for None, what the class makes by default."""
    return kind() if value is None else value
