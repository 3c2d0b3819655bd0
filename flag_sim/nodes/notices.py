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
What a process tells whoever started it: that it is ready, how far it is, and that it ends.

By the protocol of systemd, sd_notify(3): a datagram of lines NAME=value to the socket that the
environment variable NOTIFY_SOCKET names. So nobody has to read a log's wording for it.
"""
import contextlib
import os
import secrets
import select
import socket
import time

PATIENCE = 5.0  # for a receiver that takes nothing in [s]; what is said then is lost
MOST_BYTES = 4096  # of a notice


def is_wanted():
    """Return whether somebody wants to be told."""
    return bool(os.environ.get('NOTIFY_SOCKET'))


def tell(must_arrive, **variables):
    """
    Send `variables`, those of sd_notify(3) or named X_FLAG_SIM_..., if somebody wants them.

    must_arrive: whether to wait for a receiver that is busy. One that is gone hinders nobody.
    """
    if not is_wanted():
        return
    notice = ''.join(f'{name}={value}\n' for name, value in variables.items())
    address = os.environ['NOTIFY_SOCKET']
    if address.startswith('@'):  # a name of the kernel's own, not of a file
        address = '\0' + address[1:]
    with contextlib.suppress(OSError), \
            socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.settimeout(PATIENCE if must_arrive else 0.0)
        sender.sendto(notice.encode(), address)


class Notices:
    """
    The receiving end for one process; `address` is the NOTIFY_SOCKET that it is started with.

    The kernel keeps at least the first ten notices until they are read: those that must arrive do,
    also where the receiver sleeps meanwhile.
    """

    def __init__(self):
        self.address = f'@flag_sim-{os.getpid()}-{secrets.token_hex(8)}'
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind('\0' + self.address[1:])
        self._socket.setblocking(False)
        self._told = {}

    def told(self):
        """Return the latest of every variable that was told so far: {name: text}."""
        with contextlib.suppress(BlockingIOError):
            while True:
                lines = self._socket.recv(MOST_BYTES).decode(errors='replace').splitlines()
                self._told.update(line.split('=', 1) for line in lines if '=' in line)
        return self._told

    def wait(self, seconds):
        """Return at the next notice, or after so many seconds."""
        select.select([self._socket], [], [], seconds)

    def close(self):
        """Hear no more."""
        self._socket.close()
