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

"""QoS overrides of every topic of every node: refused, ignored with words, or taken."""
import contextlib
import importlib
import re

from flag_sim.declarations.nodes import NODES
from flag_sim.ros.bag import Bag
from flag_sim.ros.parameter_node import BadParameter
from flag_sim.ros.topics import publish, subscribe
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import PointCloud2
from support.forked import Graph
from support.watch import eventually, Watcher


@contextlib.contextmanager
def running(name, domain, tmp_path, *overrides):
    """Run a node in this process with QoS overrides, such as '/wind.publisher.depth:=1'."""
    module = importlib.import_module(f'flag_sim.nodes.{name}')
    given = [part for override in overrides for part in ('-p', f'qos_overrides.{override}')]
    path = tmp_path / f'new{len(list(tmp_path.iterdir()))}'
    if name == 'player':
        bag = Bag(path, 'mcap', 'none')
        bag.add_topic('/parameters', ParameterEvent)
        bag.close()
    with rclpy.init(domain_id=domain, args=['--ros-args', '-p', f'path:={path}', *given]):
        node = getattr(module, name.capitalize())()
        node.tell_of_ignored()
        yield node
        node.close()
        node.destroy_node()


def entities(node):
    """Return the ends of topics that a node lets be overridden, such as '/wind.publisher'."""
    return sorted({name.rpartition('.')[0]
                   for name in node.get_parameters_by_prefix('qos_overrides')})


@pytest.mark.parametrize('name', NODES)
def test_nonsense_is_refused_of_every_topic(tmp_path, domain, name):
    """By the name of the parameter, the rule and the value; not by a traceback of rclpy."""
    with running(name, domain, tmp_path) as node:
        ends = entities(node)
    assert len(ends) >= 2
    for end in ends:
        for override, rule in ((f'{end}.reliability:=besteffort',
                                'must be one of reliable, best_effort, system_default, '
                                "best_available, not 'besteffort'"),
                               (f'{end}.depth:=-1', 'must be a whole number from 1 to')):
            with pytest.raises(BadParameter) as refusal:
                with running(name, domain, tmp_path, override):
                    pass
            assert f'qos_overrides.{override.partition(":=")[0]} {rule}' in str(refusal.value)


@pytest.mark.parametrize('policy, rule', [
    ('history:=all', "one of keep_last, keep_all, system_default, not 'all'"),
    ('history:=unknown', "not 'unknown'"), ('reliability:=unknown', "not 'unknown'"),
    ('reliability:=5', 'not 5'), ('depth:=0', 'not 0'), ('depth:=2.5', 'not 2.5'),
    ('depth:=ten', "not 'ten'"), ('depth:=true', 'not True'), ('depth:=3000000000', 'not 3000')])
def test_what_a_policy_cannot_be_is_refused(tmp_path, domain, policy, rule):
    """Whether rclpy or the middleware would stumble over it, or nobody."""
    with pytest.raises(BadParameter) as refusal:
        with running('wind', domain, tmp_path, f'/parameters.publisher.{policy}'):
            pass
    assert rule in str(refusal.value)


@pytest.mark.parametrize('override, words', [
    ('/parameters.publisher.reliabilty:=reliable',
     'of this one depth, history, reliability can be set'),
    ('/parameters.publisher.durability:=volatile',
     'of this one depth, history, reliability can be set'),
    ('/parmeters.publisher.depth:=2',
     "the nearest that it does is 'qos_overrides./parameters.publisher.depth'"),
    ('/parameters.publsher.depth:=2',
     "the nearest that it does is 'qos_overrides./parameters.publisher.depth'"),
    ('/parameters.subscription.depth:=2', 'lets no such topic and policy be set'),
    ('/vertices.publisher.depth:=besteffort', 'lets no such topic and policy be set'),
    ('/parameter_events.subscription.depth:=2', 'lets no such topic and policy be set')])
def test_what_nothing_takes_is_told(tmp_path, domain, capfd, override, words):
    """A file for all nodes may hold what only another one has; hence it is no refusal."""
    with running('wind', domain, tmp_path, override):
        pass
    said = capfd.readouterr().err
    assert f"parameter 'qos_overrides.{override.partition(':=')[0]}' is ignored: " in said
    assert words in said


def test_an_override_counts_for_its_topic_by_its_full_name(tmp_path, domain, capfd):
    """In capitals too, as rclpy takes them; while running nothing of it can be changed."""
    with running('wind', domain, tmp_path, '/parameters.publisher.reliability:=BEST_EFFORT',
                 '/wind.publisher.depth:=3') as node:
        (end,) = node.get_publishers_info_by_topic('/parameters')
        assert end.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
        for name in ('/wind.publisher.depth', '/none.publisher.depth'):
            (result,) = node.set_parameters([Parameter(f'qos_overrides.{name}', value=4)])
            assert result.reason == f'qos_overrides.{name} is fixed at the start of the node'
    assert "publisher.depth' is ignored" not in capfd.readouterr().err


def test_a_bad_override_is_one_clear_line(tmp_path, domain):
    """And what is ignored is told by the node itself."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('wind', '-p', 'qos_overrides./parameters.publisher.depth:=-1')
        graph.start('wind', '-p', 'qos_overrides./parameters.publisher.dept:=1', '-p', 'frames:=1',
                    '-p', 'wait_for:=[]', name='second')
        assert graph.wait('wind', 90.0) == 1 and graph.wait('second', 30.0) == 0
        assert graph.log('wind').startswith('refused: qos_overrides./parameters.publisher.depth ')
        assert len(graph.log('wind').splitlines()) == 1
        assert "publisher.dept' is ignored" in graph.log('second')


def test_who_cannot_be_served_or_heard_is_told_with_the_topic_and_what_helps(domain, capfd):
    """Once, although a stranger comes again and again."""
    said = []
    with Watcher(domain) as watcher, Watcher(domain) as stranger:
        publish(watcher.node, 'vertices')
        subscribe(watcher.node, 'parameters', print)
        for _ in range(3):
            late = stranger.node.create_subscription(PointCloud2, 'vertices', print, QoSProfile(
                depth=8, durability=DurabilityPolicy.TRANSIENT_LOCAL))
            weak = stranger.node.create_publisher(ParameterEvent, 'parameters', QoSProfile(
                depth=8, reliability=ReliabilityPolicy.BEST_EFFORT))
            eventually(lambda: watcher.node.count_subscribers('vertices')
                       and watcher.node.count_publishers('parameters'), watcher)
            eventually(lambda: said.append(capfd.readouterr().err) or {
                '/vertices', '/parameters'} <= set(re.findall(r'\]: (/\w+): ', ''.join(said))),
                watcher)
            stranger.node.destroy_subscription(late)
            stranger.node.destroy_publisher(weak)
            eventually(lambda: not watcher.node.count_subscribers('vertices')
                       and not watcher.node.count_publishers('parameters'), watcher)
    # On a busy machine DDS may not have told its name yet.
    lines = [line.partition(']: ')[2].replace('somebody', 'watcher')
             for line in ''.join(said).splitlines() if '[WARN]' in line]
    assert sorted(line for line in lines if line.startswith('/')) == [
        '/parameters: watcher publishes it without the quality of service that this node needs, '
        'and is not heard; give both the same reliability: this node by '
        'qos_overrides./parameters.subscription.reliability',
        '/vertices: watcher subscribes to it with a quality of service that this node does not '
        'offer, and receives nothing; give both the same durability']
