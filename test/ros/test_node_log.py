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

"""What a node's log holds of what it is told again and again."""
from flag_sim.protocol.throttled_log import Entry
from flag_sim.ros import node_log
from flag_sim.ros.node_log import NodeLog
import pytest
from support.watch import eventually, Watcher


@pytest.mark.usefixtures('still_log')
def test_each_level_is_written_and_repetitions_are_not(domain, capfd):
    """One object writes all levels, which rclpy lets no line of code do."""
    with Watcher(domain) as watcher:
        log = NodeLog(watcher.node)
        for level in ('info', 'warning', 'error'):
            log.write(Entry(level, f'a line of {level}'))
        for number in range(5):
            log.warn(f'reason {number}')
            log.error(f'failure {number}')
        said = capfd.readouterr().err
    for level, words in (('INFO', 'a line of info'), ('WARN', 'a line of warning'),
                         ('ERROR', 'a line of error'), ('WARN', 'reason 0'),
                         ('ERROR', 'failure 0')):
        assert any(f'[{level}]' in line and words in line for line in said.splitlines())
    assert 'reason 1' not in said and 'failure 1' not in said


def test_a_wait_is_watched(domain, capfd, monkeypatch):
    """By a timer of the node."""
    monkeypatch.setattr(node_log, 'POLL_PERIOD', 0.01)
    heard = []
    with Watcher(domain) as watcher:
        NodeLog(watcher.node).watch(lambda: 'vertices', lambda: 0)
        eventually(lambda: heard.append(capfd.readouterr().err)
                   or 's for vertices' in heard[-1], watcher)
    assert ''.join(heard).count('waiting for') == 1
