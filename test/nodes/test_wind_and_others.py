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

"""The wind among real nodes: whom it waits for, its clock, pauses, steps and resets."""
import re
import time

from flag_sim.ros.frame_message import read_parameters
from flag_sim.ros.messages import to_stamp
from std_msgs.msg import Empty, Header
from support.forked import Graph
from support.shot import film, messages_of, SHOT, SMALL, stamp_of
from support.watch import eventually, Watcher


def test_wind_says_whom_it_waits_for_and_goes_on(tmp_path, domain):
    """A consumer that dies in lockstep is named; its successor is served, and at full speed."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        graph.start('wind', *SHOT, '-p', 'wait_for:=[renderer, recorder]')
        eventually(lambda: len(done) > 5, watcher)
        assert graph.end('renderer') == 0
        eventually(lambda: 'renderer (no such node is running); sent again' in graph.log('wind'),
                   watcher)
        served = len(done)
        graph.start('renderer', *SMALL, name='successor')
        # More frames than are in flight: by then everybody has found the successor's topics.
        eventually(lambda: 6 < len({to_stamp(message.stamp) for message in done[served:]
                                    if message.frame_id == 'recorder'}), watcher)
        # A window that still waited for frames to be sent again would now wait for a minute.
        assert watcher.put(watcher.parameters_of('wind'), 'resend_after', 60.0).successful
        served = len(done)
        eventually(lambda: len(done) > served + 60, watcher, 50.0)
        assert graph.end('recorder') == 0
    stamps = [time for time, _ in messages_of(tmp_path / 'bag', '/camera/image_raw')]
    assert len(stamps) > 15
    assert stamps == [round(n * 1e9 / 30.0) for n in range(len(stamps))]


def test_reset_pause_and_keyframes(tmp_path, domain):
    """Keys are announced once a take, a reset begins again, and a pause sends nothing."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        sent, keys = watcher.listen('parameters'), watcher.listen('keyframe')
        reset, step = map(watcher.publisher, ('reset', 'step'))
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('wind', *SHOT, '-p', 'paused:=true')
        client = watcher.parameters_of('wind', reset, step)
        graph.wait_ready('renderer')
        watcher.spin(0.5)
        assert not sent
        assert watcher.put(client, 'paused', False).successful
        eventually(lambda: len(keys) >= 4, watcher)
        assert watcher.put(client, 'paused', True).successful
        announced = [(to_stamp(key.stamp), key.frame_id) for key in keys]
        assert announced == [(0, 'physics.stiffness'), (0, 'renderer.sun.elevation'),
                             (500_000_000, 'physics.stiffness'),
                             (1_000_000_000, 'renderer.sun.elevation')]

        def frames():
            """Return [(take, index)] of the frames that were sent, those sent again too."""
            return [(one.take, one.index) for one, _, _ in map(read_parameters, sent)]
        (before,) = {take for take, _ in frames()}
        reset.publish(Empty())
        eventually(lambda: 'reset' in graph.log('wind'), watcher)
        watcher.spin(0.2)
        assert {take for take, _ in frames()} == {before}
        step.publish(Empty())
        eventually(lambda: frames()[-1][0] != before, watcher)
        take, index = frames()[-1]
        assert take > before and index == 0
        assert watcher.put(client, 'paused', False).successful
        eventually(lambda: len(keys) >= 8, watcher)
        assert [(to_stamp(key.stamp), key.frame_id) for key in keys][4:8] == announced


def test_missed_frames_are_reported_at_the_rate_at_which_they_were_missed(tmp_path, domain):
    """A lower rate that is set because of the report does not stand in the next one."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        sent = watcher.listen('parameters')
        step, done = map(watcher.publisher, ('step', 'frame_done'))
        graph.start('wind', '-p', 'rate:=50.0', '-p', 'wait_for:=[slow]', '-p', 'paused:=true')
        client = watcher.parameters_of('wind', step, done)
        step.publish(Empty())
        eventually(lambda: sent, watcher)
        # Once it has answered, what it does not answer is missed.
        done.publish(Header(stamp=sent[0].stamp, frame_id='slow'))
        assert watcher.put(client, 'paused', False).successful
        eventually(lambda: read_parameters(sent[-1])[0].index > 20, watcher)
        assert watcher.put(client, 'rate', 7.0).successful

        def told():  # a busy machine misses frames of its own
            return [line for line in graph.log('wind').splitlines()
                    if 'were missed' in line and 'not done in time by slow' in line]
        eventually(told, watcher)
        assert 'missed at 50 Hz' in told()[0]


def test_single_steps(tmp_path, domain):
    """While paused, every `step` is one frame."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        winds, step = watcher.listen('wind'), watcher.publisher('step')
        graph.start('wind', '-p', 'paused:=true', '-p', 'wait_for:=[]')
        watcher.parameters_of('wind', step)  # now it hears each step
        for count in (1, 1, 5):
            told = len(winds) + count
            for _ in range(count):
                step.publish(Empty())
            eventually(lambda: len(winds) >= told, watcher)
        watcher.spin(0.2)
        assert [to_stamp(message.header.stamp) for message in winds] == [
            round(n * 1e9 / 30) for n in range(7)]


def test_real_time_keeps_to_the_clock(tmp_path, domain):
    """No frame is early, stamps are n / rate on every topic, and the shot ends with status 0."""
    frames, rate = 100, 50.0
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        wind, clock = watcher.listen('wind'), watcher.listen('/clock')
        graph.start('wind', '-p', f'rate:={rate}', '-p', f'frames:={frames}', '-p',
                    'publish_clock:=true', '-p', 'wait_for:=[]', '-p', 'paused:=true')
        client, begin = watcher.parameters_of('wind'), time.monotonic()
        assert watcher.put(client, 'paused', False).successful
        eventually(lambda: graph.processes['wind'].poll() is not None, watcher)
        # A frame is sent from half a period before it on.
        assert time.monotonic() - begin >= (frames - 1.5) / rate
        assert graph.processes['wind'].poll() == 0, graph.log('wind')
        (missed,) = re.findall(rf'over: {frames} frames, 0 sent again, (\d+) missed',
                               graph.log('wind'))

        def heard():
            return ([to_stamp(message.header.stamp) for message in wind],
                    [to_stamp(message.clock) for message in clock])
        # The latest is kept for who is slow to read, of each topic.
        eventually(lambda: all(heard()) and heard()[0][-1] == heard()[1][-1], watcher)
    # A busy machine may miss some, and its queues may lose others (all of them: test_wind).
    for one in heard():
        assert len(one) <= frames - int(missed)
        assert all(stamp % 20_000_000 == 0 for stamp in one)
        assert sorted(set(one)) == one and one[-1] <= (frames - 1) * 20_000_000


def test_stamps_by_the_wall_clock_match_those_of_sensors(tmp_path, domain):
    """Every topic of a frame has one stamp, which another clock of this machine agrees with."""
    begin = time.time_ns()
    with Graph(tmp_path / 'log', domain) as graph:
        assert film(graph, tmp_path / 'bag', 10, extra={
            'wind': ['-p', 'stamp.clock:=wall', '-p', 'pace:=lockstep']}) == 0, graph.log('wind')
    end = time.time_ns() + 10**9 * 10 // 30  # lockstep may be faster than the shot
    images, infos, clouds = (
        [(at, stamp_of(message)) for at, message in messages_of(tmp_path / 'bag', topic)]
        for topic in ('/camera/image_raw', '/camera/camera_info', '/vertices'))
    assert images == infos == clouds and len(images) == 10
    assert all(begin < at == stamp < end for at, stamp in images)
    first = images[0][0]
    assert [at - first for at, _ in images] == [round(n * 1e9 / 30.0) for n in range(10)]
