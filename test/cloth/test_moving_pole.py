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

"""A pole that moves: the cloth feels its hoist move, the same with every method."""
import math

from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.energy import bending_energy, elastic_energy
from flag_sim.cloth.forces import Forcing
from flag_sim.cloth.plain import take_step
from flag_sim.cloth.pole_frame import PoleFrame, turn_between
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.turning import rotation
from flag_sim.drawing.transforms import apply, rotate_x, rotate_y, rotate_z, translate
import numpy as np
import pytest
from support import moving_air
from support.cloths import model_of
from support.forces import forces

DT = 1.0 / 30.0
WIND = np.array([6.0, 2.0, 0.5])
POLE = (0.0, 0.0, 0.05)
VACUUM = Air(density=0.0)
METHODS = [*(pytest.param(solver, Air(), id=solver) for solver in SOLVERS),
           pytest.param('symplectic', Air(added_mass=0.8), id='moving air')]
"""Every solver, and the inertia of the air."""
FIRM = [method for method in METHODS if method.id != 'seed']
"""All but seed, whose forces see metres per step and so mistake the wind past the pole."""
ROUNDING = {'seed': 1e-6}
"""How far apart rounding takes two flags in a few frames [m]; others than these stay together."""


def swaying(time):
    """Return the pose of a pole on something that drives, turns and pitches."""
    return (translate((2.0 * time, -time * time, 0.3 * time)) @ rotate_z(1.5 * time)
            @ rotate_y(0.3 * math.sin(2.0 * time)))


def stepped(count):
    """Return a Stepping with count steps a frame."""
    return Stepping(substeps=count, substeps_limit=10**5)


@pytest.mark.parametrize('solver, air', METHODS)
def test_steady_motion_is_wind_from_ahead(solver, air):
    """Galilei: through still air at V is the same as to stand in a wind of -V."""
    drive = np.array([3.0, -1.0, 0.7])
    standing, driven = (Cloth(7, 9, pole=POLE, solver=solver, air=air) for _ in range(2))
    driven.place(driven.positions, np.broadcast_to(drive, driven.positions.shape))
    for frame in range(1, 11):
        standing.advance(DT, WIND - drive)
        driven.advance(DT, WIND, translate(frame * DT * drive))
    close = ROUNDING.get(solver, 1e-9)
    np.testing.assert_allclose(driven.positions, standing.positions + frame * DT * drive,
                               atol=close)
    np.testing.assert_allclose(driven.velocities, standing.velocities + drive, atol=1e3 * close)


@pytest.mark.parametrize('solver, air', METHODS)
@pytest.mark.parametrize('pose, gravity', [
    (rotate_z(0.7), 9.81), (translate((4.0, 5.0, 6.0)) @ rotate_z(-2.0) @ rotate_y(0.4), 0.0)],
    ids=['yaw', 'all but gravity'])
def test_where_the_pole_stands_makes_no_difference(solver, air, pose, gravity):
    """A scene that is turned as a whole, its wind too, moves as it did."""
    upright, turned = (Cloth(7, 9, pole=POLE, solver=solver, gravity=gravity, air=air)
                       for _ in range(2))
    turned.pose = pose
    for _ in range(10):
        upright.advance(DT, WIND)
        turned.advance(DT, pose[:3, :3] @ WIND, pose)
    np.testing.assert_allclose(turned.positions, apply(pose, upright.positions),
                               atol=ROUNDING.get(solver, 1e-9))


def test_gravity_stays_that_of_the_world():
    """A flag on a pole that lies on its side hangs from it along its whole hoist."""
    cloth = Cloth(7, 9, hoist_top=(0.0, 0.0, 8.9), air=VACUUM,
                  material=Material(node_damping=3.0))
    cloth.pose = rotate_x(math.pi / 2.0)
    for _ in range(90):
        cloth.advance(DT)
    hoist, fly = cloth.positions[:, 0], cloth.positions[:, -1]
    np.testing.assert_allclose(hoist[:, 2], 0.0, atol=1e-9)
    assert (fly[:, 2] < hoist[:, 2] - 0.98 * cloth.mesh.length).all()


@pytest.mark.parametrize('solver, air', FIRM)
def test_what_is_not_tied_to_the_pole_does_not_feel_it(solver, air):
    """However the pole moves, a free cloth does in the world what it did."""
    def apart(count):
        still, moved = (Cloth(5, 7, pinned=False, solver=solver, air=air, stepping=stepped(count))
                        for _ in range(2))
        for frame in range(1, 7):
            still.advance(DT, WIND)
            moved.advance(DT, WIND, swaying(frame * DT))
        return np.abs(moved.positions - still.positions).max()

    assert apart(200) < min(1e-3, 0.75 * apart(100) + 2e-5)


def in_the_world(count, frames, air):
    """Return the nodes after steps in plain numpy, in the world, with the hoist taken along."""
    cloth, dt = Cloth(5, 7), DT / count
    forcing = Forcing(WIND, cloth.gravity, air)
    model, x, v = model_of(cloth), cloth.positions, cloth.velocities
    hoist = x[:, 0].copy()
    for frame in range(frames):
        way = PoleFrame(swaying(frame * DT)).moving_to(swaying((frame + 1) * DT), DT)
        for step in range(count):
            here, there = (way.after((step + end) * dt) for end in (0, 1))
            v[:, 0] = here.velocities_to_world(hoist, np.zeros_like(hoist))
            before = x, v
            x, v = take_step(x, v, model, forcing, dt)
            v[:, 0] = before[1][:, 0]
            kick = dt * moving_air.accelerations(model, forcing, *before, (v - before[1]) / dt, dt)
            x, v = x + dt * kick, v + kick
            x[:, 0] = there.to_world(hoist)
    return x


@pytest.mark.parametrize('solver, air', FIRM)
def test_agrees_with_steps_in_the_world(solver, air):
    """An independent program, with gravity, wind, drive, turn and pitch; each by its error."""
    close = {'symplectic': 2e-3, 'verlet': 4e-3, 'rk4': 4e-3, 'xpbd': 0.05}.get(solver, 0.08)
    cloth = Cloth(5, 7, solver=solver, stepping=stepped(200), air=air)
    for frame in range(1, 7):
        cloth.advance(DT, WIND, swaying(frame * DT))
    np.testing.assert_allclose(cloth.positions, in_the_world(200, 6, air), atol=close)


@pytest.mark.parametrize('solver, close', [
    ('symplectic', 1e-3), ('verlet', 1e-5), ('rk4', 1e-3), ('xpbd', 1e-3), ('implicit', 1e-3)])
def test_a_strip_that_turns_is_stretched_by_its_weight_outwards(solver, close):
    """
    In vacuum: k (r[i+1] - 2 r[i] + r[i-1]) = -m omega^2 r[i], the theory of a turning rod.

    It turns with the pole and neither lags behind nor runs ahead.
    """
    count, length, k, density, omega = 9, 2.0, 200.0, 0.2, 4.0
    spacing = length / (count - 1)
    m = np.full(count, density * spacing)
    m[-1] *= 0.5
    stiffness = k / spacing * (2.0 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    stiffness[-1, -1] = k / spacing
    pull = np.zeros(count)
    pull[-1] = k
    expected = np.zeros(count)
    expected[1:] = np.linalg.solve((stiffness - np.diag(m * omega**2))[1:, 1:], pull[1:])
    cloth = Cloth(2, count, length, 0.4, (0.0, 0.0, 1.0), gravity=0.0, air=VACUUM, solver=solver,
                  material=Material(stiffness=k, shear_stiffness=0.0, bend_stiffness=0.0,
                                    damping=0.3), start_noise=0.0, stepping=stepped(100))
    stretched = cloth.positions
    stretched[..., 0] = expected
    cloth.place(stretched, np.cross([0.0, 0.0, omega], stretched))
    for frame in range(1, 61):
        cloth.advance(DT, pose=rotate_z(omega * frame * DT))
    own = apply(np.linalg.inv(cloth.pose), cloth.positions)
    assert expected[-1] > 1.02 * length
    np.testing.assert_allclose(own[..., 0], np.broadcast_to(expected, (2, count)), atol=close)
    np.testing.assert_allclose(own[..., 1], 0.0, atol=close)


@pytest.mark.parametrize('solver', ['symplectic', 'verlet', 'rk4'])
def test_the_hoist_does_the_work(solver):
    """Without air, weight and damping the cloth's energy grows by what its hoist does to it."""
    cloth = Cloth(5, 7, gravity=0.0, air=VACUUM, solver=solver, material=Material(damping=0.0),
                  stepping=stepped(6))
    model, mass = model_of(cloth), cloth.mesh.grid(cloth.mesh.mass_share) * (
        cloth.material.area_density * cloth.mesh.dx * cloth.mesh.dy)

    def energy():
        return (0.5 * np.sum(mass[:, 1:, None] * cloth.velocities[:, 1:]**2)
                + elastic_energy(model, cloth.positions) + bending_energy(model, cloth.positions))

    def pull():
        return -forces(model, cloth.positions, cloth.velocities)[:, 0]

    start, work, dt = energy(), 0.0, 1e-3
    for frame in range(1, 201):
        before = cloth.positions[:, 0], pull()
        cloth.advance(dt, pose=swaying(frame * dt))
        work += 0.5 * np.sum((before[1] + pull()) * (cloth.positions[:, 0] - before[0]))
    assert work > 1.0
    assert energy() - start == pytest.approx(work, rel=0.01)


@pytest.mark.parametrize('solver, air', METHODS)
@pytest.mark.parametrize('pose, dt', [
    (lambda n: translate((180.0 * DT * (n % 2), 0.0, 0.0)), DT),
    (lambda n: rotate_z(3.0 * n), DT), (lambda n: rotate_z(3.0 * (n % 2)), DT),
    (lambda n: translate((n, 0.0, 0.0)) @ rotate_y(0.5 * (n % 2)), DT),
    (lambda n: rotate_z(0.09 * n), 1e-3)], ids=['shaken', 'spun', 'twisted', 'tilted', 'whirled'])
def test_stays_bounded_however_the_pole_moves(solver, air, pose, dt):
    """In reach of its hoist, which is where the pole is, and out of the pole."""
    cloth = Cloth(5, 9, pole=POLE, solver=solver, air=air)
    for n in range(1, 11):
        cloth.advance(dt, WIND, pose(n))
        assert not cloth.is_carried
        own = apply(np.linalg.inv(cloth.pose), cloth.positions)
        np.testing.assert_allclose(own[:, 0], cloth.mesh.rest(cloth.hoist_top)[:, 0], atol=1e-9)
        far = np.linalg.norm(own[:, 1:] - own[:, :1], axis=-1)
        assert (far <= 2.0 * cloth.mesh.dx * np.arange(1, 9) + 1e-6).all()
        assert np.isfinite(cloth.velocities).all()
        assert np.hypot(own[..., 0], own[..., 1]).min() > POLE[2] - 1e-9


@pytest.mark.parametrize('pose, dt', [
    (translate((1000.0, 0.0, 0.0)), DT), (rotate_z(1.0), 1e-3), (rotate_y(1.5), DT)],
    ids=['1 km in a frame', '1000 rad/s', 'felled'])
def test_what_is_too_fast_for_a_pole_takes_the_cloth_with_it(pose, dt):
    moved, still = (Cloth(5, 7, pole=POLE, gravity=0.0, air=VACUUM) for _ in range(2))
    for cloth in (moved, still):
        cloth.advance(DT)
    moved.advance(dt, pose=pose)
    still.advance(dt)
    assert moved.is_carried
    np.testing.assert_allclose(moved.positions, apply(pose, still.positions), atol=1e-9)
    moved.advance(DT, pose=pose)
    assert not moved.is_carried


@pytest.mark.parametrize('pose, words', [
    (np.eye(3), 'must have shape'), (np.full((4, 4), math.nan), 'must be finite'),
    (2.0 * np.eye(4), 'a turn and a shift alone'), (np.diag([1.0, 1.0, -1.0, 1.0]), 'a turn and'),
    (translate((1e7, 0.0, 0.0)), 'at most 1e'), ('east', 'must hold numbers')], ids=str)
def test_what_is_no_pose_is_refused(pose, words):
    cloth = Cloth(3, 3)
    for use in (lambda: cloth.advance(DT, pose=pose), lambda: setattr(cloth, 'pose', pose)):
        with pytest.raises(ValueError, match=f'pose .*{words}'):
            use()
    assert np.array_equal(cloth.pose, np.eye(4)) and not cloth.velocities.any()


def test_a_pole_that_stands_costs_no_byte():
    """Whether its pose is told with every frame, or never."""
    told, untold = (Cloth(7, 9, pole=POLE) for _ in range(2))
    for _ in range(5):
        told.advance(DT, WIND, np.eye(4))
        untold.advance(DT, WIND)
    assert np.array_equal(told.positions, untold.positions)
    assert np.array_equal(told.velocities, untold.velocities)


@pytest.mark.parametrize('solver, air', METHODS)
def test_threads_change_no_byte(solver, air):
    one, three = (Cloth(9, 13, pole=POLE, solver=solver, air=air, threads=k) for k in (1, 3))
    for frame in range(1, 7):
        for cloth in (one, three):
            cloth.advance(DT, WIND, swaying(frame * DT))
    assert np.array_equal(one.positions, three.positions)
    assert np.array_equal(one.velocities, three.velocities)


def test_the_law_of_the_source_knows_no_motion():
    """Equation 1.3 as published: the wind, whatever moves in it."""
    law = Air(law='seed')
    still, driven = (Cloth(5, 7, air=law, gravity=0.0, pinned=False) for _ in range(2))
    still.advance(DT, WIND)
    driven.advance(DT, WIND, translate((1.0, 0.0, 0.0)))
    np.testing.assert_allclose(driven.positions, still.positions, atol=1e-9)


def test_changes_of_the_grid_keep_the_motion_with_the_pole():
    cloth = Cloth(7, 9, pole=POLE)
    for frame in range(1, 7):
        cloth.advance(DT, WIND, swaying(frame * DT))
    corners = cloth.positions[[0, -1]][:, [0, -1]], cloth.velocities[[0, -1]][:, [0, -1]]
    cloth.regrid(9, 13)
    cloth.precision = 'float32'
    assert np.allclose(corners[0], cloth.positions[[0, -1]][:, [0, -1]], atol=0.01)
    assert np.allclose(corners[1], cloth.velocities[[0, -1]][:, [0, -1]], atol=0.5)
    cloth.reset()
    assert np.array_equal(cloth.pose, swaying(6 * DT)) and not cloth.velocities.any()
    np.testing.assert_allclose(
        cloth.positions, apply(cloth.pose, cloth.mesh.rest(cloth.hoist_top)), atol=1e-3)


@pytest.mark.parametrize('angle', [0.0, 1e-9, 0.5, 2.0, 3.0, math.pi - 1e-7, math.pi])
def test_the_turn_between_two_poses_leads_from_one_to_the_other(angle):
    rng = np.random.default_rng(3)
    for _ in range(5):
        axis = rng.normal(size=3)
        before = rotation(rng.normal(size=3))
        after = before @ rotation(angle * axis / np.linalg.norm(axis))
        turn = turn_between(before, after)
        assert np.linalg.norm(turn) == pytest.approx(angle, abs=1e-7)
        np.testing.assert_allclose(before @ rotation(turn), after, atol=1e-7)
