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

"""What a method is: the contract that every solver keeps, and how its steps are called."""
import abc
import functools
import math
from typing import Any

from flag_sim.cloth.contact import Contact
from flag_sim.cloth.forces import Coefficients, Forcing, Work
from flag_sim.cloth.material import Air
from flag_sim.cloth.model import Model
from flag_sim.cloth.records import Band, Nodes, Sheet, Steps
from flag_sim.cloth.stability import frequency_bound
from flag_sim.cloth.state import State
from flag_sim.cloth.turning import Turn
from flag_sim.parallel.barrier import new_barrier, release
from flag_sim.parallel.thread_pool import ThreadPool

ONE_THREAD = ThreadPool(1)


class Solver(abc.ABC):
    """
    A method that steps a Model through time: a subclass in its own file, and a line in SOLVERS.

    Only the caller advances time: a solver keeps nothing of the motion from one call to the next.

    A subclass must provide order, drag_order, take_steps and largest_step. It may leave

    - useful_step: the longest step [s] worth taking, for methods whose largest stable one is long
      or infinite;
    - force_time: when its forces act, as a part of the step, for a pole that turns (see turning):
      0 where they change the velocity first and that moves the nodes, 1/2 where they are a mean;
    - is_parallel: whether threads may compute its steps together. take_steps then waits at
      work.barrier before it reads of neighbours what another thread writes, and before it writes
      what another one may still read;
    - moves_air: whether it takes account of air.added_mass;
    - frequency_bound and stable_step, where other frequencies than the cloth's own limit its
      steps, or steps can be taken that are not stable in all motions;
    - new_scratch and scratch_from, where it needs more arrays than those of Work.
    """

    useful_step: float = math.inf
    force_time: float = 0.0
    is_parallel: bool = False
    moves_air: bool = False

    def __init__(self, model: Model):
        self.model = model
        self._work = Work.of(model.mesh)
        self._scratch = self.new_scratch(model)

    @property
    @abc.abstractmethod
    def order(self) -> int:
        """Of the method: its error after a given time is as step^order. A class attribute."""

    @property
    @abc.abstractmethod
    def drag_order(self) -> int:
        """
        To which order in the step the wind's drag is kept from overshooting; 1, 2 or 4.

        No lower than the method's own, or drag would spoil that; see drag. A class attribute.
        """

    @staticmethod
    @abc.abstractmethod
    def take_steps(nodes: Nodes, nodes_out: Nodes, sheet: Sheet, coefficients: Coefficients,
                   work: Work, scratch: Any, steps: Steps, band: Band) -> None:
        """
        Take steps.count steps of steps.dt [s] each; a kernel, which Python calls once a frame.

        nodes: positions [m] and velocities [m/s] at the beginning. nodes_out: of the same shape;
        what it holds at the beginning means nothing. Each step reads one of the two and writes the
        other, so the result is in nodes_out after an odd number of steps, and in nodes after an
        even one; what the other holds then means nothing. Nodes with inverse mass zero, pins and
        ghosts, must be as they were in both.
        sheet: masses and weights; constant, as is all in coefficients: of springs, bending,
        gravity, wind, node damping and limits. coefficients.wind.order is drag_order.
        work: for forces.set_forces, and for collision.collide, which has to be called at each
        step's end to keep the nodes within coefficients.limits. After the last step
        work.contact.brought_back is 1 where that brought a node back, in any of the steps.
        scratch: of scratch_from. Of work and scratch nothing else is kept.
        band: the nodes that are this call's to write, all of them unless is_parallel. Others call
        take_steps at the same time with the other bands and otherwise the same arguments.

        All fields are flat (mesh.size,) arrays in the precision of the mesh, x, y and z apart, and
        none overlaps another; see mesh.Mesh.
        """

    @classmethod
    @abc.abstractmethod
    def largest_step(cls, omega: float, gamma: float, air: Air) -> float:
        """
        Return the largest step [s] that frames are divided into; math.inf where any will do.

        omega: the bound of angular frequencies [rad/s] that frequency_bound gives. gamma: a bound
        of the rates at which dashpots slow a node down [1/s]. air: whose drag adds a rate of
        air.greatest_rate(drag_order) in a step. It has the dimension of time: omega and gamma
        both halved, the step is at least twice as long.
        """

    @classmethod
    def stable_step(cls, omega: float, gamma: float, air: Air) -> float:
        """Return the largest step [s] in which no motion can grow by itself; 0 if none is."""
        return cls.largest_step(omega, gamma, air)

    @staticmethod
    def frequency_bound(model: Model) -> float:
        """Return the bound [rad/s] of the frequencies that limit the method's steps."""
        return frequency_bound(model)

    @classmethod
    def new_scratch(cls, model: Model) -> Any:
        """Return arrays of the method's own to compute in, a NamedTuple or a tuple; or none."""
        return ()

    def scratch_from(self, state: State) -> Any:
        """Return what take_steps gets as scratch for the steps from a state."""
        return self._scratch

    @property
    def contact(self) -> Contact:
        """Return the Contact of the last steps, which says what the attachment brought back."""
        return self._work.contact

    @classmethod
    def require(cls, air: Air) -> None:
        """Raise ValueError for air that the method cannot move with the cloth."""
        if air.added_mass > 0.0 and not cls.moves_air:
            raise ValueError('air.added_mass above 0 needs solver symplectic: the other methods '
                             'do not move the air with the cloth')

    def advance(self, state: State, spare: State, forcing: Forcing, dt: float, count: int,
                pool: ThreadPool = ONE_THREAD) -> State:
        """
        Take count steps of dt [s] from state; return the one of the two that holds the result.

        Both are written to, in turn. The pool's threads compute bands of the nodes, if the method
        lets them; the result is the same to the bit for any number of them. Raises ValueError for
        an added mass of air that the method cannot move.
        """
        self.require(forcing.air)
        model = self.model
        threads = pool.threads if self.is_parallel else 1
        barrier = new_barrier(threads)
        work = self._work._replace(barrier=barrier)
        work.contact.brought_back[...] = 0.0
        coefficients = model.coefficients(forcing, self.drag_order)
        turn = Turn.of(model.mesh, forcing.spin, forcing.lever, dt, self.force_time)
        coefficients = coefficients._replace(limits=coefficients.limits._replace(turn=turn))
        scratch, steps = self.scratch_from(state), Steps(model.mesh.number(dt), count)

        def take(number, threads):
            self.take_steps(state.nodes, spare.nodes, model.sheet, coefficients, work, scratch,
                            steps, model.mesh.band(number, threads))

        if threads == 1:
            take(0, 1)
        else:
            pool.run_bands(take, functools.partial(release, barrier))
        return spare if count % 2 else state
