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

"""A solver is one class and one line: one that is added here runs as the others do."""
import math

from flag_sim.cloth import Cloth, Stepping
from flag_sim.cloth.collision import collide
from flag_sim.cloth.forces import set_forces
from flag_sim.cloth.records import Nodes
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.solvers.elementwise import set_sum, set_weighted
from flag_sim.cloth.solvers.solver import Solver
from flag_sim.jit.kernels import shared_kernel
from flag_sim.parallel.barrier import wait
import numpy as np
import pytest

WIND = (3.0, 2.0, 1.0)


@shared_kernel(cache=False)
def _take_steps(nodes, nodes_out, sheet, coefficients, work, scratch, steps, band):
    """Take steps as Solver.take_steps says; scratch: the nodes half way, and accelerations."""
    middle, acceleration = scratch
    dt = steps.dt
    half = type(dt)(0.5) * dt
    for _ in range(steps.count):
        # Half a step by the rates at its beginning.
        set_forces(nodes, sheet, coefficients, work, dt, band)
        set_weighted(sheet.inverse_mass, work.force, acceleration, band)
        set_sum(nodes.position, half, nodes.velocity, middle.position, band)
        set_sum(nodes.velocity, half, acceleration, middle.velocity, band)
        wait(work.barrier)
        # The whole step by the rates in its middle.
        set_forces(middle, sheet, coefficients, work, dt, band)
        set_weighted(sheet.inverse_mass, work.force, acceleration, band)
        set_sum(nodes.position, dt, middle.velocity, nodes_out.position, band)
        set_sum(nodes.velocity, dt, acceleration, nodes_out.velocity, band)
        # The pole, and the attachment to the hoist.
        collide(nodes, nodes_out, coefficients.limits, work.contact, band)
        wait(work.barrier)
        nodes, nodes_out = nodes_out, nodes


class Midpoint(Solver):
    """The explicit midpoint method: second order, for two evaluations of the forces a step."""

    order = 2
    drag_order = 2
    take_steps = staticmethod(_take_steps)
    is_parallel = True

    @classmethod
    def new_scratch(cls, model):
        """Return room for the nodes half way, and for their acceleration [m/s2]."""
        fields = tuple(model.mesh.fields(9))
        return Nodes(fields[:3], fields[3:6]), fields[6:]

    @classmethod
    def largest_step(cls, omega, gamma, air):
        """Return a step [s] in which waves grow by a hundred thousandth at most."""
        return min(0.1 / omega, 1.0 / gamma if gamma > 0.0 else math.inf)


@pytest.fixture(autouse=True)
def added(monkeypatch):
    """Add the line."""
    monkeypatch.setitem(SOLVERS, 'midpoint', Midpoint)


def flown(**options):
    """Return where a bent sheet is after a short frame in the wind."""
    cloth = Cloth(9, 13, **options)
    positions = cloth.positions
    positions[..., 1] += 0.1 * positions[..., 0]**2
    cloth.place(positions)
    cloth.advance(0.01, WIND)
    return cloth.positions


def test_a_cloth_steps_by_it_to_its_order():
    """Half the step, a quarter of the error, towards the motion of rk4."""
    exact = flown(solver='rk4', stepping=Stepping(substeps=512))
    coarse, fine = (np.abs(flown(solver='midpoint', stepping=Stepping(substeps=count))
                           - exact).max() for count in (128, 256))
    assert 3.5 < coarse / fine < 4.5


def test_threads_pole_and_precision_come_with_it():
    """The same to the bit for any number of threads; out of the pole; in float32 too."""
    options = {'solver': 'midpoint', 'pole': (0.5, 0.05, 0.1), 'precision': 'float32'}
    alone = flown(**options)
    np.testing.assert_array_equal(flown(threads=3, **options), alone)
    assert np.hypot(alone[..., 0] - 0.5, alone[..., 1] - 0.05).min() > 0.1 * (1.0 - 1e-6)


def test_a_frame_may_change_to_it():
    """And its steps are as many as its largest one says."""
    cloth = Cloth(9, 13)
    before = cloth.advance(0.01, WIND)
    cloth.solver = 'midpoint'
    assert cloth.advance(0.01, WIND).granted > before.granted


@pytest.mark.parametrize('missing', ['order', 'drag_order', 'take_steps', 'largest_step'])
def test_half_a_solver_is_none(missing):
    """What a solver must provide is said by name."""
    given = {name: value for name, value in vars(Midpoint).items()
             if name not in (missing, '__dict__', '__weakref__', '__doc__')}
    with pytest.raises(TypeError, match=missing):
        type('Half', (Solver,), given)(Cloth(3, 3).model)
