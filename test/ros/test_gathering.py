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

"""Whom a sender in real time waits for before it begins, and how long."""
import contextlib
import time
from types import SimpleNamespace

from flag_sim.nodes.wind import Wind
from flag_sim.ros import gathering
from flag_sim.ros.gathering import Gathering
from flag_sim.ros.messages import to_stamp
from flag_sim.ros.topics import publish, subscribe
import pytest
import rclpy
from support.watch import eventually

LATE = 1e9  # a time by which nobody waits any more [s]
CLOCK = SimpleNamespace(spin=lambda: time.sleep(0.01))  # stands in for a watcher: no node is spun


@contextlib.contextmanager
def nodes(domain, *names):
    """Yield nodes of these names in one process."""
    with rclpy.init(domain_id=domain), contextlib.ExitStack() as stack:
        made = [rclpy.create_node(name) for name in names]
        for node in made:
            stack.callback(node.destroy_node)
        yield made


@pytest.fixture
def patient(monkeypatch):
    """Let nobody begin because time is over, however busy the machine is."""
    monkeypatch.setattr(gathering, 'LONGEST', LATE / 2.0)


def test_a_sender_begins_when_all_are_there(domain, patient, capfd):
    """One that is not waited for, or is in another namespace, makes no difference."""
    with nodes(domain, 'wind', 'physics', 'renderer', 'other') as (wind, *others):
        publish(wind, 'parameters')
        waits = Gathering(wind, 'parameters', ['physics', 'renderer'])
        for node in reversed(others):
            assert not waits.is_over(time.monotonic())
            subscribe(node, 'parameters', lambda message: None)
        eventually(lambda: waits.is_over(time.monotonic()), CLOCK)
    assert 'begins without' not in capfd.readouterr().err


def test_time_is_over_for_who_does_not_come(domain, patient, capfd):
    """It is said who that is, once, and the sender goes on whoever leaves."""
    with nodes(domain, 'wind', 'renderer') as (wind, renderer):
        publish(wind, 'parameters')
        told = []
        waits = Gathering(wind, 'parameters', ['physics', 'renderer', 'recorder'],
                          lambda: told.append(True))
        subscription = subscribe(renderer, 'parameters', lambda message: None)
        eventually(lambda: wind.count_subscribers('parameters'), CLOCK)
        assert not waits.is_over(time.monotonic())
        assert waits.is_over(LATE)
        renderer.destroy_subscription(subscription)
        assert waits.is_over(time.monotonic()) and told == [True]
    said = capfd.readouterr().err
    assert said.count('begins without physics, recorder: no node of this name') == 1


def test_whoever_comes_or_nobody_is_waited_for(domain, patient):
    """A sender of images knows of no names; who waits for nobody begins at once."""
    with nodes(domain, 'player', 'viewer') as (player, viewer):
        publish(player, 'camera/image_raw')
        anybody = Gathering(player, 'camera/image_raw', None)
        assert not anybody.is_over(time.monotonic())
        assert Gathering(player, 'camera/image_raw', []).is_over(time.monotonic())
        subscribe(viewer, 'camera/image_raw', lambda message: None)
        eventually(lambda: anybody.is_over(time.monotonic()), CLOCK)


def test_a_wind_in_real_time_loses_no_first_frame(domain, patient):
    """Who is discovered a moment later hears the shot from its first frame on."""
    arguments = ['--ros-args', '-p', 'frames:=1', '-p', 'rate:=200.0']
    heard = {'physics': [], 'renderer': []}
    with rclpy.init(domain_id=domain, args=arguments), contextlib.ExitStack() as stack:
        wind = Wind()
        stack.callback(wind.destroy_node)
        others = {}
        for name, messages in heard.items():
            for _ in range(20):  # in which time the shot would be over
                rclpy.spin_once(wind, timeout_sec=0.005)
            assert wind._take.clock.index == 0
            others[name] = rclpy.create_node(name, use_global_arguments=False)
            stack.callback(others[name].destroy_node)
            subscribe(others[name], 'parameters', messages.append)

        def is_heard():
            for node in (wind, *others.values()):
                rclpy.spin_once(node, timeout_sec=0.01)
            return all(len(messages) == 1 for messages in heard.values())
        eventually(is_heard, CLOCK)
    for messages in heard.values():
        assert [to_stamp(message.stamp) for message in messages] == [0]
