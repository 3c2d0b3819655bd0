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

"""The profile that the nodes bring to Fast DDS, and that any choice of the user's wins over it."""
import fcntl
import os
from pathlib import Path
import shutil
import socket
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

from flag_sim.parameters.config import config_path
from flag_sim.ros import dds_profile
from flag_sim.ros.dds_profile import is_shm_shared, remove_dead_segments, set_dds_profile
from flag_sim.ros.dead_ports import bury_dead_ports, SHM
import pytest

OURS = str(config_path('fastdds.xml'))
CHOICES = {
    'FASTDDS_DEFAULT_PROFILES_FILE': 'mine.xml', 'FASTRTPS_DEFAULT_PROFILES_FILE': 'mine.xml',
    'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4', 'FASTDDS_ENVIRONMENT_FILE': 'mine.json',
    'ROS2_EASY_MODE': '127.0.0.1', 'RMW_FASTRTPS_USE_QOS_FROM_XML': '1',
    'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}
ROS_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_STATIC_PEERS', 'ROS_DISCOVERY_SERVER'


@pytest.fixture(autouse=True)
def nothing_is_chosen(monkeypatch, tmp_path):
    """Take every choice away, as in a new shell."""
    monkeypatch.chdir(tmp_path)
    for name in (*CHOICES, *ROS_RANGE):
        monkeypatch.delenv(name, raising=False)


def brought():
    """Return what set_dds_profile sets the variable of Fast DDS to, or leaves it at."""
    set_dds_profile()
    return os.environ.get('FASTDDS_DEFAULT_PROFILES_FILE')


@pytest.mark.parametrize('name, value', [
    ('X', ''), *((name, '') for name in CHOICES), ('RMW_FASTRTPS_USE_QOS_FROM_XML', '0'),
    ('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp'), ('ROS_DISCOVERY_SERVER', '127.0.0.1:11811')])
def test_it_is_brought_where_nothing_is_chosen(monkeypatch, name, value):
    """Neither an empty variable nor a place to discover nodes at is a choice of transports."""
    monkeypatch.setenv(name, value)
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', '')  # so that it is restored
    assert brought() == OURS


@pytest.mark.parametrize('discovery, names, profile', [
    ('', '', 'fastdds.xml'), ('SUBNET', '', 'fastdds.xml'), ('OFF', '', 'fastdds.xml'),
    ('LOCALHOST', '', 'fastdds_this_host.xml'), ('LOCALHOST', 'ROS_STATIC_PEERS', 'fastdds.xml'),
    ('LOCALHOST', 'ROS_DISCOVERY_SERVER', 'fastdds.xml')])
def test_nodes_that_look_for_others_on_their_host_alone_cut_no_messages(
        monkeypatch, discovery, names, profile):
    """A peer or a server that is named may be on another host."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', discovery)
    if names:
        monkeypatch.setenv(names, '10.77.0.1')
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', '')  # so that it is restored
    assert brought() == str(config_path(profile))


@pytest.mark.parametrize('name', CHOICES)
def test_a_variable_of_the_users_wins(monkeypatch, name):
    """Whichever it is."""
    monkeypatch.setenv(name, CHOICES[name])
    assert brought() == (CHOICES[name] if name == 'FASTDDS_DEFAULT_PROFILES_FILE' else None)


def content(name):
    """Return a file's profiles, {where: text}, and its transports, {type: {where: text}}."""
    root = ElementTree.parse(config_path(name)).getroot()
    for element in root.iter():
        element.tag = element.tag.rpartition('}')[2]
    profiles = root.find('profiles')
    kinds = {one.findtext('transport_id'): one.findtext('type')
             for one in profiles.iter('transport_descriptor')}
    transports = {one.findtext('type'): texts(one)
                  for one in profiles.iter('transport_descriptor')}
    used = profiles.find('participant/rtps/userTransports')
    assert {kinds[one.text] for one in used} == set(transports) == set(kinds.values())
    profiles.remove(profiles.find('transport_descriptors'))
    used.clear()
    return texts(profiles), transports


def texts(element, where=''):
    """Return {path and attributes: text} of what is in an element of XML, but names of ours."""
    found = {}
    for child in element:
        if child.tag != 'transport_id':
            path = f'{where}/{child.tag}{sorted(child.attrib.items())}'
            found[path] = (child.text or '').strip()
            found.update(texts(child, path))
    return found


def test_the_profiles_differ_in_their_transports_and_heartbeats_only():
    """On this host next to nothing is lost: UDP need not be short, and heartbeats are rarer."""
    (everywhere, all_transports), (udp, without_shm), (here, inside) = map(
        content, ('fastdds.xml', 'fastdds_udp.xml', 'fastdds_this_host.xml'))
    assert everywhere == udp
    assert {(everywhere[path], here[path]) for path in everywhere.keys()
            | here.keys() if everywhere[path] != here[path]} == {('10000000', '100000000')}
    assert without_shm == {'UDPv4': all_transports['UDPv4']}
    loopback = {name: text for name, text in inside['UDPv4'].items() if 'White' not in name}
    assert loopback == {name: text for name, text in all_transports['UDPv4'].items()
                        if 'maxMessageSize' not in name}
    assert inside['SHM'] == all_transports['SHM']


@pytest.mark.parametrize('name', ['DEFAULT_FASTDDS_PROFILES.xml', 'DEFAULT_FASTRTPS_PROFILES.xml'])
def test_a_profile_in_the_working_directory_wins(tmp_path, name):
    """Fast DDS 3 reads the one, Fast DDS 2 the other."""
    (tmp_path / name).touch()
    assert brought() is None


LARGEST_SEGMENT = """
from flag_sim.ros.dds_profile import set_dds_profile
import os, re
import rclpy
set_dds_profile()
with rclpy.init():
    node = rclpy.create_node('n')
    print(max(int(end, 16) - int(begin, 16) for begin, end in re.findall(
        '(?m)^(\\w+)-(\\w+) .*/dev/shm/fastdds_', open('/proc/self/maps').read())))
"""


@pytest.mark.parametrize('environment, is_ours', [
    ({}, True), ({'ROS_DISCOVERY_SERVER': '127.0.0.1:11811'}, True),
    ({'FASTDDS_BUILTIN_TRANSPORTS': 'DEFAULT'}, False)])
def test_what_is_chosen_is_what_fast_dds_does(domain, environment, is_ours):
    """Its shared memory holds many pictures with our profile, else the stock half megabyte."""
    done = subprocess.run(
        [sys.executable, '-c', LARGEST_SEGMENT], check=True, capture_output=True, text=True,
        env={**os.environ, 'ROS_DOMAIN_ID': str(domain), **environment})
    assert (int(done.stdout) > 20_000_000) == is_ours, done.stdout


def test_segments_of_killed_processes_are_removed(tmp_path):
    """What somebody holds, and what is none of Fast DDS's segments, stays."""
    dead, alive, young, begun = (f'fastdds_{digit * 16}' for digit in '0abc')
    stay = {alive, f'{alive}_el', young, f'{young}_el', begun, 'fastdds_port7000_el', 'mine'}
    for name in (dead, f'{dead}_el', *stay):
        (tmp_path / name).touch()
        if young not in name:
            os.utime(tmp_path / name, (1, 1))
    with open(tmp_path / f'{alive}_el') as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        remove_dead_segments(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == stay


KILLED = """
from flag_sim.ros.dds_profile import set_dds_profile
import os, re
import rclpy
set_dds_profile()
rclpy.init()
node = rclpy.create_node('n')
maps = open('/proc/self/maps').read()
print(*re.findall('(?m)/dev/shm/fastdds_[0-9a-f]{16}$', maps), flush=True)
os.kill(os.getpid(), 9)
"""


def test_a_killed_node_leaves_nothing_for_long(domain):
    """Its segment is gone once another node starts."""
    done = subprocess.run([sys.executable, '-c', KILLED], capture_output=True, text=True,
                          env={**os.environ, 'ROS_DOMAIN_ID': str(domain)})
    left = set(done.stdout.split())
    assert left
    for name in left:
        assert os.path.exists(name)
        os.utime(f'{name}_el', (1, 1))
    remove_dead_segments()
    assert not any(os.path.exists(name) for name in left)


def test_memory_is_shared_unless_somebody_says_otherwise(tmp_path, monkeypatch):
    """A claim on another folder, or on the same one, as from another container."""
    # By names of its own: nodes that others start meanwhile would find no shared memory.
    monkeypatch.setattr(dds_profile, 'CLAIM', f'@flag_sim/test-{os.getpid()}/')
    monkeypatch.setattr(dds_profile, '_claims', claims := [])
    assert is_shm_shared()
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
        other.bind(f'\0{dds_profile.CLAIM[1:]}1:1/1')
        assert not is_shm_shared()
    assert is_shm_shared()
    assert not is_shm_shared(tmp_path / 'missing')
    (claim,) = claims
    assert claim.getsockname().startswith(f'\0{dds_profile.CLAIM[1:]}'.encode())
    claim.close()


LISTENING = """
from flag_sim.ros.dds_profile import set_dds_profile
import rclpy
set_dds_profile()
rclpy.init()
node = rclpy.create_node('n')
print(flush=True)
input()
"""


def locked_by(process):
    """Return the ports of Fast DDS that a process reads, as files of their memory."""
    locks = {int(line.split()[5].rpartition(':')[2]) for line in Path('/proc/locks').open()
             if line.split()[4] == str(process)}
    return [path.with_name(path.name.removesuffix('_el')) for path in SHM.glob('fastdds_port*_el')
            if path.stat().st_ino in locks]


def is_ok(port):
    """Return whether a port's flags say that it is in order; they are where Fast DDS has them."""
    memory = port.read_bytes()
    number = int(port.name.removeprefix('fastdds_port'))
    *_, wait, _, _, flags = struct.unpack_from('=6IB', memory, memory.find(
        struct.pack('=I', number), memory.find(struct.pack('=2I', 1000, 333)) - 8))
    assert wait == 333
    return bool(flags & 1)


def test_ports_of_killed_nodes_are_marked_and_those_of_the_living_are_not(domain, tmp_path):
    """Else others may write to them for ever, and never to the node that is started again."""
    nodes = [subprocess.Popen([sys.executable, '-c', LISTENING], stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE,
                              env={**os.environ, 'ROS_DOMAIN_ID': str(domain)})
             for _ in range(2)]
    try:
        for node in nodes:
            node.stdout.readline()
        dead, alive = (locked_by(node.pid) for node in nodes)
        assert dead and alive and all(map(is_ok, dead + alive))
        nodes[0].kill()
        nodes[0].wait()
        for port in dead:  # ours alone: nobody else marks them meanwhile
            for name in port.name, f'{port.name}_el':
                shutil.copy(SHM / name, tmp_path)
        (tmp_path / 'fastdds_port1').write_bytes(b'another layout')
        (tmp_path / 'fastdds_port1_el').touch()
        bury_dead_ports(tmp_path)
        bury_dead_ports()
        assert not any(is_ok(tmp_path / port.name) for port in dead)
        assert all(map(is_ok, alive))
    finally:
        for node in nodes:
            node.kill()
            node.communicate()
