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

"""
Programs that begin with the imports of all of them done: as `python` runs them, but forked.

Every node imports rclpy, numba and the kernels' modules before its own first line, for longer
than most tests of a graph then take. Here one process imports them and forks one for each program.
What keeps a state of its own while it is imported, `flag_sim.ros` and what stands above it, each
program imports anew. Tests of how programs start as a user starts them use `flag_sim.tools.graph`.
"""
import contextlib
import ctypes
import functools
import gc
import importlib
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
import tempfile

from flag_sim.tools import graph

IMPORTED = ('physics', 'renderer', 'recorder', 'player', 'wind')  # of flag_sim.nodes
ANEW = ('flag_sim.ros', 'flag_sim.nodes')
AT_IMPORT = ('LD_', 'NUMBA_', 'OMP_', 'OPENBLAS_', 'PYTHON', 'RCUTILS_', 'RMW_')
"""Environment variables that are read while modules are imported."""
LONGEST = 1 << 20  # of a request [bytes]
SERVE = 'import sys; from support.forked import serve; serve(int(sys.argv[1]))'
TESTS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class Graph(graph.Graph):
    """
    A graph whose nodes are forked, unless they are to run elsewhere or with other imports.

    A test asserts how a node ends, so it gets the time that this takes on a busy machine.
    """

    end_timeout = 60.0

    def launch(self, command, log, environment):
        """Return a process, as subprocess.Popen does."""
        if command[0] == sys.executable and _server(os.getpid()).serves(environment):
            return start(command[1:], log, os.getcwd(), environment)
        return super().launch(command, log, environment)


def start(arguments, log, folder, environment, namespaces=()):
    """
    Return a process that runs what `python` with these arguments does in a folder.

    log: open file for its output; namespaces: files under /proc of those that it enters.
    """
    return _server(os.getpid()).start(arguments, log, folder, environment, namespaces)


def run(arguments, folder):
    """Run what `python` with these arguments does in a folder; return its status and output."""
    with tempfile.TemporaryFile('w+') as log:
        status = start(arguments, log, str(folder), os.environ).wait()
        log.seek(0)
        return status, log.read()


class Forked:
    """The part of subprocess.Popen that tests of a graph use, for a process that was forked."""

    def __init__(self, pid, status):
        self.pid, self.returncode = pid, None
        self._status = status
        self._descriptor = os.pidfd_open(pid)
        self._ended = select.poll()
        self._ended.register(self._descriptor, select.POLLIN)

    def poll(self):
        """Return the exit status, None while it runs."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait(0.0)
        return self.returncode

    def wait(self, timeout=None):
        """Return the exit status; raise subprocess.TimeoutExpired if it runs on [s]."""
        if self.returncode is None:
            if not self._ended.poll(None if timeout is None else 1000.0 * timeout):
                raise subprocess.TimeoutExpired(f'process {self.pid}', timeout)
            self.returncode = self._status(self.pid)
            os.close(self._descriptor)
        return self.returncode

    def send_signal(self, number):
        """Send a signal, if the process still runs."""
        if self.poll() is None:
            signal.pidfd_send_signal(self._descriptor, number)

    def kill(self):
        """End it by SIGKILL."""
        self.send_signal(signal.SIGKILL)


class Server:
    """The process that forks, as the tests see it; it ends with the process of the tests."""

    def __init__(self):
        self._read_at_import = read_at_import(os.environ)
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        paths = [TESTS, *(path for path in sys.path if path)]
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, '-c', SERVE, str(theirs.fileno())], pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                env={**os.environ, 'PYTHONPATH': os.pathsep.join(paths)})

    def serves(self, environment):
        """Return whether a program with these variables would import the same."""
        return read_at_import(environment) == self._read_at_import

    def start(self, arguments, log, folder, environment, namespaces):
        """Run `-m module ...` or `script ...` in a folder, with its output in an open file."""
        request = json.dumps([arguments, folder, dict(environment), list(namespaces)])
        socket.send_fds(self._socket, [request.encode()], [log.fileno()])
        return Forked(self._answer(), self._status)

    def _status(self, pid):
        self._socket.send(json.dumps(pid).encode())
        return self._answer()

    def _answer(self):
        answer = self._socket.recv(LONGEST)
        assert answer, 'the process that forks has ended'
        return json.loads(answer)


@functools.cache
def _server(pid):
    """Return the server of this process; pid: its id, as a fork needs a server of its own."""
    del pid
    return Server()


def read_at_import(environment):
    """Return the environment variables that count while modules are imported."""
    return {name: value for name, value in environment.items() if name.startswith(AT_IMPORT)}


def serve(descriptor):
    """Fork a process for each request until no more can come; become the program in a fork."""
    # Ctrl-C is for the tests; a fork gets what was sent to it before it was the program.
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    for name in IMPORTED:
        importlib.import_module(f'flag_sim.nodes.{name}')
    for name in [name for name in sys.modules if name.startswith(ANEW)]:
        del sys.modules[name]
    gc.collect()
    gc.freeze()  # so that a collection in a fork copies no memory
    with socket.socket(fileno=descriptor) as requests:
        while True:
            text, logs, _, _ = socket.recv_fds(requests, LONGEST, 1)
            if not text:
                return
            request = json.loads(text)
            if not logs:
                answer = os.waitstatus_to_exitcode(os.waitpid(request, 0)[1])
            elif answer := os.fork():
                os.close(logs[0])
            else:
                break
            requests.send(json.dumps(answer).encode())
    become(logs[0], *request)


def become(log, arguments, folder, environment, namespaces):
    """Run a program in this process, which was forked for it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for path in namespaces:
        with open(path) as namespace:
            if ctypes.CDLL(None, use_errno=True).setns(namespace.fileno(), 0):
                raise OSError(ctypes.get_errno(), 'setns', path)
    for descriptor in (1, 2):
        os.dup2(log, descriptor)
    os.close(log)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path[:] = [path for path in sys.path if path not in ('', TESTS)]
    if arguments[0] == '-m':
        sys.argv[1:] = arguments[2:]
        sys.path.insert(0, folder)
        runpy.run_module(arguments[1], run_name='__main__', alter_sys=True)
    else:
        sys.argv[:] = arguments
        sys.path.insert(0, os.path.dirname(os.path.abspath(arguments[0])))
        runpy.run_path(arguments[0], run_name='__main__')
