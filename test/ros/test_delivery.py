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

"""Who can be waited for: nodes that say when a frame is done."""
import importlib
import inspect

from flag_sim.declarations.nodes import NODES
from flag_sim.ros.delivery import check_delivery
import pytest


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
