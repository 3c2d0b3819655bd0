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

"""Keys, events and directions as a wind node in this process takes them."""
from flag_sim.ros import messages
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterEvent, ParameterValue
from rclpy.parameter import Parameter
from support.wind_bench import WindBench as Bench


@pytest.mark.parametrize('autokey', ['false', 'true'])
def test_an_event_of_an_invalid_type_is_left_out(domain, autokey):
    """Anybody can publish one; the wind goes on, and hears the others of the same message."""
    with Bench(domain, 'paused:=true', f'autokey:={autokey}') as bench:
        bench.step()
        bench.hear('parameter_events', ParameterEvent(node='/physics', changed_parameters=[
            ParameterMessage(name='stiffness', value=ParameterValue(type=77)),
            ParameterMessage(name='gravity', value=ParameterValue(type=3, double_value=5.0))]))
        frame, _ = bench.step()
        assert frame.index == 1
        assert bench.node.values['tracks'] == (['physics.gravity'] if autokey == 'true' else [])


def test_a_limit_that_is_printed_can_be_set_and_is_the_limit(domain):
    """At the start and later; what is beyond it is refused with it."""
    with Bench(domain, 'paused:=true', 'azimuth:=6.28319', 'elevation:=-1.5708') as bench:
        assert bench.node.get_parameter('azimuth').value == 2.0 * np.pi
        assert bench.node.values['elevation'] == -np.pi / 2.0
        bench.put(azimuth=-6.28319, elevation=1.571)
        assert bench.node.get_parameter('elevation').value == np.pi / 2.0
        result = bench.node.set_parameters([Parameter('azimuth', value=6.3)])[0]
        assert 'from -6.28319 to 6.28319 [rad], not 6.3' in result.reason


SPIN = ('tracks:=[wind.azimuth]', 'keys.wind.azimuth.times:=[0.0, 4.0]',
        'keys.wind.azimuth.values:=[0.0, 6.28319]')


def test_a_direction_that_does_not_turn_as_typed_is_told_once(domain, capfd):
    """At the start or when it is set, until it is mended; then again if it comes back."""
    with Bench(domain, 'paused:=true', *SPIN) as bench:
        assert capfd.readouterr().err.count('keys.wind.azimuth.turns to true') == 1
        bench.put(speed=7.0)
        bench.put(keys__wind__azimuth__times=[0.0, 5.0])
        bench.put(keys__wind__azimuth__turns=True)
        assert 'turns' not in capfd.readouterr().err
        bench.step(50)
        assert bench.step()[1][1] == pytest.approx(7.0 * np.sin(2.0 * np.pi / 3.0), abs=1e-4)
        bench.put(keys__wind__azimuth__turns=False)
        assert capfd.readouterr().err.count('keys.wind.azimuth.turns to true') == 1


def set_as_typed(bench, name, kind, value=None):
    """Set a parameter of whatever type `ros2 param` makes of it; return the result."""
    return bench.node.set_parameters([Parameter(name, kind, value)])[0]


@pytest.mark.parametrize('part, kind', [
    ('times', Parameter.Type.DOUBLE_ARRAY), ('values', Parameter.Type.DOUBLE_ARRAY),
    ('laws', Parameter.Type.STRING_ARRAY)])
@pytest.mark.parametrize('begin', ['start', 'set'])
def test_an_empty_list_of_keys_keeps_its_type(domain, part, kind, begin):
    """`ros2 param set` makes one of booleans of []; what was there can be set again."""
    given = {'keys.wind.azimuth.times': [0.0, 4.0], 'keys.wind.azimuth.values': [0.0, 1.0],
             'keys.wind.azimuth.laws': ['ease', 'step']}
    at_start = [f'{name}:=[{", ".join(map(str, value))}]' for name, value in given.items()]
    with Bench(domain, 'paused:=true', *(at_start if begin == 'start' else [])) as bench:
        bench.put(**{name.replace('.', '__'): value for name, value in given.items()})
        bench.put(tracks=['wind.azimuth'])
        assert set_as_typed(bench, 'tracks', Parameter.Type.BOOL_ARRAY, []).successful
        name = f'keys.wind.azimuth.{part}'
        for value in ([], given[name], []):
            kind_typed = kind if value else Parameter.Type.BOOL_ARRAY
            result = set_as_typed(bench, name, kind_typed, value)
            assert result.successful, result.reason
            assert bench.node.get_parameter(name).type_ is kind
            assert list(bench.node.get_parameter(name).value) == value
        if part == 'times':
            bench.put(keys__wind__azimuth__times=[0, 4])  # whole numbers
            assert bench.node.get_parameter(name).type_ is kind


@pytest.mark.parametrize('begin', ['start', 'set'])
def test_keys_of_a_removed_track_can_be_deleted(domain, begin):
    """As `ros2 param delete` does; those that are played, and the node's own, cannot."""
    track = (*SPIN, 'keys.wind.azimuth.turns:=true')
    with Bench(domain, 'paused:=true', *(track if begin == 'start' else [])) as bench:
        bench.put(keys__wind__azimuth__times=[0.0, 2.0], keys__wind__azimuth__values=[0.0, 3.0],
                  keys__wind__azimuth__turns=True, tracks=['wind.azimuth'])

        def delete(part):
            return set_as_typed(bench, part, Parameter.Type.NOT_SET)
        for name, said in (('keys.wind.azimuth.times', 'needs keys.wind.azimuth.times'),
                           ('tracks', 'tracks cannot be deleted: /wind always has it'),
                           ('keys.wind.speed.times', "no parameter 'keys.wind.speed.times'"),
                           ('sped', "the nearest known one is 'speed'")):
            result = delete(name)
            assert not result.successful and said in result.reason
        assert delete('keys.wind.azimuth.turns').successful  # a track that is played needs none
        assert not bench.node.timeline.tracks['wind.azimuth'].turns
        assert set_as_typed(bench, 'tracks', Parameter.Type.STRING_ARRAY, []).successful
        for part in ('times', 'values'):
            name = f'keys.wind.azimuth.{part}'
            assert delete(name).successful
            assert name not in bench.node.values and not bench.node.has_parameter(name)
        bench.put(keys__wind__azimuth__times=[0.0], keys__wind__azimuth__values=[1.0],
                  tracks=['wind.azimuth'])


@pytest.mark.parametrize('rate', [24.0, 29.97, 30.0, 60.0])
@pytest.mark.parametrize('snap', ['false', 'true'])
@pytest.mark.parametrize('stamps', [
    'stamp.start:=0.0', 'stamp.start:=1796000000.5', 'stamp.clock:=wall'])
def test_a_keyframe_message_says_in_which_frame_it_counts(domain, rate, snap, stamps):
    """The first frame that is not before its stamp; with snap_keys it is the frame's own stamp."""
    times = [round(n / rate, 3) for n in range(1, 40)]
    speeds = [float(n) for n in range(1, 40)]
    with Bench(domain, 'paused:=true', f'rate:={rate}', f'snap_keys:={snap}', 'azimuth:=0.0',
               stamps, 'tracks:=[wind.speed]', f'keys.wind.speed.times:={times}',
               f'keys.wind.speed.values:={speeds}', f'loop:={snap}',
               f'keys.wind.speed.laws:=[{", ".join(["step"] * 39)}]') as bench:
        told = []
        bench.node._keyframe_out.publish = lambda key: told.append(key) or True
        bench.step(100)
        winds = {frame.stamp: wind[0] for frame, wind in bench.frames}
        stamps = sorted(winds)
        assert {message.frame_id for message in told} == {'wind.speed'}
        assert len(told) == (99 if snap == 'true' else 39)
        key_times = [messages.to_stamp(message.stamp) for message in told]
        frames = [next(stamp for stamp in stamps if stamp >= time) for time in key_times]
        assert snap == 'false' or frames == key_times
        # Of several keys in one frame the last one is seen.
        assert {frame: winds[frame] for frame in frames} == {
            frame: speeds[n % 39] for n, frame in enumerate(frames)}


def test_keys_that_would_snap_to_one_frame_refuse_a_lower_rate(domain):
    """The rate says where the frames are; what was set before stays."""
    with Bench(domain, 'paused:=true', 'snap_keys:=true', 'tracks:=[wind.speed]',
               'keys.wind.speed.times:=[0.5, 0.54]', 'keys.wind.speed.values:=[1.0, 2.0]'
               ) as bench:
        result = bench.node.set_parameters([Parameter('rate', value=10.0)])[0]
        assert not result.successful and 'one key a frame' in result.reason
        bench.put(snap_keys=False)
        bench.put(rate=10.0)
