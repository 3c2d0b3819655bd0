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
sd_notify messages: a process tells its parent that it is ready, its progress, and its end.

By the protocol of systemd, sd_notify(3): a datagram of lines NAME=value to the socket that the
environment variable NOTIFY_SOCKET names. So no log has to be parsed for it.
"""
import contextlib
import fcntl
import os
import secrets
import select
import socket
import struct
import termios

SEND_TIMEOUT = 5.0
"""How long to wait for a receiver with ten unread messages [s]; then the message is dropped."""
MAX_BYTES = 4096
"""Length of a message."""


class NotifySender:
    """
    The end in the process that was started; `is_connected` tells whether its parent listens.

    Variables are those of sd_notify(3), or named X_FLAG_SIM_... A receiver that is gone is
    ignored.
    """

    def __init__(self):
        self._socket = None
        address = os.environ.get('NOTIFY_SOCKET')
        if not address:
            return
        if address.startswith('@'):  # a name of the kernel's own, not of a file
            address = '\0' + address[1:]
        sender = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            sender.connect(address)
        except OSError:
            sender.close()
            return
        sender.settimeout(SEND_TIMEOUT)
        self._socket = sender

    @property
    def is_connected(self) -> bool:
        """Return whether the process was started with a NOTIFY_SOCKET."""
        return self._socket is not None

    def send(self, **variables) -> None:
        """Send variables that must arrive."""
        if self.is_connected:
            message = ''.join(f'{name}={value}\n' for name, value in variables.items())
            with contextlib.suppress(OSError):
                self._socket.send(message.encode())

    def send_progress(self, **variables) -> bool:
        """
        Send variables that newer ones will replace, if all that was sent before has been read.

        So they leave room in the receiver's queue for those that must arrive, also while it
        sleeps. Return whether they were sent.
        """
        is_read = self.is_connected and not self._unread_bytes()
        if is_read:
            self.send(**variables)
        return is_read

    def _unread_bytes(self):
        return struct.unpack('i', fcntl.ioctl(self._socket, termios.TIOCOUTQ, bytes(4)))[0]


class NotifyReceiver:
    """
    The receiving end for one process; `address` is the NOTIFY_SOCKET that it is started with.

    The kernel keeps what was sent until it is read, so nothing is lost while the receiver sleeps.
    """

    def __init__(self):
        self.address = f'@flag_sim-{os.getpid()}-{secrets.token_hex(8)}'
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind('\0' + self.address[1:])
        self._socket.setblocking(False)
        self._variables: dict[str, str] = {}

    def variables(self) -> dict[str, str]:
        """Return the latest of every variable that was sent so far: {name: text}."""
        with contextlib.suppress(BlockingIOError):
            while True:
                lines = self._socket.recv(MAX_BYTES).decode(errors='replace').splitlines()
                self._variables.update(line.split('=', 1) for line in lines if '=' in line)
        return self._variables

    def wait(self, seconds: float) -> None:
        """Return at the next message, or after so many seconds."""
        select.select([self._socket], [], [], seconds)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
