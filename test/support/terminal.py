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

"""A user at a terminal: commands of the docs are run, those of `ros2` by what they stand for."""
import functools
import importlib
import shlex
import subprocess

from flag_sim.drawing import Camera
from flag_sim.ros.topics import TOPICS
import numpy as np
from rcl_interfaces.msg import Parameter
from rclpy.parameter import get_parameter_value, parameter_dict_from_yaml_file
from support import forked
from support.pages import ROOT
from support.shot import SMALL
from support.watch import eventually, Watcher

NODES = ('physics', 'renderer', 'wind', 'recorder', 'player', 'viewer')
FRAMES = 'frames:=12'
"""The length of shots here, whatever the docs say: they are to end soon."""
SECONDS = 120.0  # that anything may take: kernels may have to be compiled


class Terminal:
    """
    Runs one command after another in a folder, against the nodes that have been started so far.

    `ros2` itself is not on PyPI: `ros2 run` starts the module, and what other verbs do is done by
    a node, with rclpy's own reading of values and files where `ros2` uses that. A node that is
    started again, or that must not run beside the next one, is ended first, as by Ctrl-C.
    """

    def __init__(self, folder):
        self._folder = folder
        self._graph = forked.Graph(folder / 'log')

    def __enter__(self):
        """Return self, with no node running."""
        self._graph.__enter__()
        self._watcher = Watcher(self._graph.domain)
        self._vertices = self._watcher.listen('vertices')
        return self

    def __exit__(self, *_):
        """End every node and hold it to its word."""
        try:
            for name in list(self._graph.processes):
                self._end(name)
        finally:
            self._watcher.__exit__()
            self._graph.__exit__()

    def run(self, command):
        """Run a command; raise AssertionError if it fails."""
        first, *words = shlex.split(command)
        if first == 'make':
            make(words)
        elif first == '.venv/bin/python':
            python(words)
        elif first == 'export':
            export(command)
        elif first == 'ros2':
            getattr(self, f'_{words[0]}')(*words[1:])
        else:
            self._run('flag_sim', first, *words)

    # Verbs of ros2.

    def _run(self, package, name, *arguments):
        if package == 'tf2_ros':
            assert name == 'static_transform_publisher'
            camera_stands(dict(zip(arguments[::2], arguments[1::2])))
        elif name not in NODES:
            python(['-m', f'flag_sim.study.{"__main__" if name == "study" else name}',
                    *arguments])
        elif '--help' in arguments:
            assert importlib.import_module(f'flag_sim.nodes.{name}').main([name, '--help']) == 0
        else:
            assert arguments[0] == '--ros-args' if arguments else True
            given = [FRAMES if word.startswith('frames:=') else word for word in arguments[1:]]
            self._start(name, *given)
            if name == 'player' or FRAMES in given:
                assert self._graph.wait(name, SECONDS) == 0, self._graph.log(name)
                self._end('recorder')

    def _param(self, verb, node, *arguments):
        name = node.removeprefix('/')
        if name not in self._running():
            self._start(name)
        client = self._watcher.parameters_of(name)
        if verb in ('list', 'dump'):
            assert len(self._watcher.get_all(client)) > 10
            return
        if verb == 'describe':
            answer = self._result(client.describe_parameters(list(arguments)))
            assert all(descriptor.description for descriptor in answer.descriptors)
            return
        if verb == 'delete':
            answer = self._result(client.delete_parameters(list(arguments)))
        elif verb == 'load':
            values = parameter_dict_from_yaml_file(arguments[0], target_nodes=[node])
            answer = self._result(client.set_parameters(list(values.values())))
        else:
            assert verb == 'set'
            answer = self._result(client.set_parameters(
                [Parameter(name=arguments[0], value=get_parameter_value(arguments[1]))]))
        assert answer.results and all(result.successful for result in answer.results), answer
        if arguments[0] == 'save_to':
            eventually((self._folder / arguments[1]).is_file, self._watcher)
        if name == 'physics':  # it works on with the new value
            self._see_frames()

    def _topic(self, verb, *arguments):
        if verb == 'echo':
            heard = self._watcher.listen(arguments[0].removeprefix('/'))
            eventually(lambda: heard, self._watcher, SECONDS)
            return
        once, topic, kind = arguments
        message = TOPICS[topic.removeprefix('/')].message
        assert (verb, once) == ('pub', '--once')
        assert kind == f'{message.__module__.split(".")[0]}/msg/{message.__name__}'
        out = self._watcher.publisher(topic.removeprefix('/'))
        eventually(out.get_subscription_count, self._watcher)
        out.publish(message())

    def _bag(self, verb, *arguments):
        if verb == 'record':
            self._start('recorder', '-p', f'topics:=[{", ".join(arguments)}]', '-p',
                        'path:=recorded')
            frames = 'X_FLAG_SIM_FRAMES'
            eventually(lambda: int(self._graph.told('recorder').get(frames, 0)) > 3,
                       self._watcher, SECONDS)
        else:
            path, topics, *names = arguments
            assert (verb, topics) == ('play', '--topics')
            self._run('flag_sim', 'player', '--ros-args', '-p', f'path:={path}', '-p',
                      f'topics:=[{", ".join(names)}]')

    # Nodes.

    def _running(self):
        return [name for name, process in self._graph.processes.items() if process.poll() is None]

    def _start(self, name, *arguments):
        if name == 'renderer':  # small pictures, where nothing else is said: it always draws
            arguments = (*SMALL, *arguments)
        # A bag's vertices are drawn where no wind announces frames, as the docs say.
        for other in (name, *(('wind', 'physics') if name == 'player' else ())):
            self._end(other)
        self._graph.start(name, *arguments)
        self._graph.wait_ready(name)

    def _end(self, name):
        if name in self._running():
            self._graph.end(name)
        if name in self._graph.processes:
            log = self._graph.log(name)
            assert self._graph.processes[name].returncode == 0, log
            for word in ('[ERROR]', 'Traceback', 'unknown and ignored'):  # a misspelt parameter
                assert word not in log, log

    def _see_frames(self):
        for name in ('physics', 'wind'):
            if name not in self._running():
                self._start(name)
        del self._vertices[:]
        eventually(lambda: len(self._vertices) > 2, self._watcher, SECONDS)

    def _result(self, future):
        eventually(future.done, self._watcher)
        return future.result()


def make(words):
    """Assert that make has the targets, and that the programs that they start answer."""
    done = subprocess.run(['make', '-n', *words], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and 'Nothing to be done' not in done.stdout, done
    for line in done.stdout.replace('\\\n', ' ').splitlines():
        parts = shlex.split(line)
        programs = [n for n, part in enumerate(parts) if part.startswith('.venv')
                    and part.endswith('/bin/python')]
        if programs and not {'venv', 'pip', '-c'} & set(parts):  # else it is being set up
            python(parts[programs[0] + 1:])


def python(words):
    """Assert that a program has the options that it is given; of pytest, that tests exist."""
    if words[:2] == ['-m', 'pytest']:
        assert all((ROOT / word).exists() for word in words if word.startswith('test/'))
        return
    count = 2 if words[0] == '-m' else 1
    known = help_of(*words[:count])
    for word in words[count:]:
        assert not word.startswith('--') or word in known, word


@functools.cache
def help_of(*program):
    """Return what a program of the package, by its path or after -m, answers to --help."""
    status, said = forked.run([*program, '--help'], ROOT)
    assert status == 0, said
    return said


def export(command):
    """Assert that the file of the package exists that a variable is set to."""
    _, _, path = command.partition('=$(ros2 pkg prefix flag_sim)/share/flag_sim/')
    assert (ROOT / path).is_file(), command


def camera_stands(options):
    """Assert that a static transform from world is the default camera's."""
    camera = Camera()
    assert options['--frame-id'] == 'world'
    assert options['--child-frame-id'] == 'camera_optical_frame'
    x, y, z, w = (float(options[f'--q{axis}']) for axis in 'xyzw')
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    # To the digits that are printed.
    np.testing.assert_allclose(turn, camera.pose[:3, :3].T, rtol=0.0, atol=2e-6)
    position = [float(options[f'--{axis}']) for axis in 'xyz']
    np.testing.assert_allclose(position, camera.position, rtol=0.0, atol=5e-5)
