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

"""The wind node in this process: resets, pauses and waiting, without a network."""
import time

from flag_sim.nodes.player import Player
from flag_sim.nodes.wind import Wind
from flag_sim.protocol.frames import Arrival, FrameOrder
from flag_sim.ros import frame_message, messages
from flag_sim.ros.parameter_node import BadParameter
import numpy as np
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterEvent, ParameterValue
import rclpy
from rclpy.parameter import Parameter
from std_msgs.msg import Empty
from support.nodes import hear


class Bench:
    """A wind, and what it sends; nothing is spun, every call is the whole of its work."""

    def __init__(self, domain, *arguments):
        given = [part for argument in arguments for part in ('-p', argument)]
        self._ros = rclpy.init(domain_id=domain, args=['--ros-args', *given])
        self.node = Wind()
        self.frames = []  # (frame, wind)
        publish = self.node._parameters_out.publish

        def keep(message):
            self.frames.append(frame_message.read_parameters(message)[:2])
            publish(message)
        self.node._parameters_out.publish = keep

    def hear(self, topic, message):
        """Let a message arrive."""
        hear(self.node, topic, message)

    def put(self, **values):
        """Set parameters as the service does."""
        result = self.node.set_parameters_atomically(
            [Parameter(name.replace('__', '.'), value=value) for name, value in values.items()])
        assert result.successful, result.reason

    def step(self, count=1):
        """Let it send single frames; return the last one's (frame, wind)."""
        for _ in range(count):
            self.hear('step', Empty())
        return self.frames[-1]

    def __enter__(self):
        """Return self."""
        return self

    def __exit__(self, *_):
        """End the node."""
        self.node.destroy_node()
        self._ros.__exit__(*_)


def test_a_reset_begins_a_later_take_although_the_wall_clock_was_set_back(domain, monkeypatch):
    """Else every node would take its frames for late copies."""
    order = FrameOrder()
    with Bench(domain, 'paused:=true') as bench:
        assert order.arrive(bench.step()[0], 'wind') is Arrival.RESTART
        monkeypatch.setattr(time, 'time_ns', lambda: 0)
        for _ in range(2):
            bench.hear('reset', Empty())
            assert order.arrive(bench.step()[0], 'wind') is Arrival.RESTART


def test_what_is_not_the_winds_own_changes_no_gust(domain):
    """A shot that was paused, and stepped through, has the wind of one that was not."""
    gusty = ('paused:=true', 'gust.intensity:=0.3', 'tracks:=[wind.speed]',
             'keys.wind.speed.times:=[0.0, 2.0]', 'keys.wind.speed.values:=[3.1, 12.7]')
    winds = []
    for disturbed in (False, True):
        with Bench(domain, *gusty) as bench:
            for _ in range(20):
                bench.step(3)
                if disturbed:
                    bench.put(paused=False)
                    bench.put(paused=True, resend_after=2.0)
            winds.append(np.array([wind for _, wind in bench.frames]))
    assert np.array_equal(*winds)
    assert np.ptp(winds[0][:, 2]) > 0.1  # there are gusts


def test_a_wrong_name_in_wait_for_can_be_mended_while_frames_wait(domain):
    """Lockstep goes on with those that are waited for then."""
    with Bench(domain, 'pace:=lockstep', 'wait_for:=[rendrer]') as bench:
        bench.node._on_timer()
        assert [frame.index for frame, _ in bench.frames] == [0]
        bench.put(wait_for=['renderer'])
        bench.hear('frame_done', messages.header(0, 'renderer'))
        assert [frame.index for frame, _ in bench.frames] == [0, 1, 2, 3]


def test_steps_in_lockstep_respect_the_window(domain):
    """They leave as frames are done; those that have not left end with the pause."""
    with Bench(domain, 'pace:=lockstep', 'paused:=true', 'window:=2') as bench:
        bench.step(20)
        sent = 1  # until somebody has answered
        for index in range(15):
            assert [frame.index for frame, _ in bench.frames] == list(range(sent))
            bench.hear('frame_done', messages.header(bench.frames[index][0].stamp, 'renderer'))
            sent = index + 3
        bench.put(paused=False)
        bench.put(paused=True)
        bench.hear('frame_done', messages.header(bench.frames[15][0].stamp, 'renderer'))
        assert len(bench.frames) == sent


def test_steps_in_real_time_keep_no_more_frames_than_the_window(domain):
    """Nobody answers them."""
    with Bench(domain, 'paused:=true', 'window:=3') as bench:
        bench.step(100)
        assert len(bench.frames) == 100 and len(bench.node._delivery) == 3


def test_a_reset_is_not_put_off_by_the_next_one(domain, monkeypatch):
    """Although a frame in flight is never done."""
    now = [1000.0]
    monkeypatch.setattr(time, 'monotonic', lambda: now[0])
    with Bench(domain, 'pace:=lockstep', 'resend_after:=1.0') as bench:
        bench.node._on_timer()
        for _ in range(3):
            bench.hear('reset', Empty())
            now[0] += 0.6
        bench.node._on_timer()
        assert [frame.index for frame, _ in bench.frames] == [0, 0]
        assert bench.frames[0][0].take < bench.frames[1][0].take


KEYED = ('gust.intensity:=0.3', 'loop:=true', 'tracks:=[wind.speed, physics.gravity]',
         'keys.wind.speed.times:=[0.0, 0.21]', 'keys.wind.speed.values:=[3.1, 12.7]',
         'keys.physics.gravity.times:=[0.1]', 'keys.physics.gravity.values:=[5.0]')


@pytest.mark.parametrize('stamps, begin', [
    ('stamp.start:=1796000000.5', 1_796_000_000_500_000_000), ('stamp.clock:=wall', None)])
def test_stamps_from_anywhere_change_nothing_but_stamps(domain, stamps, begin):
    """Keys, their announcement, gusts, loops and a reset: by the time of the take."""
    played = []
    for given in (), (stamps,):
        with Bench(domain, 'paused:=true', *KEYED, *given) as bench:
            crossed, before = [], time.time_ns()
            bench.node._keyframe_out.publish = lambda key: crossed.append(key) or True
            for _ in range(2):
                bench.step(30)
                origin = bench.frames[-30][0].stamp
                if not given or begin is not None:
                    assert origin == (begin if given else 0)
                else:
                    assert before <= origin <= time.time_ns()
                played.append((
                    [frame.stamp - origin for frame, _ in bench.frames[-30:]],
                    [wind.tolist() for _, wind in bench.frames[-30:]],
                    [(messages.to_stamp(key.stamp) - origin, key.frame_id) for key in crossed]))
                del crossed[:]
                bench.hear('reset', Empty())
    assert played[2:] == played[:2]
    assert len(played[0][2]) == 10


def test_after_a_pause_stamps_are_the_wall_clocks_again(domain, monkeypatch):
    """Single steps go on from frame to frame; what is keyed and the frames' count stand still."""
    wall = [1_796_000_000 * 10**9]
    monkeypatch.setattr(time, 'time_ns', lambda: wall[0])
    with Bench(domain, 'stamp.clock:=wall', 'rate:=50.0', 'paused:=true', 'wait_for:=[]') as bench:
        assert bench.step()[0].stamp == wall[0]
        wall[0] += 5 * 10**9
        assert bench.step()[0].stamp == wall[0] - 5 * 10**9 + 20_000_000
        bench.put(paused=False)
        bench.node._send_due(time.monotonic())
        frame, _ = bench.frames[-1]
        assert (frame.stamp, frame.index) == (wall[0], 2)
        assert bench.node.now() == pytest.approx(0.04)


def test_the_shot_ends_before_its_stamps_do(domain, capfd):
    """A message holds no more than 2**31 seconds."""
    with Bench(domain, 'stamp.start:=2e9', 'rate:=0.01', 'paused:=true', 'wait_for:=[]') as bench:
        bench.node._take.clock.index = 1_474_835
        bench.step(3)
        assert [frame.index for frame, _ in bench.frames] == [1_474_835, 1_474_836]
        bench.node._on_timer()
        assert bench.node.ended.result() == 0
        assert 'the next stamp is beyond 2147483648 s' in capfd.readouterr().err


@pytest.mark.parametrize('given, reason', [
    (['stamp.clock:=wall', 'stamp.start:=5.0'], 'stamp.start 5 s is only for stamp.clock simu'),
    (['stamp.clock:=gps'], "one of simulation, wall, not 'gps'"),
    (['stamp.start:=-1.0'], 'from 0 to 2.0e+09')])
def test_invalid_stamps_are_refused(domain, given, reason):
    """With the rule."""
    with pytest.raises(BadParameter) as refusal:
        with Bench(domain, *given):
            pass
    rclpy.try_shutdown()
    assert reason in str(refusal.value)


def test_frames_of_real_time_are_not_sent_again_by_lockstep(domain):
    """Their receivers were told that no node waits for them: they would begin another round."""
    with Bench(domain, 'resend_after:=0.05') as bench:
        for _ in range(3):
            bench.node._send_due(time.monotonic())
        bench.put(pace='lockstep')
        time.sleep(0.06)
        bench.node._on_timer()
        assert [frame.index for frame, _ in bench.frames] == sorted(
            {frame.index for frame, _ in bench.frames})


@pytest.mark.parametrize('node', [Wind, Player])
@pytest.mark.parametrize('name', ['wind', 'physics', 'player'])
def test_who_never_says_frame_done_is_refused_at_the_start(domain, node, name):
    """By the wind and the player alike, before the shot waits forever."""
    with rclpy.init(domain_id=domain, args=['--ros-args', '-p', f'wait_for:=[renderer, {name}]']):
        with pytest.raises(BadParameter, match=f'recorder or your own; {name} sends none'):
            node()


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


@pytest.mark.parametrize('pace, said', [
    ('realtime', 'realtime, sent at once, served by renderer'),
    ('lockstep', 'lockstep, waiting for renderer')])
def test_the_first_line_says_whether_frames_wait(domain, capfd, pace, said):
    """In real time they do not."""
    with Bench(domain, f'pace:={pace}'):
        assert said in capfd.readouterr().err


def test_a_wind_without_a_processor_names_who_is_still_starting(domain, capfd):
    """While others compile it gets no processor itself; that is not all that stands still."""
    with Bench(domain, 'resend_after:=0.05') as bench:
        bench.node._send_due(time.monotonic())
        time.sleep(0.2)
        bench.node._send_due(time.monotonic())
        bench.node._report()
        said = capfd.readouterr().err
        assert 'the machine was busy with other processes; still waiting for renderer (no such' \
            in said
