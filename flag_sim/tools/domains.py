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
ROS domains in which a graph meets no other, each claimed for as long as it is in use.

The ports of a domain begin at 7400 + 250 * domain (DDSI-RTPS 2.5, 9.6.2.3). Used are domains of
whose ports Linux hands out none by itself (it has 32768 to 60999 for that), the rarest first.
"""
from collections.abc import Iterator
import contextlib
import itertools
import socket

DOMAINS = (*range(231, 214, -1), *range(101, 59, -1))
CLAIM = 9  # a port within a domain's that RTPS leaves unused: who holds it has the domain
# The ports of a domain that tell whether a process is in it: that of discovery by multicast, and
# the first of each of so many participants.
TAKEN = (0, *itertools.islice(itertools.count(10, 2), 20))


class NoDomain(RuntimeError):
    """Every domain of DOMAINS is taken."""


@contextlib.contextmanager
def claimed_domain() -> Iterator[int]:
    """
    Yield a ROS domain that no process on this host has claimed or uses; raise NoDomain if none.

    The claim is a port, so it ends with the process at the latest, and holds for every user.
    """
    for domain in DOMAINS:
        claim = _bound(domain, CLAIM)
        if claim is None:
            continue
        with claim:
            if _is_empty(domain):
                yield domain
                return
    raise NoDomain(f'all {len(DOMAINS)} ROS domains for demos and tests are taken on this host: '
                   f'{min(DOMAINS)} to {max(DOMAINS)}')


def _is_empty(domain):
    for port in TAKEN:
        probe = _bound(domain, port)
        if probe is None:
            return False
        probe.close()
    return True


def _bound(domain, port):
    """Return a UDP socket that holds a port of the domain, or None if it is taken."""
    held = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        held.bind(('', 7400 + 250 * domain + port))
    except OSError:
        held.close()
        return None
    return held
