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

"""Random cloths far beyond any scene: they stay finite, within reach, and out of the pole."""
import dataclasses
import math
import os

from flag_sim.cloth import Air, Cloth, Diverged, Material, Stepping
from flag_sim.cloth.divergence import MAX_SPEED
from flag_sim.cloth.drag import DRAG_LAWS
from flag_sim.cloth.energy import bending_energy, elastic_energy, kinetic_energy
from flag_sim.cloth.mesh import PRECISIONS
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.turning import rotation
import numpy as np
import pytest
from support.flags import nearest

EXTREMES = int(os.environ.get('FLAG_SIM_EXTREMES', 100))
"""Random cloths per solver; the soak test asks for more."""

BOUNDED = [name for name in SOLVERS if name not in ('euler', 'seed')]
"""The methods that diverge in no material and no air."""


def random_parameters(rng, rows, columns, length, width):
    """Return a material and a division into steps from far beyond any scene."""
    def often_zero(low, high, chance):
        return 0.0 if rng.random() < chance else 10.0**rng.uniform(low, high)

    node_mass = 10.0**rng.uniform(-6.0, 3.0)
    density = node_mass / (length / (columns - 1) * width / (rows - 1))
    material = Material(
        min(max(density, 1e-6), 1e6),
        often_zero(0, 9, 0.1), often_zero(0, 9, 0.1), often_zero(-6, 4, 0.3),
        often_zero(-3, 3, 0.3), often_zero(-3, 3, 0.5))
    return material, Stepping(substeps_limit=int(rng.choice([1, 10, 100, 300])))


def random_air(rng):
    """Return air of any law, as thick and as rough as the node's parameters go and far thinner."""
    density, drag = 10.0**rng.uniform(-3.0, 3.0), 10.0**rng.uniform(-2.0, 2.0)
    return Air(density, drag, rng.choice(list(DRAG_LAWS)))


def random_air_along(rng):
    """Return air of any law of which some moves with the cloth."""
    return dataclasses.replace(random_air(rng), added_mass=rng.uniform(0.0, 1.0))


def random_wind(rng):
    """Return a wind of up to 200 m/s from any side."""
    wind = rng.normal(size=3)
    return wind * rng.uniform(0.0, 200.0) / np.linalg.norm(wind)


def reach(cloth):
    """Return the greatest distance of a node from its row's beginning, over that at rest."""
    reaches = np.linalg.norm(cloth.positions - cloth.positions[:, :1], axis=-1)[:, 1:]
    return np.max(reaches / (cloth.mesh.dx * np.arange(1, cloth.mesh.columns)))


def greatest_energy(cloth, dt, wind):
    """
    Return what the kinetic energy cannot exceed after a frame of dt [s], by theory [J].

    All energy U of the frame's beginning may become kinetic. The wind's power on a face is
    rho C_d / 2 A (W - v)^2 v, at most at v = W / 3; by the linear law rho C_d / 2 A (W - v) v, at
    most at v = W / 2. The area is that of a cloth stretched to its limit both ways. Weight's power
    is at most M g v <= g sqrt(2 M E). So dE/dt <= P + g sqrt(2 M E), and
    sqrt(E) <= sqrt(U + P t) + g t sqrt(M / 2). By eq. 1.3 as published there is no such P, but a
    force of at most 2 W newtons on a node, or 2 W over the node's mass more to g. Air that moves
    along gives at most rho / 2 L H W^3 more.
    """
    model = Model(cloth.mesh, cloth.material)
    energy = (kinetic_energy(model, cloth.velocities) + elastic_energy(model, cloth.positions)
              + bending_energy(model, cloth.positions))
    area = cloth.mesh.length * cloth.mesh.width
    speed, most, gravity = np.linalg.norm(wind), 0.0, cloth.gravity
    if cloth.air.law == 'quadratic':
        most = 4.0 / 27.0 * speed**3
    elif cloth.air.law == 'linear':
        most = 0.25 * speed**2
    else:
        gravity += 2.0 * speed / model.cell_mass
    power = cloth.air.drag * area * (1.0 + cloth.stretch_limit)**2 * most
    if cloth.air.added_mass > 0.0:
        power += 0.5 * cloth.air.density * area * speed**3
    fall = gravity * dt * math.sqrt(0.5 * cloth.material.area_density * area)
    return (math.sqrt(energy + power * dt) + fall)**2


def swapped(cloth):
    """
    Return how much kinetic energy symplectic steps may make of elastic energy.

    What they keep is v^2 + omega^2 x^2 - h omega^2 x v, between 1 -+ h omega / 2 of the true
    energy, with h omega at most step_safety sqrt(4 - 2 r) in air that takes r of a velocity.
    """
    half = 0.5 * cloth.stepping.step_safety * math.sqrt(4.0 - 2.0 * cloth.air.greatest_rate(1))
    return (1.0 + half) / (1.0 - half)


def rounded(cloth):
    """
    Return the part by which rounding lengthens the reach at most.

    A node's coordinates are rounded, to some units of the cloth's whole extent, and given out as
    float64 of its place in the world; nodes next to the hoist are only a spacing away from it.
    """
    mesh = cloth.mesh
    extent = mesh.width + (1.0 + cloth.stretch_limit) * mesh.length
    inside, outside = np.finfo(cloth.precision).eps, np.finfo('float64').eps
    return 4.0 * (inside * extent + outside * max(cloth.hoist_top)) / mesh.dx


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('solver', BOUNDED)
@pytest.mark.parametrize('part', range(10))
def test_random_extremes_stay_bounded(solver, part, precision):
    """
    Finite, within reach of the hoist, and no faster than wind and weight can make them.

    The parameters change twice on the way. A frame may be refused for its speed only where the
    letter of 1.3, which nothing weakens, can make a node so fast; it then leaves all as it
    was.
    """
    fly_extremes(part, solver, precision, random_air)


@pytest.mark.parametrize('part', range(10))
def test_random_extremes_with_air_that_moves_along_stay_bounded(part):
    """The same of the inertia of the air, whose power on the cloth is bounded."""
    fly_extremes(part, 'symplectic', PRECISIONS[part % 2], random_air_along)


@pytest.mark.parametrize('part', range(2))
def test_random_extremes_on_a_pole_that_moves_stay_bounded(part):
    """Driven, turned and felled at random, with air that moves along: finite and within reach."""
    rng = np.random.default_rng(100 + part)
    for _ in range(EXTREMES // 10):
        shape = rng.integers(2, 12), rng.integers(2, 20), *10.0**rng.uniform(-1.0, 1.0, 2)
        material, stepping = random_parameters(rng, *shape)
        law = rng.choice(['quadratic', 'linear'])  # the letter of 1.3 may fling a cloth away
        cloth = Cloth(*shape, material=material, stepping=stepping, stretch_limit=0.5,
                      air=dataclasses.replace(random_air_along(rng), law=law),
                      precision=PRECISIONS[part])
        dt, wind = 10.0**rng.uniform(-4.0, -1.0), random_wind(rng)
        for _ in range(6):
            pose = cloth.pose
            pose[:3, 3] += dt * random_wind(rng)
            pose[:3, :3] = pose[:3, :3] @ rotation(dt * random_wind(rng))
            cloth.advance(dt, wind, pose)
            assert np.isfinite(cloth.positions).all() and np.isfinite(cloth.velocities).all()
            assert reach(cloth) <= 1.5 * (1.0 + rounded(cloth))


def fly_extremes(part, solver, precision, air_of):
    """Fly a tenth of the random cloths, in random air; assert all that they promise."""
    rng = np.random.default_rng(part)
    for _ in range(EXTREMES // 10):
        shape = rng.integers(2, 22), rng.integers(2, 32), *10.0**rng.uniform(-1.0, 1.0, 2)
        material, stepping = random_parameters(rng, *shape)
        limit = rng.choice([0.1, 0.5, 1.0, 3.0])
        cloth = Cloth(*shape, material=material, air=air_of(rng), stepping=stepping,
                      solver=solver, stretch_limit=limit, precision=precision)
        dt, wind = 10.0**rng.uniform(-5.0, 0.0), random_wind(rng)
        for frame in range(9):
            if frame in (3, 6):
                cloth.material, cloth.stepping = random_parameters(rng, *shape)
                cloth.air, wind = air_of(rng), random_wind(rng)
            greatest = swapped(cloth) * greatest_energy(cloth, dt, wind)
            before = cloth.positions
            try:
                cloth.advance(dt, wind)
            except Diverged:
                lightest = 0.25 * Model(cloth.mesh, cloth.material).cell_mass
                assert cloth.air.law == 'seed' and 2.0 * greatest > lightest * MAX_SPEED**2
                assert np.array_equal(cloth.positions, before)
            assert np.isfinite(cloth.positions).all() and np.isfinite(cloth.velocities).all()
            assert reach(cloth) <= (1.0 + limit) * (1.0 + rounded(cloth))
            moved = kinetic_energy(Model(cloth.mesh, cloth.material), cloth.velocities)
            assert moved <= greatest


@pytest.mark.parametrize('solver', ['xpbd', 'implicit'])
@pytest.mark.parametrize('length', [1.5e-3, 1.5e-2])
def test_a_tiny_flag_streams_with_the_wind(length, solver):
    """
    Without a spike: where it weighs nothing beside the wind, it lies along it.

    Explicit methods would need a million steps a frame for so stiff a cloth, and soften it.
    """
    cloth = Cloth(11, 16, length=length, width=length / 1.5, solver=solver)
    for _ in range(30):
        cloth.advance(1.0 / 30.0, (5.0, 2.0, 0.0))
    end = (cloth.positions[:, -1] - cloth.positions[:, 0]) / length
    np.testing.assert_allclose(end[:, 1] / end[:, 0], 0.4, atol=0.03)
    np.testing.assert_allclose(np.hypot(end[:, 0], end[:, 1]), 1.0, atol=0.04)


@pytest.mark.parametrize('solver', SOLVERS)
def test_an_ordinary_flag_is_not_held_back(solver):
    """The limit on reach is for extremes: in a fresh wind no method at the defaults meets it."""
    cloth = Cloth(solver=solver)
    for _ in range(45):
        cloth.advance(1.0 / 30.0, (9.0, 3.0, 0.0))
        assert cloth.held == 0


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('solver', SOLVERS)
def test_the_reach_holds_whatever_pulls(solver, precision):
    """Without stiffness nothing else holds the cloth; what is held back no longer flies off."""
    cloth = Cloth(5, 7, solver=solver, stretch_limit=0.2, precision=precision,
                  material=Material(stiffness=0.0, shear_stiffness=0.0, bend_stiffness=0.0))
    held = 0
    for _ in range(60):
        cloth.advance(0.05, (30.0, 5.0, 0.0))
        held += cloth.held
        assert reach(cloth) <= 1.2 * (1.0 + rounded(cloth))
    assert held > 0


@pytest.mark.parametrize('precision', PRECISIONS)
@pytest.mark.parametrize('solver', SOLVERS)
def test_a_wind_that_turns_round_does_not_pull_the_cloth_through_the_pole(solver, precision):
    """With the pole given, no node ends a frame in it; without, some do."""
    def deepest(pole):
        cloth = Cloth(7, 15, hoist_top=(0.2, 0.0, 8.9), pole=pole, solver=solver,
                      precision=precision)
        depth = 0.0
        for _ in range(60):
            cloth.advance(1.0 / 30.0, (-8.0, 0.5, 0.0))
            radius = np.hypot(cloth.positions[:, 1:, 0], cloth.positions[:, 1:, 1])
            depth = max(depth, 0.2 - radius.min())
        return depth

    assert deepest((0.0, 0.0, 0.2)) < 10.0 * np.finfo(precision).eps
    assert deepest(None) > 0.05


@pytest.mark.parametrize('part', range(4))
def test_reach_and_pole_hold_together(part):
    """
    Any flag on a pole of any thickness, in a wind that turns: both hold after each frame.

    Not only nodes: no edge is in the pole. Also where the cloth is drawn back through the pole, or
    lies around it out of reach.
    """
    rng = np.random.default_rng(part)
    held = 0
    for _ in range(EXTREMES // 10):
        shape = rng.integers(2, 12), rng.integers(2, 16), *10.0**rng.uniform(-0.5, 0.5, 2)
        material, stepping = random_parameters(rng, *shape)
        limit, radius = rng.choice([0.0, 0.1, 1.0]), 10.0**rng.uniform(-1.5, 1.0)
        cloth = Cloth(*shape, hoist_top=(radius, 0.0, 8.9), pole=(0.0, 0.0, radius),
                      material=material, stepping=stepping, stretch_limit=limit)
        speed, turn = rng.uniform(1.0, 100.0), rng.uniform(0.2, 3.0)
        for frame in range(15):
            cloth.advance(0.04, (speed * math.cos(turn * frame), speed * math.sin(turn * frame),
                                 rng.normal()))
            held += cloth.held
            assert reach(cloth) <= (1.0 + limit) * (1.0 + 1e-9)
            assert nearest(cloth.positions) >= radius * (1.0 - 1e-12)
    assert held > 100
