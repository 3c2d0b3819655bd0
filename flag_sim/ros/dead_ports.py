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

"""Ports of killed processes in shared memory: who writes to one is told that it is dead."""
import contextlib
import fcntl
import mmap
import os
from pathlib import Path
import re
import struct

SHM = Path('/dev/shm')
PORT_LOCK = re.compile(r'fastdds_port(\d+)_el')
NODE = b'port_node_abi5\0'  # of Fast DDS 3; another layout has another name
# Of that node: port, listeners, health check [ms], wait [ms], capacity, waiting; then its flags.
FIELDS = struct.Struct('=6IB')
IS_OK, KNOWN_FLAGS = 1, 7


def bury_dead_ports(shm: Path = SHM) -> None:
    """
    Mark the ports of Fast DDS whose reader was killed as not in order.

    Else a node that is started again takes the port of the one that was killed, by its name but
    in new memory. Those who wrote to the dead one notice, within seconds, only if it was killed
    while it waited for a message or handled one. Where it was killed between the two (about once
    in thirty times on a busy machine) they write into the old memory for ever, and the new node
    receives nothing from them. The reader of a port holds a lock on its file <port>_el for as long
    as it lives; only what can be locked is marked, while it is locked.
    """
    with contextlib.suppress(OSError):
        for match in filter(None, map(PORT_LOCK.fullmatch, os.listdir(shm))):
            with contextlib.suppress(OSError, ValueError):  # of another user; or empty
                _bury_if_dead(shm / match[0], int(match[1]))


def _bury_if_dead(lock, number):
    with _opened(lock, os.O_RDONLY) as held:
        fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        with (_opened(lock.with_name(f'fastdds_port{number}'), os.O_RDWR) as port,
              mmap.mmap(port, 0) as memory):
            place = _flags_of(memory, number)
            if place is not None:
                memory[place] &= ~IS_OK


@contextlib.contextmanager
def _opened(path, mode):
    file = os.open(path, mode | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        yield file
    finally:
        os.close(file)


def _flags_of(memory, number):
    """Return where the flags of a port are in its memory; None where it is laid out otherwise."""
    if memory.find(NODE) < 0:
        return None
    begin = struct.pack('=I', number)
    place = memory.find(begin)
    while place >= 0 and place + FIELDS.size <= len(memory):
        _, _, check, wait, _, _, flags = FIELDS.unpack_from(memory, place)
        if 0 < wait == check // 3 and flags <= KNOWN_FLAGS and place % 4 == 0:
            return place + FIELDS.size - 1
        place = memory.find(begin, place + 1)
    return None
