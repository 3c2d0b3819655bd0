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

"""The cloth as its users meet it: parameters on the outside, a state inside, frame by frame."""
import functools
import math

from flag_sim.cloth.collision import Limits
from flag_sim.cloth.constraints import constrain
from flag_sim.cloth.divergence import advice, broken_bound, Diverged
from flag_sim.cloth.forces import Forcing, NO_POLE
from flag_sim.cloth.material import Air, Material
from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.normals import node_normals
from flag_sim.cloth.resampling import carry_over
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stability import damping_bound, plan, SHORTEST_STEP, Stepping
from flag_sim.cloth.start import bump
from flag_sim.cloth.state import State
from flag_sim.parallel.thread_pool import ThreadPool
from flag_sim.parameters import checks
from flag_sim.parameters.closed import closed
import numpy as np

MAX_HOIST = 1e6
"""Greatest coordinate of the hoist [m]."""
MAX_WIND = 1e4
"""Greatest wind along an axis [m/s]: the strongest gusts in a wind of 200 m/s, and to spare."""
MAX_FRAME = 3600.0
"""Longest frame [s]."""
MAX_NOISE = 0.1
"""Greatest bump that a flat cloth starts with [m]."""
MAX_THREADS = 64
"""Beyond, their bands of an ordinary grid are shorter than a row."""


@closed
class Cloth:
    """
    A flag that hangs from its hoist and moves in the wind.

    rows, columns: of its grid. length, width: at rest [m]. hoist_top: where its upper hoist corner
    is held, (x, y, z) [m]. pinned: whether the hoist is held at all.
    stretch_limit: no node of a pinned cloth ends a frame farther from the beginning of its row
    than 1 + stretch_limit times its distance at rest; held: how many nodes that held back in the
    last frame. pole: an upright cylinder (x, y, radius) [m] that no edge and no face of the cloth
    passes through, however thin it is; the hoist is on its surface or outside.
    precision: of the numbers inside, float64 or float32; what is given out is float64.
    start_noise, start_seed: the cloth starts flat but for a random bump of at most start_noise
    [m], which its weight or the wind needs to begin with; the same seed, the same bump.
    threads: how many share the steps, 0 chooses by measuring the first frames; the result is the
    same to the bit. With xpbd, whose steps go from line to line, and implicit it is one.

    material, air, gravity, stepping, solver, stretch_limit, pole and precision may be changed
    between frames by assignment, and start_noise and start_seed for the next start; regrid keeps
    the motion too; hang and reset start anew.
    Everything raises ValueError for a value that it cannot take, and then leaves the cloth as it
    was; an attribute that it does not have is an AttributeError. Whatever is set, the state stays
    finite.
    """

    def __init__(self, rows=21, columns=31, length=2.25, width=1.5, hoist_top=(0.05, 0.0, 8.9), *,
                 pinned=True, material=None, air=None, gravity=9.81, stepping=None,
                 solver='symplectic', stretch_limit=1.0, pole=None,
                 precision='float64', start_noise=1e-4, start_seed=0, threads=1):
        hoist_top = checks.vector('hoist_top', hoist_top, MAX_HOIST)
        self._material = checks.instance('material', _or_default(material, Material), Material)
        self.air = _or_default(air, Air)
        self.gravity = gravity
        self.stepping = _or_default(stepping, Stepping)
        self._pole = None
        self.start_noise = start_noise
        self.start_seed = start_seed
        self._held = 0
        self._pool = ThreadPool(checks.whole('threads', threads, 0, MAX_THREADS))
        self._solver_name = checks.choice('solver', solver, SOLVERS)
        self._put_on(Mesh(rows, columns, length, width, pinned, precision), hoist_top)
        self.pole = pole
        self.reset()
        self._stretch_limit = None
        self.stretch_limit = stretch_limit

    @property
    def mesh(self):
        """Return the grid; see regrid and hang."""
        return self._mesh

    @property
    def hoist_top(self):
        """Where the upper hoist corner is held: (x, y, z) [m]."""
        return self._hoist_top

    @property
    def material(self):
        """Return what the cloth is made of."""
        return self._material

    @material.setter
    def material(self, material):
        checks.instance('material', material, Material)
        if material != self._material:
            self._remodel(self._mesh, material, self._solver_name)

    @property
    def air(self):
        """Return the air that carries the wind."""
        return self._air

    @air.setter
    def air(self, air):
        self._air = checks.instance('air', air, Air)

    @property
    def stepping(self):
        """Return how frames are divided into steps."""
        return self._stepping

    @stepping.setter
    def stepping(self, stepping):
        self._stepping = checks.instance('stepping', stepping, Stepping)

    @property
    def model(self):
        """Return the material on the mesh as it is simulated: softened, where it had to be."""
        return self._solver.model

    @property
    def gravity(self):
        """Acceleration g along -z [m/s2]."""
        return self._gravity

    @gravity.setter
    def gravity(self, gravity):
        self._gravity = checks.finite('gravity', gravity, -1e4, 1e4)

    @property
    def stretch_limit(self):
        """Greatest strain from the hoist to a node; a lower one counts at once."""
        return self._stretch_limit

    @stretch_limit.setter
    def stretch_limit(self, limit):
        limit = checks.finite('stretch_limit', limit, 0.0, 1e6)
        if limit != self._stretch_limit:
            self._stretch_limit = limit
            self._hold()

    @property
    def start_noise(self):
        """Greatest distance from flat at which the cloth starts [m]."""
        return self._start_noise

    @start_noise.setter
    def start_noise(self, size):
        self._start_noise = checks.finite('start_noise', size, 0.0, MAX_NOISE)

    @property
    def start_seed(self):
        """Which of all random bumps the cloth starts with."""
        return self._start_seed

    @start_seed.setter
    def start_seed(self, seed):
        self._start_seed = checks.whole('start_seed', seed, 0, 2**31 - 1)

    @property
    def held(self):
        """Return how many nodes stretch_limit held back in the last frame."""
        return self._held

    @property
    def pole(self):
        """Return the cylinder (x, y, radius) [m] that the cloth stays out of, or None."""
        return self._pole

    @pole.setter
    def pole(self, pole):
        if pole is not None:
            pole = checks.vector('pole', pole, MAX_HOIST)
            checks.finite('radius of the pole', pole[2], above=0.0)
            if self._mesh.pinned:
                _require_outside(pole, self._hoist_top)
        self._pole = pole

    @property
    def solver(self):
        """Return the method's name, one of SOLVERS."""
        return self._solver_name

    @solver.setter
    def solver(self, name):
        if checks.choice('solver', name, SOLVERS) != self._solver_name:
            self._remodel(self._mesh, self._material, name)

    @property
    def precision(self):
        """Return the precision of the numbers inside, float64 or float32."""
        return self._mesh.precision

    @precision.setter
    def precision(self, precision):
        if checks.choice('precision', precision, PRECISIONS) != self._mesh.precision:
            old, positions, velocities = self._mesh, self.positions, self.velocities
            self._put_on(Mesh(old.rows, old.columns, old.length, old.width, old.pinned, precision),
                         self._hoist_top)
            self.place(positions, velocities)

    @property
    def positions(self):
        """Return a copy of the nodes' positions: (rows, columns, 3) float64 [m]."""
        return self._state.positions()

    @property
    def velocities(self):
        """Return a copy of the nodes' velocities: (rows, columns, 3) float64 [m/s]."""
        return self._state.velocities()

    def normals(self):
        """Return the nodes' unit normals: (rows, columns, 3)."""
        return node_normals(self.positions)

    def reset(self):
        """Lay the cloth flat along +x from the hoist, but for its bump, at rest."""
        positions = self._mesh.rest(self._hoist_top)
        positions[..., 1] += bump(self._mesh.rows, self._mesh.columns, self._start_noise,
                                  self._start_seed)
        self._state.place(positions)

    def place(self, positions, velocities=None):
        """Put all nodes, pins too, at positions and velocities (rows, columns, 3) [m], [m/s]."""
        self._state.place(positions, velocities)

    def hang(self, hoist_top, length, width):
        """Change the flag's size [m] and where it is held, (x, y, z) [m]; it starts at rest."""
        hoist_top = checks.vector('hoist_top', hoist_top, MAX_HOIST)
        old = self._mesh
        mesh = Mesh(old.rows, old.columns, length, width, old.pinned, old.precision)
        if mesh.pinned and self._pole is not None:
            _require_outside(self._pole, hoist_top)
        self._put_on(mesh, hoist_top)
        self.reset()

    def regrid(self, rows, columns):
        """Change the grid while the motion goes on, with its strain and momentum (resampling)."""
        old = self._mesh
        mesh = Mesh(rows, columns, old.length, old.width, old.pinned, old.precision)
        positions, velocities = carry_over(
            Model(old, self._material), self.positions, self.velocities,
            Model(mesh, self._material), self._hoist_top)
        self._put_on(mesh, self._hoist_top)
        self.place(positions, velocities)
        self._hold()

    def advance(self, dt, wind=(0.0, 0.0, 0.0)):
        """
        Move the cloth on by a frame of dt [s] in a steady wind (x, y, z) [m/s]; return its Plan.

        Raises Diverged if the frame went out of bounds: the cloth then still stands at its start.
        """
        dt = checks.finite('dt', dt, high=MAX_FRAME, above=0.0)
        wind = checks.vector('wind', wind, MAX_WIND)
        forcing = Forcing(wind, self._gravity, self.air, self._cylinder(), self._stretch_limit)
        steps = self._planned(dt)
        self._last_good[...] = self._state.data
        try:
            self._move(steps.granted, dt / steps.granted, forcing)
        except BaseException:
            self._state.data[...] = self._last_good  # an interrupt: threads may be steps apart
            raise
        self._hold_if_broken(steps, dt / steps.granted)
        self._hold()
        return steps

    def _move(self, count, step, forcing):
        """Take count steps of step [s]."""
        with self._pool.frame(count):
            state = self._solver.advance(self._state, self._spare, forcing, step, count,
                                         self._pool)
        if state is not self._state:
            self._state, self._spare = self._spare, self._state

    def _hold(self):
        """Bring back what is in the pole or farther from the hoist than stretch_limit allows."""
        limits = Limits.of(self._mesh, self._cylinder(), self._stretch_limit)
        contact = self._solver.contact
        constrain(self._state, self._spare, limits, contact)
        self._held = int(np.count_nonzero(contact.held))

    def _cylinder(self):
        """Return the pole as Forcing has it, measured from where positions are."""
        if self._pole is None:
            return NO_POLE
        x, y, radius = self._pole
        return x - self._hoist_top[0], y - self._hoist_top[1], radius

    def _planned(self, dt):
        """Return the Plan for a frame, and make the solver ready to carry it out."""
        largest_step = functools.partial(self._solver.largest_step, air=self.air)
        steps = plan(dt, *self._bounds, largest_step, self.stepping, self._solver.useful_step,
                     SHORTEST_STEP[self._mesh.precision])
        factors = (steps.stiffness_factor, steps.damping_factor)
        if factors != self._solver.model.factors:
            self._solver = type(self._solver)(Model(self._mesh, self._material, *factors))
        return steps

    def _hold_if_broken(self, steps, step):
        """Go back to the frame's start and raise if the state is out of bounds."""
        broken = broken_bound(self._state)
        if broken:
            self._state.data[...] = self._last_good
            way_out = advice(self.solver, step, self.stepping.step_safety, *self._bounds,
                             self.air)
            raise Diverged(f'{broken} with solver {self.solver} in {steps.granted} steps of '
                           f'{step:.3g} s; the cloth is held where the frame began; {way_out}')

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
        model = Model(mesh, material)
        solver = SOLVERS[solver_name](model)
        bounds = solver.frequency_bound(model), damping_bound(model)
        self._mesh, self._material, self._solver_name = mesh, material, solver_name
        self._bounds, self._solver = bounds, solver


def _or_default(value, kind):
    """Return value or, for None, what the class makes by default."""
    return kind() if value is None else value


def _require_outside(pole, hoist_top):
    """Raise ValueError for a hoist inside the pole: cloth could leave it only through its side."""
    x, y, radius = pole
    distance = math.hypot(hoist_top[0] - x, hoist_top[1] - y)
    if distance < radius * (1.0 - 1e-9):
        raise ValueError(f'the hoist must not be inside the pole: it is {distance:g} m from the '
                         f'axis, whose radius is {radius:g} m')
