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

"""A graph of which some nodes run on another host: see network.py."""
import contextlib
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys

from support import forked
from support.network import ADDRESSES

PROGRAM = Path(__file__).with_name('network.py')
USER = [] if os.geteuid() == 0 else ['--user', '--map-root-user']


def why_not() -> str | None:
    """Return why no hosts can be made here, or None."""
    for tool in ('unshare', 'mount'):
        if not shutil.which(tool):
            return f'there is no {tool}'
    with contextlib.suppress(OSError, subprocess.SubprocessError, ValueError):
        with Network():
            return None
    return 'namespaces and TAP interfaces may not be made'


class Network:
    """
    Two hosts, numbered 0 and 1.

    loss: the probability of a frame of Ethernet. delay: of each frame [s]. shared: both have the
    same network and only /dev/shm is each one's own. After the `with` block `passed` and `lost`
    say how many frames there were.
    """

    def __init__(self, loss: float = 0.0, delay: float = 0.0, shared: bool = False):
        self._arguments = [f'--loss={loss}', f'--delay={delay}', *(['--shared'] * shared)]
        self.passed = self.lost = 0

    def namespaces(self, host: int) -> list[str]:
        """Return the files of the namespaces that a process on a host is in, the user's first."""
        return [f'/proc/{self._ids[host]}/ns/{kind}'
                for kind in (*(['user'] if USER else []), 'net', 'mnt')]

    def __enter__(self) -> 'Network':
        """Make the hosts."""
        self._process = subprocess.Popen(
            ['unshare', *USER, '--net', '--mount', sys.executable, PROGRAM, *self._arguments],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            start_new_session=True)  # Ctrl-C ends the nodes first, which still need the network
        try:
            self._ids = json.loads(self._process.stdout.readline())
        except ValueError:
            self._process.communicate()
            raise
        return self

    def __exit__(self, *_):
        """End them."""
        figures, _ = self._process.communicate()
        self.passed, self.lost = json.loads(figures)


class HostsGraph(forked.Graph):
    """
    A graph across the two hosts of a network.

    there: the names of the nodes that run on host 1; the others run on host 0. peers: whether
    hosts find one another by the addresses that they are given instead of by multicast.
    """

    def __init__(self, logs, network, there=('physics', 'renderer'), peers=False):
        super().__init__(logs)
        self._network, self._there, self._peers = network, there, peers

    def prefix(self, name):
        """Return the number of the node's host, by which `launch` finds it."""
        return [str(int(name in self._there))]

    def launch(self, command, log, environment):
        """Return a process on the node's host, which is told how to find the other one."""
        host, _, *arguments = command
        found_by = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
        if self._peers:
            found_by = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
                        'ROS_STATIC_PEERS': ADDRESSES[1 - int(host)]}
        environment = {**environment, **found_by}
        # A watcher of an earlier test has chosen a profile for its process: here nodes choose.
        environment.pop('FASTDDS_DEFAULT_PROFILES_FILE', None)
        return forked.start(arguments, log, os.getcwd(), environment,
                            self._network.namespaces(int(host)))
