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

"""Nodes killed, strangers and resets in mid-shot: it ends, or a log says who is waited for."""
import contextlib
import itertools
import time

from builtin_interfaces.msg import Time
from flag_sim.ros import messages
from flag_sim.ros.messages import to_stamp
from flag_sim.ros.parameter_node import to_parameter
from flag_sim.ros.topics import subscribe
import pytest
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image
from std_msgs.msg import Empty, Header
from support.flags import wave
from support.forked import Graph
from support.shot import messages_of, SHOT, SMALL, stamp_of
from support.soak import SOAK
from support.watch import eventually, Watcher

FRAMES = 150
WHOLE = [round(n * 1e9 / 30.0) for n in range(FRAMES)]
ENDED = f'of {FRAMES} frames of a take: no node publishes parameters any more'


class Shot:
    """
    The small shot in a graph; each of its nodes can be killed and started again.

    The wind is the last to start: the watcher then hears the shot from its first frames. extra: of
    the wind's arguments, given: of the others'; others: nodes that say `frame_done` beside it.
    """

    def __init__(self, graph, folder, watcher, *extra, given=(), frames=FRAMES, others=0):
        self.graph, self.folder = graph, folder
        self.given = {
            'physics': given, 'renderer': (*SMALL, *given),
            'recorder': ('-p', f'frames:={frames}', *given),
            'wind': (*SHOT, '-p', f'frames:={frames}', '-p', 'wait_for:=[renderer, recorder]',
                     '-p', 'resend_after:=0.5', *extra)}
        for name in ('physics', 'renderer', 'recorder'):
            self.start(name)
        eventually(lambda: watcher.node.count_publishers('frame_done') == 2 + others, watcher)
        self.start('wind')

    def start(self, name, number=0):
        """Start a node; a recorder begins a bag of its own."""
        given = self.given[name]
        if name == 'recorder':
            given = (*given, '-p', f'path:={self.folder / f"bag{number}"}')
        self.graph.start(name, *given)

    def kill(self, name):
        """End a node by SIGKILL."""
        self.graph.processes[name].kill()
        self.graph.processes[name].wait()

    def stamps(self, bag='bag0', topic='/camera/image_raw'):
        """Return the stamps of a topic in a bag."""
        return [stamp_of(message) for _, message in messages_of(self.folder / bag, topic)]


@pytest.mark.parametrize('name', ['recorder'] + ['wind', 'physics', 'renderer'] * SOAK)
def test_a_node_that_is_killed_in_lockstep_and_started_again_holds_up_nobody(
        tmp_path, domain, name):
    """
    All frames of the newest take are in the bag; a new recorder says what it lacks.

    The watcher is waited for too: no shot is over while it looks away.
    """
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done, answer = watcher.listen('frame_done'), watcher.publisher('frame_done')
        subscribe(watcher.node, 'parameters', lambda message: answer.publish(
            Header(stamp=message.stamp, frame_id='watcher')))
        shot = Shot(graph, tmp_path, watcher, '-p', 'wait_for:=[renderer, recorder, watcher]',
                    others=1)
        eventually(lambda: sum(one.frame_id == 'recorder' for one in done) > 10, watcher)
        shot.kill(name)
        shot.start(name, 1)
        eventually(lambda: graph.processes['wind'].poll() is not None, watcher)
        assert graph.processes['wind'].poll() == 0, graph.log('wind')
        if name == 'recorder':
            eventually(lambda: ENDED in graph.log('recorder'), watcher)
            assert graph.end('recorder') == 0
            assert shot.stamps('bag1')[-1] == WHOLE[-1]
        else:
            assert graph.wait('recorder', 90.0) == 0, graph.log('recorder')
            assert shot.stamps()[-FRAMES:] == WHOLE
            assert shot.stamps(topic='/vertices')[-FRAMES:] == WHOLE


@pytest.mark.parametrize('name', ['renderer'] + ['physics', 'wind', 'recorder'] * SOAK)
def test_a_node_that_is_killed_in_real_time_and_started_again_is_served_again(
        tmp_path, domain, name):
    """The wind goes on meanwhile and ends; the recorder says what it lacks."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        shot = Shot(graph, tmp_path, watcher, '-p', 'pace:=realtime', '-p', 'frames:=0')
        eventually(lambda: len(done) > 20, watcher)
        shot.kill(name)
        shot.start(name, 1)
        graph.wait_ready(name)
        heard = len(done)
        eventually(lambda: len(done) > heard + 10, watcher)
        assert graph.end('wind') == 0
        eventually(lambda: graph.processes['recorder'].poll() == 0
                   or ENDED in graph.log('recorder'), watcher)


def test_strangers_steps_and_resets_in_mid_shot_leave_a_whole_take(tmp_path, domain):
    """Eight clouds of the future, thirty steps of a paused wind, resets without a pause."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        vertices, step, reset = map(watcher.publisher, ('vertices', 'step', 'reset'))
        shot = Shot(graph, tmp_path, watcher, '-p', 'paused:=true')
        wind = watcher.parameters_of('wind')
        eventually(lambda: all(one.get_subscription_count() for one in (vertices, step, reset)),
                   watcher)
        for second in range(1000, 1008):
            vertices.publish(messages.cloud_message(second * 10**9, wave(5, 7), wave(5, 7)))
        for _ in range(30):
            step.publish(Empty())
        # Some of them are lost, as a queue has room for 8, and so may be what is heard of them.
        heard = len(done)
        eventually(lambda: step.publish(Empty()) or len(done) >= heard + 10, watcher)
        assert watcher.put(wind, 'paused', False).successful
        for _ in range(5):
            reset.publish(Empty())
            watcher.spin(0.2)
        assert graph.wait('wind', 90.0) == 0, graph.log('wind')
        assert graph.wait('recorder', 90.0) == 0, graph.log('recorder')
        assert shot.stamps()[-FRAMES:] == WHOLE


def test_consumers_that_are_slow_hung_weak_or_many_hold_up_nobody(tmp_path, domain):
    """Only who is in wait_for is waited for; what the others lose is theirs."""
    with contextlib.ExitStack() as stack:
        graph = stack.enter_context(Graph(tmp_path / 'log', domain))
        watcher, hung, weak = (stack.enter_context(Watcher(domain)) for _ in range(3))
        hung.listen('camera/image_raw')  # and is not spun once frames come
        weak_heard, slow_heard = [], []
        weak.node.create_subscription(Image, 'camera/image_raw', weak_heard.append,
                                      qos_profile_sensor_data)
        subscribe(watcher.node, 'camera/image_raw',
                  lambda message: time.sleep(0.1) or slow_heard.append(message))
        many = [watcher.listen('camera/image_raw') for _ in range(20)]
        shot = Shot(graph, tmp_path, watcher, '-p', 'paused:=true', frames=60)
        step = watcher.publisher('step')
        for one in watcher, hung, weak:  # whom the renderer knows then
            one.parameters_of('renderer')
        wind = watcher.parameters_of('wind', step)
        # Frame by frame, as what is not sent reliably may be lost.
        while not weak_heard:
            step.publish(Empty())
            many_heard = [len(one) + 1 for one in many]
            eventually(lambda: weak.spin(0.0) or all(
                len(one) >= count for one, count in zip(many, many_heard)), watcher)
            weak.spin()
        eventually(lambda: slow_heard, watcher)
        assert watcher.put(wind, 'paused', False).successful
        assert graph.wait('wind', 90.0) == 0, graph.log('wind')
        assert graph.wait('recorder', 90.0) == 0, graph.log('recorder')
        assert shot.stamps() == WHOLE[:60]


def test_storms_of_parameters_and_clocks_that_jump_leave_a_whole_take(tmp_path, domain):
    """Sets without a pause on three nodes, which run by a simulation time that goes any way."""
    sets = {'physics': 'gravity', 'renderer': 'sun.azimuth', 'wind': 'speed'}
    by_clock = ('-p', 'use_sim_time:=true')
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        clock = watcher.publisher('/clock')
        # The take begins in the midst of the storm: else it may be over before that.
        shot = Shot(graph, tmp_path, watcher, *by_clock, '-p', 'paused:=true', given=by_clock,
                    frames=60)
        clients = {name: watcher.parameters_of(name) for name in sets}
        asked, begun, numbers = {}, [], itertools.count()
        seconds = itertools.cycle((1000, 5, 10**9, 0))

        def is_over():
            """Go on with the storm; return whether the shot has ended in it."""
            clock.publish(Clock(clock=Time(sec=next(seconds))))
            for name, client in clients.items():
                if name not in asked or asked[name].done():
                    number = next(numbers)
                    asked[name] = client.set_parameters([
                        to_parameter(sets[name], (number + one) % 3 + 1.0) for one in range(50)])
                    if number > 13 and not begun:
                        begun.append(clients['wind'].set_parameters([
                            to_parameter('paused', False)]))
            return graph.processes['wind'].poll() is not None
        eventually(is_over, watcher)
        assert graph.processes['wind'].poll() == 0, graph.log('wind')
        assert graph.wait('recorder', 90.0) == 0, graph.log('recorder')
        assert shot.stamps() == WHOLE[:60]
        assert all(done.successful for one in asked.values() if one.done()
                   for done in one.result().results)


def test_two_of_every_node_but_the_wind_leave_a_whole_take(tmp_path, domain):
    """What is alike is taken from either; a second recorder is waited for by a name of its own."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        for name, *given in (('physics',), ('renderer', *SMALL), (
                'recorder', '-p', f'path:={tmp_path / "second"}', '-p', 'frames:=60',
                '-r', '__node:=witness')):
            graph.start(name, *given, name=f'second {name}')
        eventually(lambda: watcher.node.count_publishers('frame_done') == 2, watcher)
        shot = Shot(graph, tmp_path, watcher, '-p', 'wait_for:=[renderer, recorder, witness]',
                    frames=60, others=2)
        assert graph.wait('wind', 90.0) == 0, graph.log('wind')
        for name in 'recorder', 'second recorder':
            assert graph.wait(name, 90.0) == 0, graph.log(name)
        for bag in 'bag0', 'second':
            assert shot.stamps(bag) == WHOLE[:60]


@pytest.mark.skipif(not SOAK, reason='takes long: make soak')
def test_a_player_that_is_killed_and_started_again_plays_on(tmp_path, domain):
    """In lockstep from the bag's first frame: to those who are there it is another round."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        shot = Shot(graph, tmp_path, watcher)
        assert graph.wait('wind', 90.0) == graph.wait('recorder', 90.0) == 0
        done = watcher.listen('frame_done')
        player = ('-p', f'path:={tmp_path / "bag0"}', '-p', 'topics:=[parameters]',
                  '-p', 'pace:=lockstep')
        shot.given['player'] = player
        shot.start('player')
        eventually(lambda: len(done) > 20, watcher)
        shot.kill('player')
        shot.start('player')
        del done[:]
        eventually(lambda: graph.processes['player'].poll() is not None, watcher)
        assert graph.processes['player'].poll() == 0, graph.log('player')
        assert {to_stamp(one.stamp) for one in done} >= set(WHOLE[-20:])
