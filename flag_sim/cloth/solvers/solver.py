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

"""What all methods have in common."""
import functools
import math

from flag_sim.cloth.forces import Work
from flag_sim.cloth.stability import frequency_bound
from flag_sim.parallel.barrier import new_barrier, release
from flag_sim.parallel.thread_pool import ThreadPool

ALONE = ThreadPool(1)


class Solver:
    """
    A method for a model; derived classes say which. Only the caller advances time.

    order: of its error in the step. scratch: flat fields that its kernel needs beside the forces'.
    useful_step: the longest step [s] worth taking, for methods whose largest stable one is
    infinite. take_steps: the kernel; is_shared: whether it waits for others at work.barrier, so
    that threads can share its steps. largest_step(omega, gamma, air): the largest stable step
    [s] for frequencies and damping rates up to omega and gamma, in the drag of an Air.
    """

    order = 1
    scratch = 0
    useful_step = math.inf
    is_shared = False

    def __init__(self, model):
        self.model = model
        self._work = Work.of(model.mesh)
        self._scratch = (tuple(model.mesh.fields(self.scratch)),) if self.scratch else ()

    @staticmethod
    def frequency_bound(model):
        """Return the bound [rad/s] of the frequencies that limit the method's steps."""
        return frequency_bound(model)

    @classmethod
    def stable_step(cls, omega, gamma, air):
        """Return the largest step [s] in which no motion can grow by itself; 0 if none is."""
        return cls.largest_step(omega, gamma, air)

    @property
    def contact(self):
        """Return the Contact of the last steps, whose held says what the attachment did."""
        return self._work.contact

    def advance(self, state, spare, forcing, dt, count, pool=ALONE):
        """
        Take count steps of dt [s] from state; return the one of the two that holds the result.

        Both are written to, in turn. The pool's threads share the nodes, if the method lets them;
        the result is the same to the bit for any number of them.
        """
        model = self.model
        number = model.mesh.number
        bands = pool.threads if self.is_shared else 1
        barrier = new_barrier(bands)
        work = self._work._replace(barrier=barrier)
        work.contact.held[...] = 0.0

        def take(band, bands):
            self.take_steps(
                state.position, state.velocity, spare.position, spare.velocity,
                number(forcing.wind), model.mass, model.inverse_mass, model.mesh.weights,
                model.coefficients(forcing, self.order), work, *self._scratch, number(dt), count,
                model.mesh.band(band, bands))

        if bands == 1:
            take(0, 1)
        else:
            pool.run_bands(take, functools.partial(release, barrier))
        return spare if count % 2 else state
