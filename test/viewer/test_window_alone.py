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

"""The window where nodes are missing, or have other names."""
from support.window import Desk


def test_without_nodes_it_says_what_to_start(domain):
    with Desk(domain, names=()) as desk:
        desk.until(lambda: desk.window.view.reason)
        for name in ('wind', 'physics', 'renderer'):
            assert f'ros2 run flag_sim {name}' in desk.window.view.reason
        desk.window.save('nothing.yaml')
        assert 'no node' in desk.window.statusBar().currentMessage()


def test_nodes_are_known_by_what_they_do(domain):
    """In any namespace; what is set reaches them, and what they say is shown."""
    with Desk(domain, 'paused:=true', namespace='/left') as desk:
        assert desk.model.nodes == {name: f'/left/{name}' for name in desk.nodes}
        desk.model.put('physics', {'gravity': 1.62})
        desk.until(lambda: desk.value('physics', 'gravity') == 1.62)
        desk.until(lambda: desk.window.view.reason.startswith('The wind is paused'))
