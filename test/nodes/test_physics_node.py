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

"""The physics node given what is wrong, time that jumps, new values: it refuses or goes on."""
from dataclasses import replace
import itertools
import math
import os
import types

from flag_sim.cloth import Cloth
from flag_sim.declarations.physics import PHYSICS
from flag_sim.drawing.transforms import rotate_z, translate
from flag_sim.nodes import physics
from flag_sim.nodes.physics import Physics
from flag_sim.nodes.renderer import Renderer
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from flag_sim.ros.diagnostics import ERROR, OK
from flag_sim.ros.parameter_node import BadParameter, to_parameter
import numpy as np
import pytest
import rclpy
from support.bench import Bench, WIND
from support.frames import parameters_message

FRAME = 1.0 / 30.0
COUNT = 12


def advance(cloth, n):
    """Move a cloth of the library to frame n; stamps are whole nanoseconds."""
    cloth.advance((round(n * FRAME * 1e9) - round((n - 1) * FRAME * 1e9)) * 1e-9, WIND)


def library(frames, cloth=None):
    """Return the positions after so many frames by the library alone, as the node sends them."""
    cloth = cloth or Cloth()
    for n in range(1, frames):
        advance(cloth, n)
    return cloth.positions.astype(np.float32)


def play(bench, frames, start=0):
    """Play frames of a thirtieth of a second; return the last one's positions."""
    for n in range(start, start + frames):
        positions = bench.frame(n * FRAME)
    return positions


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


@pytest.mark.parametrize('wind', [
    [], [1.0, 2.0], [1.0, 2.0, 3.0, 4.0], [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0],
    [0.0, 0.0, -1e5], ['a', 'b', 'c']], ids=str)
def test_an_invalid_wind_is_refused_and_the_next_frame_served(bench, capfd, wind):
    """Of a wrong length, not finite, or beyond all bounds; the good frames are as without it."""
    play(bench, 6)
    message = bench.message(6 * FRAME)
    bad = parameters_message('/wind', FrameId(0, 1, 6, 6), [0.0] * 3, {})
    next(p for p in bad.changed_parameters if p.name == 'wind').value = \
        to_parameter('wind', wind, float).to_parameter_msg().value
    assert bench.hear(bad) is None
    assert 'a message on parameters is refused: wind must be' in capfd.readouterr().err
    bench.hear(message)
    assert np.array_equal(play(bench, COUNT - 7, 7), library(COUNT))


@pytest.mark.parametrize('keyed, rule', [
    ({'area_density': 0.0}, 'area_density must be a number from 1.0e-06'),
    ({'area_density': -1.0}, 'not -1.0'),
    ({'stiffness': float('nan')}, 'not nan'),
    ({'gravity': float('inf')}, 'not inf'),
    ({'grid.rows': 1}, 'grid.rows must be a whole number from 2'),
    ({'grid.columns': 10**9}, 'not 1000000000'),
    ({'grid.columns': 100000, 'grid.rows': 100000}, 'not 100000'),
    ({'grid.rows': 5.0}, 'not 5.0'),
    ({'solver': 'magic'}, "not 'magic'"),
    ({'stiffness': 'soft'}, "not 'soft'"),
    ({'colour': 3.0}, "no parameter 'colour'")], ids=str)
def test_an_invalid_keyed_value_is_refused_and_the_next_frame_served(bench, capfd, keyed, rule):
    """The whole message is refused, with the rule and the value, and can be sent again right."""
    play(bench, 6)
    right = bench.message(6 * FRAME)
    wrong = parameters_message(
        '/wind', FrameId(0, 1, 6, 6), WIND, {f'physics.{name}': v for name, v in keyed.items()})
    assert bench.hear(wrong) is None
    said = capfd.readouterr().err
    assert 'a message on parameters is refused' in said and rule in said
    bench.hear(right)
    assert np.array_equal(play(bench, COUNT - 7, 7), library(COUNT))


@pytest.mark.parametrize('keyed, rule', [
    ({'flag.length': 1e-5}, 'flag.length must be 0 or a number from 0.001 to 100 [m], not 1e-05'),
    ({'pole.diameter': 9.0}, 'pole.diameter 9 m must be less than pole.height 9 m'),
    ({'air.added_mass': 0.5, 'solver': 'verlet'}, 'air.added_mass above 0 needs solver symplectic')
], ids=str)
def test_keyed_values_that_cannot_stand_together_are_left_out_and_frames_go_on(
        bench, capfd, keyed, rule):
    """The frame is answered, or lockstep would send it forever; said once, shown in `state`."""
    wrong = {f'physics.{name}': value for name, value in keyed.items()}
    assert bench.frame(0.0, keyed=wrong) is not None
    for n in range(1, 6):
        bench.frame(n * FRAME, keyed=wrong)
    said = capfd.readouterr().err
    told = f'keyed values are refused, the frame keeps those of the one before: {rule}'
    assert said.count(told) == 1
    level, message, _ = bench.node._status()
    assert level == ERROR and rule in message
    assert np.array_equal(play(bench, COUNT - 6, 6), library(COUNT))
    assert bench.node._status()[0] == OK


def test_a_frame_whose_values_cannot_stand_together_keeps_those_of_the_frame_before(bench):
    """Not those of the parameters, from which it would jump back."""
    cloth = Cloth()
    cloth.gravity = 3.0
    for n, diameter in enumerate((0.1, 0.1, 9.5, 9.5)):
        positions = bench.frame(
            n * FRAME, keyed={'physics.gravity': 3.0, 'physics.pole.diameter': diameter})
    assert np.array_equal(positions, library(4, cloth))


def test_nan_and_infinite_numbers_are_refused(bench, capfd):
    """Each parameter of the node that is a number refuses NaN and infinity, set and keyed."""
    numbers = [declaration.name for declaration in PHYSICS
               if type(declaration.default) in (int, float) and not declaration.fixed]
    assert len(numbers) > 20
    for name in numbers:
        for value in (math.nan, math.inf, -math.inf):
            result = bench.put(**{name: value})
            assert not result.successful
            assert name in result.reason and f'not {value}' in result.reason
            assert bench.frame(0.0, keyed={f'physics.{name}': value}) is None
    assert np.array_equal(play(bench, COUNT), library(COUNT))


@pytest.mark.parametrize('arguments, rule', [
    ('area_density:=0.0',
     'area_density must be a number from 1.0e-06 to 1.0e+06 [kg/m2], not 0.0'),
    ('area_density:=-0.2', 'not -0.2'),
    ('stiffness:=.nan', 'not nan'),
    ('damping:=.inf', 'not inf'),
    ('grid.rows:=1', 'grid.rows must be a whole number from 2 to 1001 [nodes], not 1'),
    ('grid.columns:=1000000000', 'not 1000000000'),
    ('flag.length:=1e-5', 'flag.length must be 0 or a number from 0.001 to 100 [m], not 1e-05'),
    ('solver:=magic', "not 'magic'")])
def test_a_bad_start_is_refused(domain, arguments, rule):
    """The process then ends with one line; test_parameters has that for every node."""
    with rclpy.init(args=['--ros-args', '-p', arguments], domain_id=domain):
        with pytest.raises(BadParameter) as error:
            Physics()
    assert rule in str(error.value)


def test_time_that_stands_still_moves_nothing(bench):
    """The frame is answered with its stamp, and the cloth goes on from there."""
    before = play(bench, 6)
    assert np.array_equal(bench.frame(5 * FRAME), before)
    assert np.array_equal(play(bench, COUNT - 6, 6), library(COUNT))


def test_a_gap_longer_than_max_gap_is_not_simulated(bench, capfd):
    """It is said, and the cloth stands still over it."""
    before = play(bench, 6)
    assert np.array_equal(bench.frame(1e9), before)
    said = capfd.readouterr().err
    assert 'more than max_gap = 1 s: it is not simulated; a greater max_gap' in said
    assert not np.array_equal(bench.frame(1e9 + FRAME), before)


def test_gaps_that_follow_one_another_are_told_once(bench, capfd):
    """Once in WARN_EVERY; a rate below 1 / max_gap would fill the log."""
    for n in range(10):
        bench.frame(2.0 * n)
    assert capfd.readouterr().err.count('more than max_gap') == 1


def test_a_take_that_is_joined_in_the_middle_is_told(bench, capfd):
    """As after a restart of the node; its film has a cloth at rest there. Once, not of frame 0."""
    play(bench, 2)
    assert 'joined' not in capfd.readouterr().err
    for index in (7, 8):
        bench.hear(parameters_message(
            '/wind', FrameId(round(index * FRAME * 1e9), 2, index, index), WIND, {}))
    assert capfd.readouterr().err.count(
        'joined the take at frame 7: the cloth begins at rest there; reset for a whole take') == 1


def test_the_longest_gap_that_can_be_allowed_is_simulated(bench):
    """An hour in one frame: softened, and in its bounds."""
    assert bench.put(max_gap=3600.0).successful
    play(bench, 6)
    assert np.isfinite(bench.frame(5 * FRAME + 3600.0)).all()


@pytest.mark.parametrize('take', [1, 2, None])
def test_time_that_jumps_back_lays_the_cloth_out_again(bench, take):
    """In the same take, in a new one, and typed by hand."""
    play(bench, COUNT)
    if take is None:
        for at in (10.0, 4.0):
            message = parameters_message('/hand', FrameId(0, 0, 0, 0), WIND, {})
            message.stamp = messages.to_time(round(at * 1e9))
            del message.changed_parameters[1:4]
            cloud = bench.hear(message)
    else:
        index = COUNT if take == 1 else 0
        cloud = bench.hear(parameters_message(
            '/wind', FrameId(100, take, index, index), WIND, {}))
    assert np.array_equal(messages.read_cloud(cloud)[0], library(1))


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


def test_a_gap_made_by_the_node_itself_is_not_blamed_on_others(bench, capfd, monkeypatch):
    """The node says what it was busy with; a gap that it did not make is not explained by it."""
    play(bench, 6)
    now = itertools.count(1000.0, 0.3)  # at the begin of a frame, and at its end
    monkeypatch.setattr(physics, 'time', types.SimpleNamespace(monotonic=lambda: next(now)))
    assert bench.put(max_gap=0.2).successful
    bench.frame(6 * FRAME)
    bench.frame(6 * FRAME + 0.4)
    said = capfd.readouterr().err
    assert '0.400 s between two frames is more than max_gap = 0.2 s: ' in said
    assert 'physics itself was busy for 0.3 s with the frame before' in said
    bench.frame(6 * FRAME + 5.0)
    said = capfd.readouterr().err
    assert 'more than max_gap' in said and 'busy' not in said


def test_a_new_reason_to_refuse_is_told_at_once(bench, capfd):
    """However soon after another one; the same again, with another value, is not."""
    for keyed in ({'gravity': -1.0}, {'solver': 'magic'}, {'gravity': -2.0}, {'gravity': 'down'}):
        bench.frame(0.0, keyed={f'physics.{name}': value for name, value in keyed.items()})
    said = capfd.readouterr().err
    assert [value in said for value in ('not -1.0', "not 'magic'", 'not -2.0', "not 'down'")] == [
        True, True, False, True]


def test_a_lower_stretch_limit_counts_at_once(bench):
    """In a frame in which time stands still, too."""
    play(bench, COUNT)
    assert bench.put(stretch_limit=0.0).successful
    positions = bench.frame((COUNT - 1) * FRAME)
    reach = np.linalg.norm(positions - positions[:, :1], axis=-1)
    # float32 metres, 9 m above the ground.
    assert np.all(reach <= 2.25 / 30 * np.arange(31) + 1e-6)
