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
from flag_sim.ros import messages
from flag_sim.ros.parameter_node import BadParameter
import numpy as np
import pytest
import rclpy
from std_msgs.msg import Empty
from support.wind_bench import WindBench as Bench


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


def test_frames_of_real_time_have_their_stamps_on_every_topic(domain):
    """All of them where the wind is in time, but for those that were due while it was not."""
    with Bench(domain, 'rate:=50.0', 'frames:=40', 'publish_clock:=true', 'wait_for:=[]') as bench:
        winds, clocks = [], []
        bench.node._wind_out.get_subscription_count = lambda: 1
        bench.node._wind_out.publish = lambda wind: winds.append(wind.header.stamp)
        bench.node._clock_out.publish = lambda message: clocks.append(message.clock)
        for frame in [*range(20), *range(25, 45)]:
            bench.node._send_due(1000.0 + frame / 50.0)
        assert [frame.index for frame, _ in bench.frames] == [*range(20), *range(25, 40)]
        stamps = [frame.stamp for frame, _ in bench.frames]
        assert stamps == [20_000_000 * frame.index for frame, _ in bench.frames]
        assert [*map(messages.to_stamp, winds)] == [*map(messages.to_stamp, clocks)] == stamps
        assert bench.node._missed.missed == 5


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


@pytest.mark.parametrize('pace, said', [
    ('realtime', 'realtime, served by renderer'),
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
