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

"""The physics node given what is wrong: it refuses it, or leaves it out, and frames go on."""
import math

from flag_sim.cloth import Cloth
from flag_sim.declarations.physics import PHYSICS
from flag_sim.nodes.physics import Physics
from flag_sim.protocol.frames import FrameId
from flag_sim.ros.diagnostics import ERROR, OK
from flag_sim.ros.parameter_node import BadParameter, to_parameter
import numpy as np
import pytest
import rclpy
from support.bench import COUNT, FRAME, library, play, WIND
from support.frames import parameters_message


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


def test_a_new_reason_to_refuse_is_told_at_once(bench, capfd):
    """However soon after another one; the same again, with another value, is not."""
    for keyed in ({'gravity': -1.0}, {'solver': 'magic'}, {'gravity': -2.0}, {'gravity': 'down'}):
        bench.frame(0.0, keyed={f'physics.{name}': value for name, value in keyed.items()})
    said = capfd.readouterr().err
    assert [value in said for value in ('not -1.0', "not 'magic'", 'not -2.0', "not 'down'")] == [
        True, True, False, True]
