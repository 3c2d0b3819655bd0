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

"""The physics node moves the cloth as the library does, whatever changes between frames."""
from dataclasses import replace
import os

from flag_sim.cloth import Cloth
from flag_sim.drawing.transforms import rotate_z, translate
from flag_sim.nodes.physics import Physics
from flag_sim.nodes.renderer import Renderer
import numpy as np
import pytest
import rclpy
from support.bench import advance, Bench, COUNT, FRAME, library, play, WIND


def test_the_node_adds_nothing_to_the_library(bench):
    """A frame announces the state at its time: the first is the cloth at rest."""
    assert np.array_equal(play(bench, COUNT), library(COUNT))


def test_keys_of_the_scene_move_the_pole(bench):
    """The library's cloth on a pole that drives and turns."""
    cloth = Cloth()
    for n in range(4):
        pose = translate((0.1 * n, 1.0, 0.0)) @ rotate_z(0.05 * n)
        found = bench.frame(n * FRAME, keyed={
            'scene.pole.position': [0.1 * n, 1.0, 0.0], 'scene.pole.yaw': 0.05 * n})
        if n:
            dt = (round(n * FRAME * 1e9) - round((n - 1) * FRAME * 1e9)) * 1e-9
            cloth.advance(dt, WIND, pose)
        else:
            cloth.pose = pose
        np.testing.assert_allclose(found, cloth.positions, atol=1e-6)


@pytest.mark.parametrize('parameter, value, attribute', [
    ('stiffness', 300.0, 'material'), ('area_density', 0.5, 'material'), ('gravity', 3.0, None),
    ('air.drag_coefficient', 0.3, 'air'), ('solver', 'rk4', None), ('substeps', 300, 'stepping'),
    ('stretch_limit', 0.01, None), ('precision', 'float32', None)], ids=str)
@pytest.mark.parametrize('way', ['set', 'keyed'])
def test_a_parameter_that_changes_between_frames_counts_from_the_next(
        bench, parameter, value, attribute, way):
    """Whether a user sets it or a key does, the motion goes on just as the library's."""
    cloth = Cloth(pole=(0.0, 0.0, 0.05))
    library(6, cloth)
    name = parameter.split('.')[-1]
    part = replace(getattr(cloth, attribute), **{name: value}) if attribute else value
    setattr(cloth, attribute or name, part)
    play(bench, 6)
    if way == 'set':
        assert bench.put(**{parameter: value}).successful
    for n in range(6, COUNT):
        keyed = {f'physics.{parameter}': value} if way == 'keyed' else {}
        positions = bench.frame(n * FRAME, keyed=keyed)
        advance(cloth, n)
    assert np.array_equal(positions, cloth.positions.astype(np.float32))
    assert not np.array_equal(positions, library(COUNT))


def test_precision_goes_both_ways_without_a_jump(bench):
    """As the library's to the bit; and where only numbers are rounded, nothing moves."""
    cloth = Cloth(pole=(0.0, 0.0, 0.05))
    library(6, cloth)
    play(bench, 6)
    for n, precision in ((6, 'float32'), (9, 'float64')):
        assert bench.put(precision=precision).successful
        stood = cloth.positions
        still = bench.frame((n - 1) * FRAME + 1e-9)  # no time to move in
        cloth.precision = precision
        cloth.advance(1e-9, WIND)
        # Half a unit in the last place of 9 m in float32, by the cloth and by the message.
        assert np.abs(still - stood).max() <= 2 * 0.5 * np.spacing(np.float32(9.0))
        for k in range(n, n + 3):
            positions = bench.frame(k * FRAME)
            begin = (k - 1) * FRAME + (1e-9 if k == n else 0.0)
            cloth.advance((round(k * FRAME * 1e9) - round(begin * 1e9)) * 1e-9, WIND)
            assert np.array_equal(positions, cloth.positions.astype(np.float32))
    # Three frames in float32 leave a trace, and less than the tenth of a millimetre that the
    # parameter's effect tells of.
    assert 0.0 < np.abs(positions - library(COUNT)).max() < 1e-4


def test_threads_are_fixed_at_the_start_and_change_no_bit(domain):
    """Set while it runs they are refused, with the rule; given at the start, all is the same."""
    with rclpy.init(args=['--ros-args', '-p', 'threads:=2'], domain_id=domain):
        bench = Bench()
        positions = play(bench, COUNT)
        result = bench.put(threads=1)
        assert not result.successful
        assert result.reason == 'threads is fixed at the start of the node'
        assert bench.frame(COUNT * FRAME, keyed={'physics.threads': 1}) is None
        bench.close()
    assert np.array_equal(positions, library(COUNT))


@pytest.mark.parametrize('node', [Physics, Renderer])
@pytest.mark.parametrize('threads', [2, 3])
def test_threads_beyond_the_processors_are_warned_of(domain, capfd, monkeypatch, node, threads):
    """Once at the start, with both numbers: they take turns, and each frame waits for all."""
    monkeypatch.setattr(os, 'sched_getaffinity', lambda pid: {0, 1})
    with rclpy.init(args=['--ros-args', '-p', f'threads:={threads}'], domain_id=domain):
        node().destroy_node()
    said = capfd.readouterr().err
    warning = 'threads = 3 is more than this process has processors, 2: frames take longer'
    assert said.count(warning) == (threads > 2)
    assert said.count('is more than this process') == (threads > 2)


def test_a_lower_stretch_limit_counts_at_once(bench):
    """In a frame in which time stands still, too."""
    play(bench, COUNT)
    assert bench.put(stretch_limit=0.0).successful
    positions = bench.frame((COUNT - 1) * FRAME)
    reach = np.linalg.norm(positions - positions[:, :1], axis=-1)
    # float32 metres, 9 m above the ground.
    assert np.all(reach <= 2.25 / 30 * np.arange(31) + 1e-6)
