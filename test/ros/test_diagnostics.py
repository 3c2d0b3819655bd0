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

"""The `state` of the nodes: right, and only while somebody listens."""
from contextlib import contextmanager
import time

from flag_sim.cloth import energy
from flag_sim.cloth.material import Material
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.nodes.physics import Physics
from flag_sim.protocol.frames import FrameId
from flag_sim.ros import diagnostics, messages
from flag_sim.ros.topics import TOPICS
import numpy as np
import pytest
import rclpy
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2
from support.forked import Graph
from support.shot import SMALL
from support.watch import eventually, Watcher

OK, WARN, ERROR = diagnostics.OK, diagnostics.WARN, diagnostics.ERROR


def test_nothing_is_asked_for_without_a_listener(domain, monkeypatch):
    """A node's status is not computed before somebody listens, nor after."""
    monkeypatch.setattr(diagnostics, 'PERIOD', 0.01)
    asked = []

    def status():
        asked.append(True)
        return WARN, 'a message', {'length [m]': 0.123456789, 'count': 3, 'name': 'x'}

    def spin(watcher, times=30):
        for _ in range(times):
            watcher.spin()
    with Watcher(domain) as speaker, Watcher(domain) as listener:
        told = diagnostics.Diagnostics(speaker.node, status)
        spin(speaker)
        assert not asked
        heard = []
        ear = listener.node.create_subscription(
            TOPICS['state'].message, 'state', heard.append, 1)
        eventually(lambda: spin(speaker, 1) or heard, listener)
        (status,) = heard[0].status
        assert (status.level, status.name, status.message) == (WARN, '/watcher', 'a message')
        assert [(value.key, value.value) for value in status.values] == [
            ('length [m]', '0.123457'), ('count', '3'), ('name', 'x')]
        listener.node.destroy_subscription(ear)
        eventually(lambda: not told._out.get_subscription_count(), speaker)
        asked.clear()
        spin(speaker)
        assert not asked


@contextmanager
def physics(domain, **given):
    """Run a physics node in this process with the given parameters."""
    arguments = [part for name, value in given.items()
                 for part in ('-p', f'{name.replace("__", ".")}:={value}')]
    with rclpy.init(args=['--ros-args', *arguments], domain_id=domain):
        node = Physics()
        yield node
        node.destroy_node()


def play(node, frames, wind, rate=30):
    """Let a node serve the frames of a take; return its status."""
    take = time.time_ns()
    for index in range(frames):
        node.take_frame(FrameId(round(index * 1e9 / rate), take, index, index), wind, {}, b'')
    return node.status()


def test_the_kinetic_energy_is_that_of_a_free_fall(domain):
    """Nodes without springs and air fall with g t, all but those at the hoist."""
    with physics(domain, stiffness=0.0, shear_stiffness=0.0, bend_stiffness=0.0, damping=0.0,
                 air__density=0.0) as node:
        level, message, values = play(node, 7, (0.0, 0.0, 0.0), rate=60)
    mass = 0.2 * 2.25 * 1.5 * (1.0 - 0.5 / 30.0)  # but for half a column of cells
    assert values['kinetic energy [J]'] == pytest.approx(0.5 * mass * (9.81 * 0.1)**2, rel=1e-9)
    assert values['elastic energy [J]'] == 0.0
    assert (level, message) == (OK, 'serving frames')


def test_elastic_energy_and_strain_are_those_of_the_vertices(domain):
    """
    They agree with what can be computed from the message that everybody gets.

    Its float32 leave half a micrometre in 9 m: of a thread's extension, a hundredth of 75 mm, that
    is 1e-3, and twice that of the energy.
    """
    with physics(domain, stiffness=100.0, shear_stiffness=50.0) as node:
        sent = []
        node.answer = lambda stamp, cloud: sent.append(cloud)
        _, _, values = play(node, 30, (9.0, 3.0, 0.0))
        positions, _ = messages.read_cloud(deserialize_message(sent[-1], PointCloud2))
    model = Model(Mesh(21, 31, 2.25, 1.5), Material(stiffness=100.0, shear_stiffness=50.0))
    expected = energy.elastic_energy(model, positions) + energy.bending_energy(model, positions)
    assert values['elastic energy [J]'] == pytest.approx(expected, rel=2e-3)
    threads = [np.linalg.norm(positions[:, 1:] - positions[:, :-1], axis=-1) / 0.075,
               np.linalg.norm(positions[1:] - positions[:-1], axis=-1) / 0.075]
    strain = max(part.max() for part in threads) - 1.0
    assert strain > 0.01
    assert values['greatest strain'] == pytest.approx(strain, rel=1e-3)


def test_a_softened_cloth_is_a_warning_and_a_diverged_one_an_error(domain):
    """And both end."""
    with physics(domain, substeps_limit=10) as node:
        level, message, values = play(node, 3, (9.0, 0.0, 0.0))
        assert level == WARN and 'softer' in message
        assert values['steps demanded'] > values['steps granted'] == 10
        assert 0.0 < values['stiffness factor'] < 1.0
        node.set_parameters_atomically([Parameter('substeps_limit', value=1000)])
        assert play(node, 2, (9.0, 0.0, 0.0))[0] == OK
    # The course project's drag law on the lightest of cloths.
    with physics(domain, solver='seed', air__law='seed', area_density=1e-6, damping=0.0,
                 stretch_limit=1e6, substeps_limit=5) as node:
        level, message, _ = play(node, 60, (0.0, 200.0, 0.0), rate=10)
        assert level == ERROR and 'with solver seed' in message
        assert play(node, 1, (0.0, 0.0, 0.0))[0] != ERROR


def test_nodes_that_are_held_are_a_warning(domain):
    """A cloth without springs falls until stretch_limit holds it."""
    with physics(domain, stiffness=0.0, shear_stiffness=0.0, bend_stiffness=0.0,
                 stretch_limit=0.1) as node:
        level, message, values = play(node, 60, (0.0, 0.0, 0.0))
    held = values['nodes held by stretch_limit']
    assert level == WARN and message == f'{held} nodes are held back by stretch_limit'
    assert 0 < held <= 21 * 30


def test_the_state_of_a_graph(tmp_path, domain):
    """Every node tells; the wind warns while it waits, misses frames, or is not alone."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        heard = watcher.listen('state')

        def hears(node, level, words):
            """Return whether a node has told this in words since the last time."""
            found = [status for message in heard for status in message.status
                     if (status.name, status.level) == (node, level) and words in status.message]
            del heard[:]
            return found
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('wind', '-p', 'pace:=lockstep')
        for node, words in (('/wind', 'lockstep'), ('/physics', 'serving frames'),
                            ('/renderer', 'serving frames')):
            eventually(lambda: hears(node, OK, words), watcher)
        client = watcher.parameters_of('wind')
        assert watcher.put(client, 'pace', 'realtime').successful
        assert watcher.put(client, 'rate', 1000.0).successful  # no machine draws as fast
        eventually(lambda: hears('/wind', WARN, 'frames missed'), watcher)
        assert watcher.put(client, 'rate', 10.0).successful
        assert watcher.put(client, 'pace', 'lockstep').successful
        graph.start('wind', '-p', 'paused:=true', name='another')
        eventually(lambda: hears('/wind', WARN, 'another node publishes parameters'), watcher)
        assert graph.end('another') == 0
        eventually(lambda: hears('/wind', OK, 'lockstep'), watcher)
        assert graph.end('renderer') == 0
        eventually(lambda: hears('/wind', WARN, 'waiting for renderer (no such node'), watcher)
