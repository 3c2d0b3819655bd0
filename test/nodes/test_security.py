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

"""What docs/security.md says of sockets and of SROS 2 is what real nodes do."""
import contextlib
from pathlib import Path
import re
from xml.etree import ElementTree

from flag_sim.declarations.nodes import NODES
from flag_sim.parameters.config import config_path
from flag_sim.ros.bag import Bag
from flag_sim.ros.topics import TOPICS
import pytest
from rclpy.serialization import serialize_message
from support.forked import Graph
from support.watch import eventually, InVain, Watcher

POLICY = ElementTree.parse(config_path('sros2_policy.xml'))
KINDS = {'publish': 'publisher', 'subscribe': 'subscriber', 'reply': 'service',
         'request': 'client'}
"""What the policy calls the ends that a node has, and what rclpy calls them."""
RECORDABLE = sorted(name.lstrip('/') for name, topic in TOPICS.items()
                    if topic.every_frame or name == 'keyframe')
LOOPBACK, ANYWHERE = '0100007F', '00000000'
"""Addresses as /proc/net/udp has them."""


def allowed(node):
    """Return {what the policy calls an end: full names} of all that a node may have."""
    names = {kind: set() for kind in KINDS}
    for group in POLICY.find(f'.//profile[@node="{node}"]'):
        for kind in KINDS:
            if group.get(kind) == 'ALLOW':
                names[kind] |= {'/' + re.sub('^~', node, item.text).lstrip('/')
                                for item in group}
    return names


def ends(watcher, node):
    """Return {what the policy calls an end: full names} of all that a node is known to have."""
    if node not in watcher.node.get_node_names():
        return {kind: set() for kind in KINDS}
    return {kind: {name for name, _ in getattr(
        watcher.node, f'get_{called}_names_and_types_by_node')(node, '/')}
        for kind, called in KINDS.items()}


@pytest.fixture
def all_nodes(tmp_path, domain):
    """Start all nodes, with all that they can publish and subscribe to."""
    bag = Bag(tmp_path / 'played', 'mcap', 'none')
    for name in RECORDABLE:
        bag.add_topic(f'/{name}', TOPICS[name].message)
        bag.write(f'/{name}', 0, serialize_message(TOPICS[name].message()))
    bag.close()
    every = f'topics:=[{", ".join(RECORDABLE)}]'
    own = {'wind': ('-p', 'publish_clock:=true'),
           'recorder': ('-p', f'path:={tmp_path / "bag"}', '-p', every),
           'player': ('-p', f'path:={tmp_path / "played"}', '-p', every,
                      '-p', 'pace:=lockstep')}
    with Graph(tmp_path / 'logs', domain) as graph:
        for node in NODES:
            graph.start(node, *own.get(node, ()))
        yield graph


def test_the_policy_of_each_node_is_what_it_needs(all_nodes):
    """Every topic and service that a node has is allowed, and no other but its clock."""
    with Watcher(all_nodes.domain) as watcher:
        for node in NODES:
            may = allowed(node)
            with contextlib.suppress(InVain):
                # The viewer may have met the player before the nodes that it looks for.
                eventually(lambda: all(
                    may[kind] - {'/clock'} == ends(watcher, node)[kind] - {'/clock'}
                    for kind in KINDS), watcher)
            has = ends(watcher, node)
            for kind in KINDS:
                assert may[kind] - {'/clock'} == has[kind] - {'/clock'}, (node, kind)
                assert has[kind] <= may[kind], (node, kind)


def test_the_operator_reaches_every_parameter():
    """And may publish what the protocol leaves to a user: reset and step."""
    may = allowed('operator')
    for node in NODES:
        assert may['request'] >= allowed(node)['reply']
    assert may['publish'] == {'/reset', '/step', '/rosout', '/parameter_events'}
    assert may['subscribe'] >= {'/' + name.lstrip('/') for name in TOPICS} - {'/reset', '/step'}


def listens(pid, domain):
    """Return the addresses at which a process has sockets in a domain's range of ports."""
    inodes = set()
    for path in Path(f'/proc/{pid}/fd').iterdir():
        inodes |= set(re.findall(r'socket:\[(\d+)\]', str(path.readlink())))
    first = 7400 + 250 * domain
    addresses = set()
    for row in Path('/proc/net/udp').read_text().splitlines()[1:]:
        columns = row.split()
        address, port = columns[1].split(':')
        if columns[9] in inodes and first <= int(port, 16) < first + 250:
            addresses.add(address)
    return addresses


@pytest.mark.parametrize('profile, addresses', [
    ('fastdds.xml', {ANYWHERE}), ('fastdds_this_host.xml', {LOOPBACK}), ('', {LOOPBACK})])
def test_where_a_node_of_this_host_listens(tmp_path, domain, monkeypatch, profile, addresses):
    """LOCALHOST keeps no address out; the profile for this host, which it brings, does."""
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', profile and str(config_path(profile)))
    with Graph(tmp_path, domain) as graph:
        assert graph.environment['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
        wind = graph.start('wind')
        graph.wait_ready('wind')
        assert listens(wind.pid, domain) == addresses
        with Watcher(domain) as watcher:
            assert watcher.put(watcher.parameters_of('wind'), 'speed', 4.0).successful
