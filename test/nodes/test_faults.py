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
import re

from flag_sim.ros import messages
from flag_sim.tools.graph import Graph
import pytest
from std_msgs.msg import Empty
from support.flags import wave
from support.shot import messages_of, SHOT, SMALL, stamp_of
from support.watch import eventually, Watcher

FRAMES = 150
WHOLE = [round(n * 1e9 / 30.0) for n in range(FRAMES)]
ENDED = f'of {FRAMES} frames of a take: no node publishes parameters any more'


class Shot:
    """
    The small shot in a graph; each of its nodes can be killed and started again.

    The wind is the last to start: the watcher then hears the shot from its first frames.
    """

    def __init__(self, graph, folder, watcher, *extra):
        self.graph, self.folder = graph, folder
        self.given = {
            'physics': (), 'renderer': SMALL,
            'recorder': ('-p', f'frames:={FRAMES}'),
            'wind': (*SHOT, '-p', f'frames:={FRAMES}', '-p', 'wait_for:=[renderer, recorder]',
                     '-p', 'resend_after:=0.5', *extra)}
        for name in ('physics', 'renderer', 'recorder'):
            self.start(name)
        eventually(lambda: watcher.node.count_publishers('frame_done') == 2, watcher)
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

    def stamps(self, number=0, topic='/camera/image_raw'):
        """Return the stamps of a topic in a bag."""
        return [stamp_of(message)
                for _, message in messages_of(self.folder / f'bag{number}', topic)]


def ports_of(process, ending):
    """Return the ports of Fast DDS that a process maps by names that end like this."""
    with open(f'/proc/{process}/maps') as maps:
        return set(re.findall(
            rf'(?m) /dev/shm/fastdds_port(\d+){re.escape(ending)}$', maps.read()))


@pytest.mark.parametrize('name', ['wind', 'physics', 'renderer', 'recorder'])
def test_a_node_that_is_killed_in_lockstep_and_started_again_holds_up_nobody(
        tmp_path, domain, name):
    """All frames of the newest take are in the bag; a new recorder says what it lacks."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        shot = Shot(graph, tmp_path, watcher)
        eventually(lambda: len(done) > 20, watcher)
        shot.kill(name)
        shot.start(name, 1)
        graph.wait_ready(name)
        # Else we might go on to write into the memory that the killed one read, and never notice.
        assert not ports_of('self', ' (deleted)') & ports_of(graph.processes[name].pid, '')
        assert graph.wait('wind', 90.0) == 0, graph.log('wind')
        if name == 'recorder':
            eventually(lambda: ENDED in graph.log('recorder'), watcher)
            assert graph.end('recorder') == 0
            assert shot.stamps(1)[-1] == WHOLE[-1]
        else:
            assert graph.wait('recorder', 60.0) == 0, graph.log('recorder')
            assert shot.stamps()[-FRAMES:] == WHOLE
            assert shot.stamps(topic='/vertices')[-FRAMES:] == WHOLE


@pytest.mark.parametrize('name', ['physics', 'renderer'])
def test_a_node_that_is_killed_in_real_time_and_started_again_is_served_again(
        tmp_path, domain, name):
    """The wind goes on meanwhile and ends; the recorder says what it lacks."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        shot = Shot(graph, tmp_path, watcher, '-p', 'pace:=realtime', '-p', 'frames:=0')
        eventually(lambda: len(done) > 20, watcher)
        shot.kill(name)
        shot.start(name)
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
        heard = len(done)
        eventually(lambda: len(done) >= heard + 10, watcher)
        assert watcher.put(wind, 'paused', False).successful
        for _ in range(5):
            reset.publish(Empty())
            watcher.spin(0.2)
        assert graph.wait('wind', 90.0) == 0, graph.log('wind')
        assert graph.wait('recorder', 60.0) == 0, graph.log('recorder')
        assert shot.stamps()[-FRAMES:] == WHOLE
        assert 'has not sent them' not in graph.log('renderer')
