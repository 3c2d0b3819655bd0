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

"""What the recorder and the player do with takes, bytes, disks and bags as they should not be."""
from flag_sim.nodes.graph import Graph


def test_a_topic_named_twice_is_refused(tmp_path, domain):
    """Before anything is made: no folder is left that stands in the next one's way."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('recorder', '-p', f'path:={tmp_path / "bag"}', '-p',
                    'topics:=[vertices, vertices]')
        assert graph.wait('recorder', 30.0) == 1
        assert "topics: each is named once, but 'vertices' more often" in graph.log('recorder')
        assert 'Traceback' not in graph.log('recorder')
    assert not (tmp_path / 'bag').exists()
