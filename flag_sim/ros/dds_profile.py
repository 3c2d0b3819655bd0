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

"""Which profile the package gives to Fast DDS, and what dead nodes left in shared memory."""
import contextlib
import fcntl
import os
from pathlib import Path
import re
import socket
import time

from flag_sim.parameters.config import config_path
from flag_sim.ros.dead_ports import bury_dead_ports, SHM

# Variables, and files in the working directory, by which users choose profiles or transports of
# Fast DDS. A discovery server (ROS_DISCOVERY_SERVER) is no such choice: it goes with our profile.
OWN_TRANSPORTS = (
    'FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE',
    'FASTDDS_BUILTIN_TRANSPORTS', 'FASTDDS_ENVIRONMENT_FILE', 'ROS2_EASY_MODE')
OWN_PROFILES = 'DEFAULT_FASTDDS_PROFILES.xml', 'DEFAULT_FASTRTPS_PROFILES.xml'

SEGMENT_LOCK = re.compile(r'fastdds_[0-9a-f]{16}_el')
YOUNG = 5.0  # a lock file may be made, but not locked yet [s]
CLAIM = '@flag_sim/shm/'

_claims = []  # held for as long as the process lives


def set_dds_profile() -> None:
    """
    Give Fast DDS the package's profile, unless the user has chosen how messages travel.

    With its stock settings a large image fills the shared memory segment, and from then on small
    reliable messages may never arrive: a run in lockstep stops for good within seconds.
    """
    if (os.environ.get('RMW_IMPLEMENTATION') or 'rmw_fastrtps_cpp') != 'rmw_fastrtps_cpp':
        return
    bury_dead_ports()
    if (os.environ.get('RMW_FASTRTPS_USE_QOS_FROM_XML') != '1'
            and not any(os.environ.get(name) for name in OWN_TRANSPORTS)
            and not any(os.path.exists(name) for name in OWN_PROFILES)):
        remove_dead_segments()
        os.environ['FASTDDS_DEFAULT_PROFILES_FILE'] = str(config_path(_profile()))


def _profile():
    """
    Return the file that suits where this process's peers are.

    Pieces that fit a frame of Ethernet save messages where frames are lost, but Fast DDS cuts
    messages into them in shared memory too: a picture of 640 x 480 then takes twice as long.
    """
    if not is_shm_shared():
        return 'fastdds_udp.xml'
    is_local = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE') == 'LOCALHOST'
    has_peers = any(os.environ.get(name) for name in ('ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER'))
    return 'fastdds_this_host.xml' if is_local and not has_peers else 'fastdds.xml'


def is_shm_shared(shm: Path = SHM) -> bool:
    """
    Return whether the nodes of this package in this process's network all share its /dev/shm.

    Containers may share a network only. Fast DDS takes them for one host and would speak to them
    by shared memory that they do not see. Each node therefore claims a name of the kernel's
    own, which counts in a network, and looks for others only then: of two that start
    together one at least sees the other, and it is enough that one has no shared memory.
    """
    try:
        found = shm.stat()
    except OSError:
        return False
    ours = f'{CLAIM}{found.st_dev}:{found.st_ino}/'
    if not _claims:
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        with contextlib.suppress(OSError):
            claim.bind(f'\0{ours[1:]}{os.getpid()}')
        _claims.append(claim)
    try:
        lines = Path('/proc/net/unix').read_text(errors='replace').splitlines()
    except OSError:
        return True
    names = [line.rpartition(' ')[2] for line in lines]
    return not any(name.startswith(CLAIM) and not name.startswith(ours) for name in names)


def remove_dead_segments(shm: Path = SHM) -> None:
    """
    Remove the segments of Fast DDS that processes which were killed have left.

    The owner of a segment holds a lock on its file <segment>_el for as long as it lives. Only
    what is this user's, not just made, and can be locked is removed, while it is locked. Ports,
    which several processes share, stay: they are small, and Fast DDS uses them again.
    """
    with contextlib.suppress(OSError):
        for lock in [name for name in os.listdir(shm) if SEGMENT_LOCK.fullmatch(name)]:
            with contextlib.suppress(OSError):
                _remove_if_dead(shm / lock)


def _remove_if_dead(lock):
    segment = lock.with_name(lock.name.removesuffix('_el'))
    if (segment.lstat().st_uid != os.geteuid()
            or abs(time.time() - lock.lstat().st_mtime) < YOUNG):
        return
    held = os.open(lock, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        if os.fstat(held).st_uid == os.geteuid():
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            segment.unlink()
            lock.unlink()
    finally:
        os.close(held)
