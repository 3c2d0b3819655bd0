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

"""Sums over all nodes, in one order whoever makes them."""
import math

from flag_sim.cloth.mesh import Mesh, PRECISIONS
from flag_sim.cloth.solvers import sums
from flag_sim.cloth.solvers.rigid import Body, FREE, Freedom, inertia_of, rigid_of, SUMS
from flag_sim.parallel.barrier import new_barrier, release
from flag_sim.parallel.thread_pool import ThreadPool
import numpy as np
import pytest

GRIDS = [(2, 2), (3, 50), (21, 31), (41, 61), (81, 121)]


def fields(mesh, seed=0):
    """Make three random vectors at each node, zero at ghosts."""
    made = mesh.fields(9)
    for field in made:
        mesh.grid(field)[...] = np.random.default_rng(seed).normal(
            size=(mesh.rows, mesh.columns))
        seed += 1
    return tuple(made[:3]), tuple(made[3:6]), tuple(made[6:])


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('grid', GRIDS, ids=str)
def test_sums_are_those_of_all_nodes(grid, precision):
    """None is left out or counted twice, to the rounding of float64."""
    mesh = Mesh(*grid, 1.0, 1.0, precision=precision)
    a, b, (weight, *_) = fields(mesh)
    room, whole = sums.Sums.of(1), mesh.band()
    exact = math.fsum(float(u) * float(v) for x, y in zip(a, b) for u, v in zip(x, y))
    assert sums.dot(a, b, room, whole) == pytest.approx(exact, rel=1e-12)
    exact = math.fsum(float(w) * float(u)**2 for x in a for u, w in zip(x, weight))
    assert sums.norm2(a, weight, room, whole) == pytest.approx(exact, rel=1e-12)
    assert sums.dot(a, a, room, whole) == sums.dot(a, a, sums.Sums.of(1), whole)


@pytest.mark.parametrize('grid', GRIDS, ids=str)
def test_any_number_of_threads_makes_the_same_sums(grid):
    """To the bit: of inertia and of momenta."""
    mesh = Mesh(*grid, 1.0, 1.0)
    position, *others = fields(mesh)
    body = Body(mesh.mass_share, mesh.mass_share, Freedom(FREE, (0.0,) * 3, (0.0,) * 3))

    def made(threads):
        found, barrier, room = {}, new_barrier(threads), sums.Sums.of(SUMS)

        def work(number, threads):
            bands = mesh.band(number, threads), mesh.band()
            inertia = inertia_of(position, body, room, bands, barrier)
            found[number] = inertia, rigid_of(position, (*others, position), body, inertia, room,
                                              bands, barrier)
        ThreadPool(threads).run_bands(work, lambda: release(barrier))
        return found

    alone = made(1)[0]
    for threads in (2, 3, 7):
        assert all(one == alone for one in made(threads).values())
