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

"""The nodes' parameters: what is refused, at the start and while running, and what is heard."""
import importlib

from flag_sim.protocol.frames import FrameId
from flag_sim.ros import messages
from flag_sim.ros.parameter_node import BadParameter
import numpy as np
import pytest
import rclpy
from support.forked import Graph
from support.frames import parameters_message
from support.watch import eventually, Watcher


@pytest.mark.parametrize('node, arguments, said', [
    ('physics', ['stiffness:=-5.0'],
     'stiffness must be a number from 0 to 1.0e+09 [N/m], not -5.0'),
    ('physics', ['stiffness:=soft'], "not 'soft'"),
    ('physics', ['grid.rows:=1'], 'grid.rows must be a whole number from 2'),
    ('physics', ['grid.rows:=2.5'], 'not 2.5'),
    ('physics', ['pole.diameter:=5.0', 'pole.height:=4.0'], 'must be less than pole.height 4 m'),
    ('renderer', ['camera.projection:=fisheye'], "orthographic, not 'fisheye'"),
    ('renderer', ['background:=[1.0, 2.0]'], 'a list of 3 values'),
    ('wind', ['rate:=0.0'], 'rate must be a number from 0.01'),
    ('wind', ['rate:=.nan'], 'not nan'),
    ('wind', ['tracks:=[wind.speed]'], 'needs keys.wind.speed.times'),
    ('wind', ['tracks:=[physics.colour]'], "no parameter 'colour'"),
    ('wind', ['tracks:=[physics.gravity]', 'keys.physics.gravity.times:=[0.0, 0.0]',
              'keys.physics.gravity.values:=[1.0, 2.0]'], 'times must increase strictly'),
    ('wind', ['tracks:=[physics.gravity]', 'keys.physics.gravity.times:=[0.0]',
              'keys.physics.gravity.values:=[-1.0]'], 'gravity must be a number from 0'),
    ('wind', ['pace:=lockstep', 'wait_for:=[]'], 'lockstep needs at least one node'),
    ('wind', ['events.names:=[a, b]', 'events.times:=[1.0]'], 'of one length, not 2 and 1'),
    ('wind', ['rate:=-30.0'], 'not -30.0'),
    ('wind', ['keys.sun.speed.times:=[0.0]'], "'sun.speed' must begin with one of wind, physics"),
    ('wind', ['tracks:=[renderer.threads]'], 'this parameter cannot be keyed'),
    ('wind', ['save_to:=/nowhere/shot.yaml'], 'there is no folder /nowhere'),
    ('wind', ['use_sim_time:=5'], 'use_sim_time must be a boolean, not 5'),
    ('physics', ['use_sim_time:=[true]'], 'use_sim_time must be a boolean, not [True]'),
    ('recorder', ['topics:=[]'], 'nothing to record'),
    ('recorder', ['topics:=[images]'], "'images' is not one of"),
    ('recorder', ['topics:=[reset]'], "'reset' is not one of"),
    ('recorder', ['storage:=zip'], "one of mcap, sqlite3, not 'zip'"),
    ('recorder', ['path:=/proc/bag'], 'path /proc/bag'),
    ('recorder', ['storage:=sqlite3', 'compression:=zstd'], 'compression zstd needs storage mcap'),
])
def test_a_bad_start_is_refused(tmp_path, domain, capfd, node, arguments, said):
    """A node that cannot be tells the rule and the value, on one line, and makes nothing."""
    arguments = ['--ros-args', *(part for argument in arguments for part in ('-p', argument))]
    if node == 'recorder' and not any('path' in part for part in arguments):
        arguments += ['-p', f'path:={tmp_path / "bag"}']
    make = getattr(importlib.import_module(f'flag_sim.nodes.{node}'), node.capitalize())
    with rclpy.init(domain_id=domain, args=arguments):
        with pytest.raises(BadParameter) as refusal:
            make()
    assert said in str(refusal.value) and '\n' not in str(refusal.value)
    assert capfd.readouterr() == ('', '')
    assert not (tmp_path / 'bag').exists()


@pytest.mark.parametrize('node, argument, said', [
    ('physics', 'stiffness:=-5.0', 'stiffness must be a number from 0 to 1.0e+09 [N/m], not -5.0'),
    ('renderer', 'width:=0', 'not 0'), ('wind', 'rate:=0.0', 'rate must be a number from 0.01'),
    ('recorder', 'topics:=[]', 'nothing to record'), ('player', 'path:=/nowhere', '/nowhere')])
def test_a_refusal_is_one_clear_line(tmp_path, domain, node, argument, said):
    """Of a process that ends with status 1, without a traceback."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start(node, '-p', argument)
        assert graph.wait(node, 90.0) == 1
        lines = graph.log(node).splitlines()
    assert len(lines) == 1
    assert lines[0].startswith('refused: ') and said in lines[0]


def test_a_params_file_that_is_not_there_is_one_clear_line(tmp_path, domain):
    """What rclpy says of it is passed on, without its traceback."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('wind', '--params-file', str(tmp_path / 'none.yaml'))
        assert graph.wait('wind', 90.0) == 1
        assert 'cannot start' in graph.log('wind') and 'none.yaml' in graph.log('wind')
        assert 'Traceback' not in graph.log('wind')


def test_unknown_arguments_are_refused(tmp_path, domain):
    """A parameter given without --ros-args would otherwise be lost without a word."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('wind', '-p', 'rate:=20.0', '--', 'speed:=3.0')
        assert graph.wait('wind', 90.0) == 1
        assert 'unknown arguments speed:=3.0' in graph.log('wind')


@pytest.fixture
def running(tmp_path, domain):
    """Return the graph of a physics node and a renderer that run, and a watcher in it."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('physics', '-p', 'stifness:=3.0', '-p', 'stiffness:=700', '-p', 'rate:=9.0')
        graph.start('renderer', '-p', 'width:=64', '-p', 'height:=48')
        yield graph, watcher


def test_parameters_while_running(running):
    """Bad values are refused with reasons, good ones count, and names are looked after."""
    graph, watcher = running
    client = watcher.parameters_of('physics')
    # A whole number for a number, at the start and later; a wrong name is not lost silently.
    assert watcher.get(client, 'stiffness') == 700.0
    assert "'stifness' is unknown and ignored; the nearest known one is 'stiffness'" \
        in graph.log('physics')
    assert "'rate' is one of /wind, not of /physics" in graph.log('physics')
    for name, value, said in (
            ('stiffness', -1.0, 'from 0 to 1.0e+09 [N/m], not -1.0'),
            ('stiffness', 'soft', "not 'soft'"),
            ('stiffness', float('nan'), 'not nan'),
            ('grid.rows', 2.5, 'not 2.5'),
            ('pole.diameter', 10.0, 'must be less than pole.height'),
            ('stifness', 1.0, "the nearest known one is 'stiffness'")):
        result = watcher.put(client, name, value)
        assert not result.successful and said in result.reason
    assert watcher.get(client, 'stiffness') == 700.0
    assert watcher.put(client, 'stiffness', 5).successful
    assert watcher.get(client, 'stiffness') == 5.0
    assert graph.processes['physics'].poll() is None


def test_bad_messages_are_refused_and_the_nodes_live(running):
    """Malformed `parameters` and `vertices` are warned of; the next good one is served."""
    graph, watcher = running
    parameters = watcher.publisher('parameters')
    vertices = watcher.publisher('vertices')
    images = watcher.listen('camera/image_raw')
    flat = np.zeros((2, 2, 3))
    frame = FrameId(0, 1, 0, 0)
    bad_wind = parameters_message('/x', frame, [np.nan] * 3, {})
    bad_key = parameters_message('/x', frame, np.zeros(3), {'physics.stiffness': -4.0})
    good = parameters_message('/x', frame, np.zeros(3), {})
    bad_cloud = messages.cloud_message(0, flat * np.nan, flat)

    # A message may be sent before its reader knows the writer, so it is sent until it is heard.
    def said(publisher, message, node, words):
        publisher.publish(message)
        return words in graph.log(node)
    eventually(lambda: said(parameters, bad_wind, 'physics', 'wind must be finite'), watcher)
    eventually(lambda: said(vertices, bad_cloud, 'renderer', 'of point (0, 0) is nan'), watcher)
    eventually(lambda: parameters.publish(bad_key) or parameters.publish(good) or images, watcher)
    assert (images[0].width, images[0].height) == (64, 48)
    for node in ('physics', 'renderer'):
        assert graph.processes[node].poll() is None
        assert 'Traceback' not in graph.log(node)
