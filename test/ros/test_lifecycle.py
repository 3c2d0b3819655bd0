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

"""How nodes end, and what they do while others are missing or tell them what to do."""
import importlib
import platform
import resource
import signal
import subprocess
import sys
import time

from builtin_interfaces.msg import Time
from flag_sim.declarations.nodes import NODES
from flag_sim.ros.bag import Bag
from flag_sim.ros.messages import to_stamp
from flag_sim.tools.graph import Graph
from geometry_msgs.msg import Vector3Stamped
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.clock import ClockType
from std_msgs.msg import Empty, Header
from support.shot import film, messages_of, SHOT, SMALL, stamp_of
from support.watch import eventually, Watcher
import yaml

ENDS = (signal.SIGINT, signal.SIGTERM)


@pytest.mark.parametrize('number', ENDS)
def test_signals_end_every_node_cleanly(tmp_path, domain, number):
    """INT and TERM in the middle of a shot: status 0, no traceback, and the bag is readable."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        graph.start('wind', *SHOT, '-p', 'wait_for:=[recorder]')
        eventually(lambda: len({to_stamp(m.stamp) for m in done if m.frame_id == 'recorder'})
                   > 20, watcher)
        for process in graph.processes.values():
            process.send_signal(number)
        for name in graph.processes:
            assert graph.wait(name, 60.0) == 0, graph.log(name)
            assert 'Traceback' not in graph.log(name) and 'rror' not in graph.log(name)
    images = messages_of(tmp_path / 'bag', '/camera/image_raw')
    assert len(images) > 10
    assert [time for time, _ in images] == [round(n * 1e9 / 30.0) for n in range(len(images))]


@pytest.mark.parametrize('clock', ['true', 'false'])
def test_the_simulations_time_stops_no_node(tmp_path, domain, clock):
    """With use_sim_time everywhere, whether or not somebody publishes it, the shot ends."""
    simulated = ['-p', 'use_sim_time:=true']
    with Graph(tmp_path / 'log', domain) as graph:
        extra = {node: list(simulated) for node in ('physics', 'renderer', 'recorder', 'wind')}
        extra['wind'] += ['-p', f'publish_clock:={clock}']
        assert film(graph, tmp_path / 'bag', 10, extra=extra) == 0, graph.log('wind')
        assert graph.processes['recorder'].poll() == 0, graph.log('recorder')
    assert len(messages_of(tmp_path / 'bag', '/camera/image_raw')) == 10


@pytest.mark.parametrize('name', NODES)
def test_what_is_about_the_real_world_goes_by_a_steady_clock(tmp_path, domain, name):
    """All timers of all nodes: frames come as messages."""
    module = importlib.import_module(f'flag_sim.nodes.{name}')
    bag = Bag(tmp_path / 'bag', 'mcap', 'none')
    bag.add_topic('/parameters', ParameterEvent)
    bag.close()
    path = tmp_path / ('bag' if name == 'player' else 'new')
    with rclpy.init(domain_id=domain, args=['--ros-args', '-p', 'use_sim_time:=true',
                                            '-p', f'path:={path}', '-p', 'frames:=1']):
        node = getattr(module, name.capitalize())()
        node.create_timer(1.0, lambda: None)
        assert {timer.clock.clock_type for timer in node.timers} == {ClockType.STEADY_TIME}
        node.close()
        node.destroy_node()


def test_a_recorder_overwrites_nothing(tmp_path, domain):
    """A path that exists is refused and stays as it was."""
    (tmp_path / 'bag').mkdir()
    (tmp_path / 'bag' / 'precious').write_text('kept')
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        assert graph.wait('recorder', 30.0) == 1
        assert 'exists already' in graph.log('recorder')
    assert [path.name for path in (tmp_path / 'bag').iterdir()] == ['precious']


def test_a_full_disk_ends_the_recording_with_a_clear_error(tmp_path, domain):
    """A file that may not grow stands for the full disk; status 1, and the reason is said."""
    limit = 3_000_000  # bytes; an image has 57,600
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('physics')
        graph.start('renderer', *SMALL)
        recorder = graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        resource.prlimit(recorder.pid, resource.RLIMIT_FSIZE, (limit, hard))
        graph.start('wind', *SHOT, '-p', 'wait_for:=[renderer]')
        assert graph.wait('recorder', 60.0) == 1, graph.log('recorder')
        assert 'cannot write' in graph.log('recorder')
        assert 'File too large' in graph.log('recorder')
        assert 'Traceback' not in graph.log('recorder')


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
        done, keys = watcher.listen('frame_done'), watcher.listen('keyframe')
        reset = watcher.publisher('reset')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('wind', *SHOT, '-p', 'paused:=true')
        client = watcher.parameters_of('wind')
        watcher.spin(0.5)
        assert not done
        assert watcher.put(client, 'paused', False).successful
        eventually(lambda: len(keys) >= 4, watcher)
        assert watcher.put(client, 'paused', True).successful
        for _ in range(20):
            watcher.spin()
        announced = [(to_stamp(key.stamp), key.frame_id) for key in keys]
        assert announced == [(0, 'physics.stiffness'), (0, 'renderer.sun.elevation'),
                             (500_000_000, 'physics.stiffness'),
                             (1_000_000_000, 'renderer.sun.elevation')]
        before = len(done)
        reset.publish(Empty())
        eventually(lambda: 'reset' in graph.log('wind'), watcher)
        assert len(done) == before
        watcher.put(client, 'paused', False)
        eventually(lambda: len(keys) >= 8, watcher)
        assert [(to_stamp(key.stamp), key.frame_id) for key in keys][4:8] == announced
        assert to_stamp(done[before].stamp) == 0


def test_missed_frames_are_reported_at_the_rate_at_which_they_were_missed(tmp_path, domain):
    """A lower rate that is set because of the report does not stand in the next one."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        sent, done = watcher.listen('parameters'), watcher.publisher('frame_done')
        graph.start('wind', '-p', 'rate:=50.0', '-p', 'wait_for:=[slow]')
        client = watcher.parameters_of('wind')
        eventually(lambda: sent and done.get_subscription_count(), watcher)
        for _ in range(20):  # once it has answered, what it does not answer is missed
            done.publish(Header(stamp=sent[-1].stamp, frame_id='slow'))
            watcher.spin(0.02)
        for _ in range(10):
            watcher.spin(0.02)
        assert watcher.put(client, 'rate', 7.0).successful

        def told():  # a busy machine misses frames of its own
            return [line for line in graph.log('wind').splitlines()
                    if 'were missed' in line and 'not done in time by slow' in line]
        eventually(told, watcher)
        assert 'missed at 50 Hz' in told()[0]


def test_a_second_take_in_a_bag_is_told_once(tmp_path, domain):
    """A bag with two takes plays both; who reset the wind by mistake must know."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done, reset = watcher.listen('frame_done'), watcher.publisher('reset')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}')
        graph.start('wind', *SHOT, '-p', 'wait_for:=[renderer, recorder]')
        for takes in (0, 1, 2):
            del done[:]  # some of the take before may still come
            eventually(lambda: len(done) > 20 and graph.log('recorder').count(
                'another take begins') >= takes, watcher)
            assert graph.log('recorder').count('another take begins') == takes
            eventually(reset.get_subscription_count, watcher)
            reset.publish(Empty())
        assert graph.end('recorder') == 0
        assert '3 takes' in graph.log('recorder')


def test_a_recorder_survives_an_invalid_stamp(tmp_path, domain):
    """A message typed with a time before 0 is told of and left out; the next one is recorded."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        out, done = watcher.publisher('keyframe'), watcher.listen('frame_done')
        wind = watcher.publisher('wind')
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[keyframe, wind]')

        def send():
            out.publish(Header(stamp=Time(sec=-5)))
            wind.publish(Vector3Stamped(header=Header(stamp=Time(sec=1))))
        eventually(lambda: send() or 'its stamp -5.0 s is before 0' in graph.log('recorder')
                   and done, watcher)
        assert graph.end('recorder') == 0, graph.log('recorder')
    assert not messages_of(tmp_path / 'bag', '/keyframe')
    assert [time for time, _ in messages_of(tmp_path / 'bag', '/wind')] == [10**9]


def test_single_steps(tmp_path, domain):
    """While paused, every `step` is one frame."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        winds, step = watcher.listen('wind'), watcher.publisher('step')
        graph.start('wind', '-p', 'paused:=true', '-p', 'wait_for:=[]')
        eventually(lambda: step.publish(Empty()) or winds, watcher)
        begin = len(winds)
        for _ in range(5):
            step.publish(Empty())
        eventually(lambda: len(winds) >= begin + 5, watcher)
        for _ in range(10):
            watcher.spin()
        stamps = [to_stamp(message.header.stamp) for message in winds]
        first = round(stamps[0] * 30 / 1e9)
        assert stamps == [round((first + n) * 1e9 / 30) for n in range(len(stamps))]


def test_autokey_makes_keys_that_play_again(tmp_path, domain):
    """What a user sets becomes a key and is saved; the saved file plays; playback makes none."""
    saved = tmp_path / 'shot.yaml'
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done, keys = watcher.listen('frame_done'), watcher.listen('keyframe')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('wind', '-p', 'autokey:=true', '-p', f'save_to:={saved}')
        client = watcher.parameters_of('physics')
        eventually(lambda: len(done) > 15, watcher)
        before = to_stamp(done[-1].stamp) / 1e9
        assert watcher.put(client, 'gravity', 1.5).successful
        eventually(saved.exists, watcher)
        after = to_stamp(done[-1].stamp) / 1e9
        for _ in range(20):
            watcher.spin()
        content = yaml.safe_load(saved.read_text())['/**/wind']['ros__parameters']
        assert content['tracks'] == ['physics.gravity']
        assert content['keys.physics.gravity.values'] == [9.81, 1.5]
        # Until the key it is as it was seen: it does not glide there from the beginning.
        assert content['keys.physics.gravity.laws'] == ['step', 'linear']
        first, second = content['keys.physics.gravity.times']
        assert first == 0.0 and before <= second <= after + 0.2
        assert graph.end('wind') == 0
        del keys[:]
        # Paused, as the key comes once, and perhaps before the new wind is heard.
        graph.start('wind', '--params-file', str(saved), '-p', 'paused:=true')
        assert watcher.put(watcher.parameters_of('wind'), 'paused', False).successful
        eventually(lambda: round(second * 1e9) in [to_stamp(key.stamp) for key in keys], watcher)


def test_autokey_replaces_what_is_set_at_the_same_time(tmp_path, domain):
    """While the shot stands still: one key, whatever is set in between; the same value, none."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        winds, step = watcher.listen('wind'), watcher.publisher('step')
        graph.start('physics')
        graph.start('wind', '-p', 'autokey:=true', '-p', 'paused:=true')
        physics, wind = watcher.parameters_of('physics'), watcher.parameters_of('wind')

        def keyed(part):
            return list(watcher.get(wind, f'keys.physics.gravity.{part}') or ())
        eventually(lambda: step.publish(Empty()) or len(winds) > 6, watcher)
        for _ in range(10):  # the last steps are still on their way
            watcher.spin(0.1)
        now = to_stamp(winds[-1].header.stamp) / 1e9
        assert watcher.put(physics, 'gravity', 9.81).successful  # as it is already
        for gravity in (1.5, 2.5, 2.5):
            assert watcher.put(physics, 'gravity', gravity).successful
            eventually(lambda: keyed('values') == [9.81, gravity], watcher)
        assert keyed('times') == [0.0, now]
        assert watcher.get(wind, 'tracks') == ['physics.gravity']
        # Played to its key, the track sets nothing and so makes no key of its own.
        assert watcher.put(wind, 'paused', False).successful
        last = len(winds) + 30
        eventually(lambda: len(winds) > last, watcher)
        assert (keyed('times'), keyed('values')) == ([0.0, now], [9.81, 2.5])


def test_real_time_keeps_to_the_clock(tmp_path, domain):
    """Frames come at the rate, with stamps n / rate, and the shot ends with status 0."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        wind, clock = watcher.listen('wind'), watcher.listen('/clock')
        graph.start('wind', '-p', 'rate:=50.0', '-p', 'frames:=300', '-p', 'publish_clock:=true',
                    '-p', 'wait_for:=[]', '-p', 'paused:=true')
        assert watcher.put(watcher.parameters_of('wind'), 'paused', False).successful
        eventually(lambda: graph.processes['wind'].poll() is not None, watcher)
        assert graph.processes['wind'].poll() == 0, graph.log('wind')
        for _ in range(5):
            watcher.spin()
        assert 'over: 300 frames, 0 sent again' in graph.log('wind')
    stamps = [to_stamp(message.header.stamp) for message in wind]
    # A busy machine may miss some.
    assert len(stamps) > 50
    assert all(stamp % 20_000_000 == 0 for stamp in stamps)
    assert sorted(set(stamps)) == stamps and stamps[-1] <= 299 * 20_000_000
    assert {to_stamp(message.clock) for message in clock} >= set(stamps[5:])


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


def test_the_bag_can_be_sqlite(tmp_path, domain):
    """The other storage holds the same."""
    with Graph(tmp_path / 'log', domain) as graph:
        assert film(graph, tmp_path / 'bag', 10,
                    extra={'recorder': ['-p', 'storage:=sqlite3']}) == 0
    assert len(messages_of(tmp_path / 'bag', '/camera/image_raw')) == 10
    assert next((tmp_path / 'bag').glob('*.db3'))


MAKE_FRAMES = """
from flag_sim.ros.lifecycle import keep_memory
import resource
{call}
for frame in range(101):
    if frame == 1:
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    [b'x' * 1_000_000 for _ in range(4)]
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != 'glibc', reason='malloc is not that of glibc')
def test_a_frame_takes_the_memory_of_the_one_before():
    """After the first of 101 frames of 4 MB hardly a page is fetched; else nearly all 1000 are."""
    kept, fetched = (int(subprocess.run(
        [sys.executable, '-c', MAKE_FRAMES.format(call=call)], check=True, capture_output=True,
        text=True).stdout) for call in ('keep_memory()', ''))
    assert kept < 100 < 100 * 500 < fetched, (kept, fetched)
