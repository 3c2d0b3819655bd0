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

"""Several nodes as processes of their own: started together, watched, and ended."""
import contextlib
import os
from pathlib import Path
import signal
import subprocess
import sys
import time
from typing import IO

from flag_sim.protocol.notify import NotifyReceiver
from flag_sim.tools.domains import claimed_domain

POLL_PERIOD = 0.1
"""How often to check whether a node has ended instead of becoming ready [s]."""


class NotReady(RuntimeError):
    """A node has ended, or was too slow, before it was ready."""


class Graph:
    """
    Nodes of this package, each a process, in a ROS domain of their own, looking only on this host.

    logs: folder for one log file a node. domain: one that the caller has claimed; None claims one
    on entering the `with` block. The processes are ended, by their ids, on leaving it.
    """

    end_timeout = 10.0
    """How long a node may take to end [s]."""

    def __init__(self, logs: str | Path, domain: int | None = None):
        self.logs = Path(logs)
        self.logs.mkdir(parents=True, exist_ok=True)
        self.domain = domain
        self.processes = {}
        self._receivers = {}
        self._cleanup = contextlib.ExitStack()

    @property
    def environment(self) -> dict[str, str]:
        """Return the environment variables of the processes."""
        return {**os.environ, 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
                'ROS_DOMAIN_ID': str(self.domain)}

    def prefix(self, name: str) -> list[str]:
        """Return what is to stand before the command of a node: nothing, on this host."""
        return []

    def start(self, node: str, *arguments: str, name: str | None = None) -> subprocess.Popen:
        """Start a node with `--ros-args` arguments; return its process, which is not ready yet."""
        name = name or node
        receiver = self._receivers[name] = NotifyReceiver()
        self._cleanup.callback(receiver.close)
        log = self._cleanup.enter_context(open(self.logs / f'{name}.log', 'w'))
        self.processes[name] = self.launch(
            [*self.prefix(name), sys.executable, '-m', f'flag_sim.nodes.{node}', '--ros-args',
             *arguments], log, {**self.environment, 'NOTIFY_SOCKET': receiver.address})
        return self.processes[name]

    def launch(self, command: list[str], log: IO[str],
               environment: dict[str, str]) -> subprocess.Popen:
        """Return a new process that runs a command; what it says goes to an open file."""
        return subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=environment)

    def told(self, name: str) -> dict[str, str]:
        """Return what a node has told of itself, {name: text} as in sd_notify(3)."""
        return self._receivers[name].variables()

    def wait_ready(self, name: str, seconds: float = 300.0) -> None:
        """
        Wait until a node is ready for frames; raise NotReady, with its log, if it is not in time.

        Kernels that are compiled first take half a minute, more where the machine is busy.
        """
        end = time.monotonic() + seconds
        while 'READY' not in self.told(name):
            if self.processes[name].poll() is not None or time.monotonic() > end:
                raise NotReady(f'{name} is not ready; it said:\n{self.log(name)}')
            self._receivers[name].wait(POLL_PERIOD)

    def log(self, name: str) -> str:
        """Return what a node has said so far."""
        return (self.logs / f'{name}.log').read_text()

    def failed(self) -> list[str]:
        """Return the names of nodes that have ended with another status than 0."""
        return [name for name, process in self.processes.items() if process.poll()]

    def end(self, name: str) -> int:
        """End a node as Ctrl-C would; return its exit status."""
        self._interrupt(name)
        return self._wait_for_end(name)

    def _interrupt(self, name):
        if self.processes[name].poll() is None:
            self.processes[name].send_signal(signal.SIGINT)

    def _wait_for_end(self, name):
        process = self.processes[name]
        try:
            return process.wait(self.end_timeout)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()

    def wait(self, name: str, seconds: float) -> int | None:
        """Wait for a node to end by itself; return its exit status, None if it did not."""
        end = time.monotonic() + seconds
        while self.processes[name].poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        return self.processes[name].poll()

    def __enter__(self) -> 'Graph':
        """Return self, in a domain; raise NoDomain if there is none."""
        if self.domain is None:
            self.domain = self._cleanup.enter_context(claimed_domain())
        return self

    def __exit__(self, *_):
        """End every process that is still running."""
        # Once each, all at the same time: a second signal ends a node before it has closed.
        for name in self.processes:
            self._interrupt(name)
        for name in self.processes:
            self._wait_for_end(name)
        self._cleanup.close()
