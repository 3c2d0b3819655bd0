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

"""Steps by several threads: the same to the bit, and none waits for one that does not come."""
import multiprocessing
import subprocess
import sys
import threading

from flag_sim.cloth import Air, Cloth
from flag_sim.cloth.mesh import Mesh, PRECISIONS, SMALLEST_BAND
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.solvers.symplectic import STRIP
import numpy as np
import pytest

WIND = (5.0, 2.0, 0.5)


def flown(frames=4, grid=(33, 47), **parameters):
    """Return positions after some frames in the wind."""
    cloth = Cloth(*grid, **parameters)
    for _ in range(frames):
        cloth.advance(0.01, WIND)
    return cloth.positions


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('solver', SOLVERS)
def test_the_same_motion_to_the_bit(solver, precision):
    """Of parallel methods and of the others; with more threads than processors too."""
    alone = flown(solver=solver, precision=precision)
    for threads in (2, 3, 7):
        together = flown(solver=solver, precision=precision, threads=threads)
        np.testing.assert_array_equal(together, alone)


@pytest.mark.parametrize('air', [Air(), Air(added_mass=0.5)], ids=['air', 'moving'])
@pytest.mark.parametrize('grid', [(2, 2), (3, 50), (50, 3), (21, 31)], ids=str)
def test_grids_of_all_shapes(grid, air):
    """Bands may be empty, and end anywhere in a row; sums over all nodes are made in one order."""
    np.testing.assert_array_equal(flown(grid=grid, threads=5, air=air), flown(grid=grid, air=air))


@pytest.mark.parametrize('grid', [(81, 121), (12, 1001)], ids=str)
def test_strips_change_nothing(grid):
    """One thread computes a large grid strip by strip, many small bands are computed as wholes."""
    mesh = Mesh(*grid, 1.0, 1.0)
    first, last, _ = mesh.band()
    assert last - first > 3 * STRIP and (last - first) / 7 < STRIP
    pole = (0.5, 0.05, 0.1)
    np.testing.assert_array_equal(flown(1, grid=grid, pole=pole, threads=7),
                                  flown(1, grid=grid, pole=pole))


def test_the_choice_changes_nothing_but_the_time():
    """While it measures too."""
    np.testing.assert_array_equal(flown(15, threads=0), flown(15))


@pytest.mark.parametrize('grid', [(2, 2), (9, 13), (81, 121)], ids=str)
@pytest.mark.parametrize('bands', [1, 2, 3, 7, 64])
def test_every_node_is_in_one_band(grid, bands):
    """They follow one another, begin at whole pieces, and differ by one of these at most."""
    mesh = Mesh(*grid, 1.0, 1.0)
    found = [mesh.band(band, bands) for band in range(bands)]
    assert found[0][0] == mesh.first and found[-1][1] == mesh.last
    assert all(one[1] == other[0] for one, other in zip(found, found[1:]))
    assert all((first - mesh.first) % SMALLEST_BAND == 0
               for first, last, _ in found if first < last)
    pieces = [-(-int(last - first) // SMALLEST_BAND) for first, last, _ in found]
    assert max(pieces) - min(pieces) <= 1


def test_an_interrupt_leaves_the_cloth_at_the_frames_start(monkeypatch):
    """Ctrl-C comes to the main thread when the others wait for it already."""
    cloth, same = Cloth(threads=3), Cloth()
    cloth.advance(0.01, WIND)
    same.advance(0.01, WIND)
    before = cloth.positions
    kind = SOLVERS['symplectic']
    take_steps = kind.take_steps

    def interrupted(*arguments):
        if threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt
        take_steps(*arguments)

    with monkeypatch.context() as patch:
        patch.setattr(kind, 'take_steps', staticmethod(interrupted))
        with pytest.raises(KeyboardInterrupt):
            cloth.advance(0.01, WIND)
    np.testing.assert_array_equal(cloth.positions, before)
    cloth.advance(0.01, WIND)
    same.advance(0.01, WIND)
    np.testing.assert_array_equal(cloth.positions, same.positions)


@pytest.mark.filterwarnings('ignore:.*multi-threaded, use of fork.*:DeprecationWarning')
def test_a_forked_process_has_threads_of_its_own():
    """A fork copies the cloth but not the threads that it waits for."""
    cloth = Cloth(9, 13, threads=2)
    cloth.advance(0.01, WIND)

    def child(out):
        cloth.advance(0.01, WIND)
        out.send(cloth.positions)

    context = multiprocessing.get_context('fork')
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=child, args=(there,))
    process.start()
    try:
        assert here.poll(60.0)
        in_child = here.recv()
    finally:
        process.kill()
        process.join()
    cloth.advance(0.01, WIND)
    np.testing.assert_array_equal(in_child, cloth.positions)


def test_a_process_with_threads_ends():
    """They neither keep it alive nor complain."""
    done = subprocess.run(
        [sys.executable, '-c', 'from flag_sim.cloth import Cloth; Cloth(threads=3).advance(0.01)'],
        capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, '')


@pytest.mark.parametrize('solver', SOLVERS)
def test_a_pole_is_kept_out_of_with_threads_too(solver):
    """Each holds its own nodes, after all have read where these were."""
    pole = (0.5, 0.05, 0.1)
    alone = flown(solver=solver, pole=pole)
    assert np.hypot(alone[..., 0] - 0.5, alone[..., 1] - 0.05).min() > 0.1 * (1.0 - 1e-12)
    for threads in (2, 3, 7):
        np.testing.assert_array_equal(flown(solver=solver, pole=pole, threads=threads), alone)
    assert not np.array_equal(flown(solver=solver), alone)


@pytest.mark.parametrize('threads, rule', [
    (-1, 'threads must be a whole number from 0 to 64, not -1'), (65, 'to 64, not 65'),
    (1.5, 'threads must be a whole number')])
def test_bad_numbers_of_threads_are_refused(threads, rule):
    """By the rule and the value."""
    with pytest.raises(ValueError, match=rule):
        Cloth(threads=threads)
