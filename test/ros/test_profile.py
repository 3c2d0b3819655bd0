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
import re
import socket
import subprocess
import sys

from flag_sim.parameters.config import config_path
from flag_sim.ros.dds_profile import (
    FAR_PEERS, is_shm_shared, remove_dead_segments, set_dds_profile)
import pytest

OURS = str(config_path('fastdds.xml'))
HERE = {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
CHOICES = {
    'FASTDDS_DEFAULT_PROFILES_FILE': 'mine.xml', 'FASTRTPS_DEFAULT_PROFILES_FILE': 'mine.xml',
    'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4', 'FASTDDS_ENVIRONMENT_FILE': 'mine.json',
    'ROS2_EASY_MODE': '127.0.0.1', 'RMW_FASTRTPS_USE_QOS_FROM_XML': '1',
    'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp'}


@pytest.fixture(autouse=True)
def nothing_is_chosen(monkeypatch, tmp_path):
    """Take every choice away, as in a new shell."""
    monkeypatch.chdir(tmp_path)
    for name in (*CHOICES, *FAR_PEERS, 'ROS_AUTOMATIC_DISCOVERY_RANGE'):
        monkeypatch.delenv(name, raising=False)


def brought():
    """Return what set_dds_profile sets the variable of Fast DDS to, or leaves it at."""
    set_dds_profile()
    return os.environ.get('FASTDDS_DEFAULT_PROFILES_FILE')


@pytest.mark.parametrize('name, value', [
    ('X', ''), *((name, '') for name in CHOICES), ('RMW_FASTRTPS_USE_QOS_FROM_XML', '0'),
    ('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp'), ('ROS_DISCOVERY_SERVER', '127.0.0.1:11811'),
    ('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')])
def test_it_is_brought_where_nothing_is_chosen(monkeypatch, name, value):
    """Neither an empty variable nor a place to discover nodes at is a choice of transports."""
    monkeypatch.setenv(name, value)
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', '')  # so that it is restored
    assert brought() == OURS


@pytest.mark.parametrize('far', ['', *FAR_PEERS])
@pytest.mark.parametrize('reach', ['LOCALHOST', 'OFF'])
def test_on_one_host_messages_go_in_large_pieces(monkeypatch, reach, far):
    """Unless a way to other hosts is named as well."""
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', reach)
    monkeypatch.setenv('FASTDDS_DEFAULT_PROFILES_FILE', '')  # so that it is restored
    if far:
        monkeypatch.setenv(far, '10.0.0.2')
    assert brought() == (OURS if far else str(config_path('fastdds_local.xml')))


def settings(name):
    """Return the lines of a profile, without comments and the size of datagrams."""
    text = re.sub('(?s)<!--.*?-->', '', config_path(name).read_text())
    text = text.replace('<maxMessageSize>1400</maxMessageSize>', '')
    return [line.strip() for line in text.splitlines() if line.strip()]


def test_the_profiles_differ_only_in_how_messages_travel():
    """By the size of datagrams, and by shared memory."""
    ours = settings('fastdds.xml')
    assert settings('fastdds_local.xml') == ours
    begin, end = (ours.index(f'<{mark}transport_descriptor>') for mark in ('', '/'))
    without = ours[:begin] + ours[end + 1:]
    without.remove('<transport_id>large_shared_memory</transport_id>')
    assert settings('fastdds_udp.xml') == without


@pytest.mark.parametrize('name', CHOICES)
def test_a_variable_of_the_users_wins(monkeypatch, name):
    """Whichever it is."""
    monkeypatch.setenv(name, CHOICES[name])
    assert brought() == (CHOICES[name] if name == 'FASTDDS_DEFAULT_PROFILES_FILE' else None)


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
        env={**os.environ, **HERE, 'ROS_DOMAIN_ID': str(domain), **environment})
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
                          env={**os.environ, **HERE, 'ROS_DOMAIN_ID': str(domain)})
    left = set(done.stdout.split())
    assert left
    for name in left:
        assert os.path.exists(name)
        os.utime(f'{name}_el', (1, 1))
    remove_dead_segments()
    assert not any(os.path.exists(name) for name in left)


def test_memory_is_shared_unless_somebody_says_otherwise(tmp_path):
    """A claim on another folder, or on the same one, as from another container."""
    assert is_shm_shared()
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
        other.bind('\0flag_sim/shm/1:1/1')
        assert not is_shm_shared()
    assert is_shm_shared()
    assert not is_shm_shared(tmp_path / 'missing')
