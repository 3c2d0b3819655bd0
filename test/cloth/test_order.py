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

"""The error of every solver falls with its step as it claims."""
import functools

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest

ASYMPTOTIC = {1: 256, 2: 64, 4: 32}
"""Steps from which on a method of an order shows it: a few times as many as are stable."""
HALVINGS = 4
FINEST = 2**14
"""Steps of the reference, rk4: its error is at most 1e-3 of the least that is measured."""


@functools.lru_cache
def bent_sheet(solver, count, node_damping, without_friction):
    """
    Return where a bent sheet is after 0.02 s in the wind, in count steps.

    The motion is smooth, with all forces. Without friction the dashpots are off and the law of the
    wind is the one that does not know the cloth's velocity.
    """
    material = Material(bend_stiffness=0.01, damping=0.0 if without_friction else 0.05,
                        node_damping=node_damping)
    air = Air(law='seed' if without_friction else 'quadratic')
    cloth = Cloth(5, 7, solver=solver, material=material, air=air,
                  stepping=Stepping(substeps=count, substeps_limit=FINEST))
    positions = cloth.positions
    positions[..., 1] += 0.1 * positions[..., 0]**2
    cloth.place(positions)
    assert cloth.advance(0.02, (3.0, 2.0, 1.0)).granted == count
    return cloth.positions


def slopes(solver, node_damping):
    """Return by how many powers of two the error falls with each of the halvings of the step."""
    # The seed's friction vanishes with the step: its claim is to converge to motion without it.
    without_friction = solver == 'seed'
    exact = bent_sheet('rk4', FINEST, node_damping, without_friction)
    first = ASYMPTOTIC[SOLVERS[solver].order]
    errors = [np.linalg.norm(
        bent_sheet(solver, first * 2**n, node_damping, without_friction) - exact)
        for n in range(HALVINGS + 1)]
    return -np.diff(np.log2(errors))


def assert_order(found, order):
    """
    Assert that slopes come to an order.

    The next term of the error makes a slope differ by what halves with the step. How much that is
    is told by the coarsest pair, which must leave no doubt about the order itself; the others must
    then be nearer, each by half. A tenth of it is left to the term after the next, and 0.003 to
    errors known to a thousandth: both of the two in a slope, for the reference is no better, nor
    are the equations that implicit solves.
    """
    off = np.abs(found - order)
    assert off[0] < 0.5
    assert np.all(off[1:] <= 1.1 * off[0] / 2.0**np.arange(1, HALVINGS) + 0.003)


@pytest.mark.parametrize('solver', SOLVERS)
def test_order_of_the_method(solver):
    """Towards one and the same motion, that of the finest rk4, with dashpots and wind."""
    assert_order(slopes(solver, 0.0), SOLVERS[solver].order)


@pytest.mark.parametrize('solver', [name for name in SOLVERS if name != 'seed'])
def test_order_with_the_nodes_own_damping(solver):
    """At most two: half of it is taken before a step, half after (Strang); seed has none."""
    assert_order(slopes(solver, 20.0), min(SOLVERS[solver].order, 2))
