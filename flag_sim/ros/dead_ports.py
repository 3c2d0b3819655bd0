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

"""Ports of killed processes in shared memory, which a new node must not take over."""
from collections.abc import Iterator
import contextlib
import fcntl
import os
from pathlib import Path
import re

from flag_sim.ros.dds_profile import SHM

PORT_LOCK = re.compile(r'(fastdds_port\d+)_el')


@contextlib.contextmanager
def dead_ports_held(shm: Path = SHM) -> Iterator[None]:
    """
    Keep Fast DDS, meanwhile, from taking ports of killed processes that others still write to.

    Else a node that is started again takes the port of the one that was killed, by its name but
    in new memory. Those who wrote to the dead one notice, within seconds, only if it was killed
    while it waited for a message or handled one. Where it was killed between the two, they write
    into the old memory for ever, and the new node receives nothing from them. Whoever holds the
    lock of a port counts as its reader: while it is held, Fast DDS takes another port, which is
    new to everybody. The lock is shared, for several nodes may start at once.
    """
    with contextlib.ExitStack() as held:
        for lock in _locks_of_dead_ports(shm):
            with contextlib.suppress(OSError):
                held.enter_context(_shared_lock(shm / lock))
        yield


def _locks_of_dead_ports(shm):
    """Return the names of the locks that nobody holds, of ports that a process still maps."""
    with contextlib.suppress(OSError):
        free = {match[1]: match[0] for match in map(PORT_LOCK.fullmatch, os.listdir(shm))
                if match and _is_free(shm / match[0])}
        used = _mapped(shm) if free else set()  # most are only litter, which is taken again
        return [lock for port, lock in free.items() if port in used]
    return []


def _is_free(lock):
    with contextlib.suppress(OSError), _shared_lock(lock):
        return True
    return False


@contextlib.contextmanager
def _shared_lock(path):
    """Hold a lock of Fast DDS as one of several; raise OSError if it is held by its owner."""
    held = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(held, fcntl.LOCK_SH | fcntl.LOCK_NB)
        yield
    finally:
        os.close(held)


def _mapped(shm):
    """Return the names of the files of a folder that processes have in their memory."""
    names = set()
    pattern = re.compile(rf' {re.escape(str(shm))}/(\S+)$', re.MULTILINE)  # not ' (deleted)'
    for maps in Path('/proc').glob('[0-9]*/maps'):
        with contextlib.suppress(OSError):  # of another user, or it has ended
            names.update(pattern.findall(maps.read_text(errors='replace')))
    return names
