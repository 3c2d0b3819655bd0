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

"""Cloths of float32: as near to those of float64 as their numbers allow, and nothing else new."""
import math

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.energy import elastic_energy, kinetic_energy
from flag_sim.cloth.mesh import PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import SOLVERS
import numpy as np
import pytest
from support.cloths import potential_energy

WIND = (5.0, 2.0, 0.5)
EPS = float(np.finfo('float32').eps)


@pytest.mark.parametrize('solver', SOLVERS)
def test_float32_moves_as_float64_does(solver):
    """
    Before chaos sets in: for 0.1 s of a gust, to 0.1 mm.

    A length of 2 m is rounded to 0.1 micrometres, which springs of 1000 N/m feel as noise; over
    the 200 steps it grows to some hundred times that. Positions that were float32 only once in
    their life would be as near as 0.1 micrometres.
    """
    cloths = [Cloth(solver=solver, precision=precision) for precision in PRECISIONS]
    for _ in range(6):
        for cloth in cloths:
            cloth.advance(1.0 / 60.0, WIND)
    exact, rounded = (cloth.positions for cloth in cloths)
    assert 1e-8 < np.abs(rounded - exact).max() < 1e-4
    assert np.abs(exact - Cloth().positions).max() > 0.01


@pytest.mark.parametrize('solver', SOLVERS)
def test_more_steps_do_not_take_float32_away(solver):
    """
    Up to the most that are taken, a fall of a second is late by half a step's way, or 2 mm.

    Each step rounds the way by up to half a unit in the last place, 0.24 micrometres at 4.9 m.
    """
    for substeps in (20, 200, 1000):
        cloth = Cloth(3, 4, pinned=False, air=Air(density=0.0), solver=solver, start_noise=0.0,
                      precision='float32', stepping=Stepping(substeps, substeps_limit=10**4))
        start = cloth.positions
        for _ in range(30):
            steps = cloth.advance(1.0 / 30.0)
        fallen = (start - cloth.positions)[..., 2]
        late = 0.5 * 9.81 / (30.0 * steps.granted)
        assert np.abs(fallen - 0.5 * 9.81).max() < 1.01 * late + 2e-3


def test_float32_takes_no_steps_that_it_cannot_resolve():
    """A user's million becomes 100,000 a second; float64 takes them."""
    many = Stepping(substeps=10**4, substeps_limit=10**5)
    assert Cloth(3, 4, stepping=many, precision='float32').advance(0.01).granted == 1000
    assert Cloth(3, 4, stepping=many).advance(0.01).granted == 10**4


@pytest.mark.parametrize('precision', PRECISIONS)
def test_a_cloth_far_away_is_as_exact_as_one_that_is_near(precision):
    """A million metres off float32 resolves 6 cm: positions are counted from the hoist."""
    near = Cloth(5, 7, hoist_top=(0.0, 0.0, 0.0), precision=precision)
    far = Cloth(5, 7, hoist_top=(1e6, -1e6, 0.0), precision=precision)
    for _ in range(10):
        near.advance(0.02, WIND)
        far.advance(0.02, WIND)
    # What is given in and out is float64, and good to 1e-10 m there.
    np.testing.assert_allclose(far.positions - far.hoist_top, near.positions, atol=1e-4)
    assert np.array_equal(far.positions[:, 0] - far.hoist_top, near.positions[:, 0])


@pytest.mark.parametrize('solver', SOLVERS)
def test_precision_changes_between_frames_without_a_jump(solver):
    """Positions are rounded once, and the motion goes on; back again, nothing is rounded."""
    cloth = Cloth(9, 13, solver=solver)
    for _ in range(10):
        cloth.advance(0.02, WIND)
    before = cloth.positions
    cloth.precision = 'float32'
    assert cloth.precision == 'float32'
    assert cloth.positions.dtype == cloth.velocities.dtype == np.float64
    jump = np.abs(cloth.positions - before).max()
    assert 0.0 < jump < 4.0 * EPS
    rounded = cloth.positions
    cloth.precision = 'float64'
    assert np.array_equal(cloth.positions, rounded)
    cloth.precision = 'float32'
    cloth.advance(1e-3, WIND)
    assert 0.0 < np.abs(cloth.positions - before).max() < 0.02


def test_a_new_grid_or_size_keeps_the_precision():
    """Only the parameter changes it."""
    cloth = Cloth(5, 7, precision='float32')
    cloth.regrid(6, 8)
    assert cloth.precision == 'float32'
    cloth.hang((0.0, 0.0, 1.0), 1.0, 1.0)
    assert cloth.precision == 'float32'
    cloth.advance(0.01, WIND)


def test_an_unknown_precision_is_refused():
    """And the cloth stays as it was."""
    with pytest.raises(ValueError, match="precision must be one of .*, not 'float16'"):
        Cloth(precision='float16')
    cloth = Cloth(5, 7)
    with pytest.raises(ValueError, match="precision must be one of .*, not 'half'"):
        cloth.precision = 'half'
    assert cloth.precision == 'float64'


@pytest.mark.parametrize('solver', SOLVERS)
def test_free_fall_in_float32(solver):
    """
    As in float64, but for the rounding of the positions, which springs and XPBD take for motion.

    One unit, of numbers between 2 and 4, in one step is a velocity; n of them add up as a random
    walk, and twice that is never exceeded.
    """
    cloth = Cloth(6, 9, pinned=False, air=Air(density=0.0), solver=solver, precision='float32')
    start = cloth.positions
    for _ in range(10):
        steps = cloth.advance(0.02)
    fallen, time, count = start - cloth.positions, 0.2, 10 * steps.granted
    noise = 2.0 * math.sqrt(count) * 2.0 * EPS / (time / count)
    late = 0.5 * 9.81 * time * 0.02 / steps.granted + time * noise
    assert fallen[..., 2] == pytest.approx(np.full((6, 9), 0.5 * 9.81 * time**2), abs=late)
    assert cloth.velocities[..., 2] == pytest.approx(np.full((6, 9), -9.81 * time), abs=noise)


def test_stretch_under_own_weight_in_float32():
    """
    M g L / (2 E A) to a thousandth.

    At rest a node stops where a step moves it by less than half a unit of its position, which
    here lets dampers of 40 / s hold back forces of a thousandth of the weight.
    """
    length, width, stiffness, density = 2.0, 0.5, 400.0, 0.3
    cloth = Cloth(3, 6, length, width, air=Air(density=0.0), precision='float32',
                  material=Material(density, stiffness, 0.0, 0.0, 0.2, 40.0))
    flat = cloth.positions - cloth.hoist_top
    cloth.place(np.stack([-flat[..., 2], flat[..., 1], -flat[..., 0]], axis=-1) + cloth.hoist_top)
    for _ in range(40):
        cloth.advance(0.05)
    longer = cloth.hoist_top[2] - cloth.positions[:, -1, 2] - length
    mass = density * length * width
    np.testing.assert_allclose(longer, mass * 9.81 * length / (2.0 * stiffness * width), rtol=1e-3)


@pytest.mark.parametrize('solver', ['symplectic', 'verlet', 'rk4', 'seed'])
def test_energy_is_bounded_without_damping_in_float32(solver):
    """Over 20,000 steps of large motion, within the bounds that hold for float64."""
    cloth = Cloth(6, 8, air=Air(density=0.0), material=Material(bend_stiffness=0.0, damping=0.0),
                  stepping=Stepping(substeps=20), solver=solver, precision='float32')
    cloth.place(cloth.positions, np.random.default_rng(4).normal(size=(6, 8, 3)))
    model = Model(cloth.mesh, cloth.material)
    scale = 0.2 * 2.25 * 1.5 * 9.81 * 1.5
    energies, count = [], 0
    while count < 20000:
        count += cloth.advance(0.01).granted
        energies.append(kinetic_energy(model, cloth.velocities)
                        + elastic_energy(model, cloth.positions)
                        + potential_energy(model, cloth.positions, 9.81))
    assert np.ptp(energies) < 0.05 * scale
    first, second = np.array_split(energies, 2)
    assert abs(second.mean() - first.mean()) < 0.01 * scale


def test_a_falling_sheet_reaches_its_terminal_speed_in_float32():
    """Speed v_t tanh(g t / v_t), in all nodes alike, as in float64."""
    cloth = Cloth(5, 8, pinned=False, stepping=Stepping(substeps=100), precision='float32')
    cloth.place(cloth.positions[..., [0, 2, 1]])
    terminal = math.sqrt(2.0 * 0.2 * 9.81 / (1.2 * 1.17))
    for frame in range(1, 31):
        cloth.advance(0.02)
        expected = -terminal * math.tanh(9.81 * 0.02 * frame / terminal)
        np.testing.assert_allclose(cloth.velocities[..., 2], expected, rtol=2e-3)
