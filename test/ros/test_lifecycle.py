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

"""How nodes end, and which clocks and memory they use."""
import importlib
import platform
import signal
import subprocess
import sys

from flag_sim.declarations.nodes import NODES
from flag_sim.ros.bag import Bag
from flag_sim.ros.messages import to_stamp
from flag_sim.tools import graph as tools
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.clock import ClockType
from support.forked import Graph
from support.shot import film, messages_of, SHOT, SMALL
from support.watch import eventually, Watcher


@pytest.mark.parametrize('graphs, number', [
    (tools.Graph, signal.SIGINT), (Graph, signal.SIGTERM)], ids=['as users start it', 'forked'])
def test_signals_end_every_node_cleanly(tmp_path, domain, graphs, number):
    """INT and TERM in the middle of a shot: status 0, no traceback, and the bag is readable."""
    with graphs(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
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
            assert graph.wait(name, 90.0) == 0, graph.log(name)
            assert 'Traceback' not in graph.log(name) and 'rror' not in graph.log(name)
    images = messages_of(tmp_path / 'bag', '/camera/image_raw')
    assert len(images) > 10
    assert [time for time, _ in images] == [round(n * 1e9 / 30.0) for n in range(len(images))]


@pytest.mark.parametrize('clock, storage, file', [
    ('true', 'mcap', '*.mcap'), ('false', 'sqlite3', '*.db3')])
def test_the_simulations_time_stops_no_node(tmp_path, domain, clock, storage, file):
    """
    With use_sim_time everywhere, whether or not somebody publishes it, the shot ends.

    Whichever the storage of the bag is, it holds the same.
    """
    simulated = ['-p', 'use_sim_time:=true']
    with Graph(tmp_path / 'log', domain) as graph:
        extra = {node: list(simulated) for node in ('physics', 'renderer', 'recorder', 'wind')}
        extra['wind'] += ['-p', f'publish_clock:={clock}']
        extra['recorder'] += ['-p', f'storage:={storage}']
        assert film(graph, tmp_path / 'bag', 10, extra=extra) == 0, graph.log('wind')
        assert graph.processes['recorder'].poll() == 0, graph.log('recorder')
    assert len(messages_of(tmp_path / 'bag', '/camera/image_raw')) == 10
    assert next((tmp_path / 'bag').glob(file))


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


MAKE_FRAMES = """
import resource

from flag_sim.ros.lifecycle import keep_memory
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
