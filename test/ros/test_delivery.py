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

"""Who can be waited for, and what the log says of who is."""
import importlib
import inspect
import types

from flag_sim.declarations.nodes import NODES
from flag_sim.protocol.frames import FrameId
from flag_sim.protocol.throttled_log import WARN_EVERY
from flag_sim.ros import delivery as module, node_log
from flag_sim.ros.delivery import check_delivery, Delivery
from flag_sim.ros.incompatible import UNKNOWN
from flag_sim.ros.topics import publishers
import pytest
from rclpy.serialization import serialize_message
from std_msgs.msg import Header
from support.watch import Watcher


@pytest.mark.parametrize('node', NODES)
def test_only_nodes_that_say_frame_done_are_waited_for(node):
    """The others of the package are refused by name."""
    source = inspect.getsource(importlib.import_module(f'flag_sim.nodes.{node}'))
    values = {'pace': 'realtime', 'wait_for': ['mine', node]}
    if "publish(self, 'frame_done')" in source:
        check_delivery(values)
    else:
        with pytest.raises(ValueError, match=f'recorder or your own; {node} sends none'):
            check_delivery(values)


@pytest.mark.parametrize('pace, wait_for, rule', [
    ('lockstep', [], 'needs at least one node in wait_for'),
    ('realtime', [''], "by letters, digits and _, without their namespace, not ''"),
    ('realtime', ['/film/renderer'], "not '/film/renderer'"),
])
def test_what_can_never_be_done_is_refused(pace, wait_for, rule):
    """The message names the rule and the value."""
    with pytest.raises(ValueError, match=rule):
        check_delivery({'pace': pace, 'wait_for': wait_for})


def test_a_stall_and_its_end_are_told_together(domain, capfd, monkeypatch):
    """A stall that was not told has no end; after one that was, the next is told soon."""
    now = [1000.0]
    clock = types.SimpleNamespace(monotonic=lambda: now[0])
    for place in (module, node_log):
        monkeypatch.setattr(place, 'time', clock)

    def stalled(number):
        """Let a frame be late and then done; return which of both were told."""
        message = Header(frame_id='slow')
        message.stamp.sec = number
        sender.send(FrameId(number * 10**9, 1, number, number), None, ['slow'], now[0])
        now[0] += 1.0
        sender.resend_overdue(now[0])
        sender._on_frame_done(serialize_message(message))
        said = capfd.readouterr().err
        return 'is not done' in said, 'is done' in said
    with Watcher(domain) as watcher:
        watcher.node.values = {'resend_after': 0.5}
        sender = Delivery(watcher.node, lambda sent: None, lambda: None)
        assert stalled(0) == (True, True)
        assert stalled(1) == (False, False)  # the same, a moment ago
        for number in range(2, 6):  # however often it comes
            now[0] += WARN_EVERY
            assert stalled(number) == (True, True)


def test_a_publisher_whose_node_is_not_known_yet_is_no_name():
    """DDS tells of the one before the other."""
    ends = []
    node = types.SimpleNamespace(resolve_topic_name=str,
                                 get_publishers_info_by_topic=lambda topic: ends)
    assert publishers(node, 'vertices') == ''
    ends.append(types.SimpleNamespace(node_name=UNKNOWN))
    assert publishers(node, 'vertices') == 'a node that is not known yet'
    ends.append(types.SimpleNamespace(node_name='physics'))
    assert publishers(node, 'vertices') == 'physics'
