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

"""What a user reads whose flag stands still: each node names what it waits for, none guesses."""
import re
import signal
import time

from flag_sim.cloth import normals
from flag_sim.jit.kernels import kernel
from flag_sim.nodes import renderer as renderer_module
from flag_sim.nodes.renderer import Renderer
from flag_sim.protocol.frames import FrameId, FrameOrder
from flag_sim.ros import messages
from flag_sim.ros.compiling import compiling
from flag_sim.ros.topics import publish
import numba
import numpy as np
import pytest
import rclpy
from support.flags import wave
from support.forked import Graph
from support.shot import SMALL
from support.soak import SOAK
from support.watch import eventually, Watcher


def test_what_is_compiled_is_named_when_it_takes_long(domain, capfd, monkeypatch, tmp_path):
    """And when it is ready; what is only loaded is not called compiled, what is quick nothing."""
    monkeypatch.setattr(numba.config, 'CACHE_DIR', str(tmp_path))
    with Watcher(domain) as watcher:
        for doing, done in (('compiling', 'compiled'), ('loading', 'loaded')):
            with compiling(watcher.node, 'the sails', seconds=0.1):
                kernel(normals._normalise.py_func)(np.zeros((2, 2, 3)))
                said, end = capfd.readouterr().err, time.monotonic() + 60.0
                while f'{doing} the sails' not in said and time.monotonic() < end:
                    time.sleep(0.01)
                    said += capfd.readouterr().err
            said += capfd.readouterr().err
            assert f'{doing} the sails: frames wait for it' in said
            assert re.search(rf'{done} the sails in \d+\.\d s', said)
            assert ('compil' in said) == (doing == 'compiling')
        with compiling(watcher.node, 'the sails', seconds=60.0):
            pass
        assert 'sails' not in capfd.readouterr().err


@pytest.mark.parametrize('pace', ['lockstep'] + ['realtime'] * SOAK)
def test_from_the_wind_on_each_log_names_the_next_node(tmp_path, domain, pace):
    """No physics, then one that stands still, as while it compiles: wind, renderer, physics."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done = watcher.listen('frame_done')
        graph.start('renderer', *SMALL)
        graph.start('wind', '-p', f'pace:={pace}')
        eventually(lambda: 'no node publishes them, is physics running?' in graph.log('renderer'),
                   watcher)
        physics = graph.start('physics')
        eventually(lambda: len(done) > 20, watcher)
        eventually(lambda: 'frames are served again' in graph.log('renderer'), watcher)
        complaint = r'the frame at (\S+) s is not done: waiting for renderer \(its'
        blame, relief = 'physics has not sent them, its log says why', 'frames are served again'
        # Told before too, if physics was there for long before it sent any.
        told, ended = map(graph.log('renderer').count, (blame, relief))
        before = {*re.findall(complaint, graph.log('wind'))}
        physics.send_signal(signal.SIGSTOP)
        try:
            eventually(lambda: graph.log('renderer').count(blame) > told, watcher)
            eventually(lambda: 'renderer (its log says why)' in graph.log('wind'), watcher)
            stood = {*re.findall(complaint, graph.log('wind'))}
        finally:
            physics.send_signal(signal.SIGCONT)
        heard = len(done)
        eventually(lambda: len(done) > heard + 20, watcher)
        eventually(lambda: graph.log('renderer').count(relief) > ended, watcher)
        # One thing stood still: one frame is complained of, and not the other two of the window.
        assert len(stood - before) <= 1
        assert 'no such node' not in graph.log('wind').partition('is done')[2]


@pytest.mark.parametrize('frames, lacks', [
    (0, 'camera/image_raw of the frame at 0.000 s'), (3, '3 of 3 frames of a take')])
def test_a_recorder_says_which_topic_a_frame_lacks(tmp_path, domain, frames, lacks):
    """In lockstep everybody waits for it: here nobody draws; then that no wind asks any more."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p', f'frames:={frames}')
        graph.start('wind', '-p', 'pace:=lockstep', '-p', 'wait_for:=[recorder]')
        eventually(lambda: 'for camera/image_raw of the frame at 0.000 s: no node publishes it'
                   in graph.log('recorder'), watcher)
        eventually(lambda: 'waiting for recorder (its log says why)' in graph.log('wind'), watcher)
        assert graph.end('wind') == 0
        eventually(lambda: f'for {lacks}: no node publishes parameters any more'
                   in graph.log('recorder'), watcher)
        assert graph.end('recorder') == 0


def test_vertices_that_are_not_drawn_say_why(tmp_path, domain):
    """Played beside a wind, they wait for its parameters; once it is gone, they are drawn."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done, out = watcher.listen('frame_done'), watcher.publisher('vertices')
        stamps = iter(range(10**7, 10**12, 10**7))

        def send():
            out.publish(messages.cloud_message(next(stamps), wave(5, 7), wave(5, 7)))
        graph.start('wind', '-p', 'paused:=true')
        graph.wait_ready('wind')  # vertices that come before the renderer has found it are drawn
        graph.start('renderer', *SMALL)
        eventually(lambda: 'waiting for' in graph.log('renderer'), watcher)
        eventually(lambda: send() or 'wind publishes parameters, but not of this frame; end it'
                   in graph.log('renderer'), watcher)
        assert re.search(r'waiting for \d+\.\d s for parameters of the frame at',
                         graph.log('renderer'))
        assert graph.log('renderer').count('waiting for') == 2  # and vertices at the start
        assert not done
        graph.end('wind')
        eventually(lambda: send() or done, watcher)
        # The wind may be known to be gone before the next vertices come.
        ends = re.compile(r'(frames are served again|nothing is missing any more), after')
        eventually(lambda: send() or ends.search(graph.log('renderer')), watcher)


def test_two_publishers_of_vertices_are_told_once(domain, capfd, monkeypatch):
    """As where physics was started twice: each cloth has a history of its own."""
    monkeypatch.setattr(renderer_module, 'POLL_PERIOD', 0.05)
    with rclpy.init(domain_id=domain):
        renderer = Renderer()
        physics = [rclpy.create_node(name) for name in ('physics', 'other')]

        def spin_until(is_done):
            end = time.monotonic() + 60.0
            while not is_done() and time.monotonic() < end:
                rclpy.spin_once(renderer, timeout_sec=0.05)
        publish(physics[0], 'vertices')
        spin_until(lambda: renderer.count_publishers('vertices') == 1)
        for _ in range(10):
            rclpy.spin_once(renderer, timeout_sec=0.05)
        assert 'publishers of vertices' not in capfd.readouterr().err
        publish(physics[1], 'vertices')
        heard = []
        spin_until(lambda: heard.append(capfd.readouterr().err) or 'publishers' in heard[-1])
        assert '2 publishers of vertices (other, physics)' in heard[-1]
        for _ in range(10):
            rclpy.spin_once(renderer, timeout_sec=0.05)
        assert 'publishers of vertices' not in capfd.readouterr().err
        for node in (renderer, *physics):
            node.destroy_node()


def test_frames_without_vertices_are_not_kept_for_ever(domain):
    """A renderer that nobody sends vertices holds no more than the order of frames does."""
    with rclpy.init(domain_id=domain):
        renderer = Renderer()
        for index in range(500):
            renderer.take_frame(FrameId(index * 10**7, 1, index, index), None, {}, b'')
        assert len(renderer._server.inputs) <= FrameOrder.LONGEST_QUEUE
        renderer.destroy_node()
