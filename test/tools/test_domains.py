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

"""Domains of demos and tests: nobody else is in them, however many there are side by side."""
import subprocess
import sys

from flag_sim.tools import domains
from flag_sim.tools.domains import claimed_domain, DOMAINS, NoDomain
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

CLAIM = """
from flag_sim.tools.domains import claimed_domain
import sys
with claimed_domain() as domain:
    print(domain, flush=True)
    sys.stdin.read()
"""


def test_processes_side_by_side_have_a_domain_each():
    """As two suites on one host would: no domain is given twice while it is in use."""
    with claimed_domain() as own:
        others = [subprocess.Popen([sys.executable, '-c', CLAIM], stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, text=True) for _ in range(4)]
        claimed = [own, *(int(other.stdout.readline()) for other in others)]
        for other in others:
            other.communicate(timeout=30.0)
    assert len(set(claimed)) == 5
    assert set(claimed) <= set(DOMAINS)


def test_a_domain_in_which_somebody_is_is_left_alone():
    """A user's graph has claimed nothing, and still nobody meets it."""
    context = Context()
    with claimed_domain() as free:  # so that no other suite is in it either
        rclpy.init(context=context, domain_id=free)
        user = Node('user', context=context)
    try:
        with claimed_domain() as domain:
            assert domain != free
    finally:
        user.destroy_node()
        rclpy.shutdown(context=context)


def test_a_claim_ends_and_there_is_an_end_of_domains(monkeypatch):
    """What was given back can be had again; with nothing left, it is said."""
    only = min(DOMAINS) - 1  # which no test beside this one would take in between
    monkeypatch.setattr(domains, 'DOMAINS', [only])
    for _ in range(2):
        with claimed_domain() as claimed:
            assert claimed == only
            with pytest.raises(NoDomain, match=f'are taken on this host: {only} to {only}'):
                with claimed_domain():
                    pass


def test_linux_hands_out_no_port_of_these_domains():
    """Of 50 participants each; its own ports begin at 32768 and end at 60999."""
    for domain in DOMAINS:
        first, last = 7400 + 250 * domain, 7400 + 250 * domain + 11 + 2 * 49
        assert last < 32768 or 60999 < first <= last <= 65535
