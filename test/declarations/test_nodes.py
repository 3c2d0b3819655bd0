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

"""What each node declares, and what it costs to know it."""
import subprocess
import sys

from flag_sim.declarations.nodes import defaults, named, NODES
import pytest


def test_nodes_are_found_by_their_names():
    assert list(NODES) == ['wind', 'physics', 'renderer', 'recorder', 'player', 'viewer']
    assert len(NODES) == 6
    with pytest.raises(KeyError):
        NODES['factories']
    assert named('wind')['speed'].default == defaults('wind')['speed'] == 6.0


@pytest.mark.parametrize('node', ['recorder', 'player', 'viewer'])
def test_who_knows_no_cloth_and_no_picture_loads_no_compiler(node):
    """Which would take 0.3 s and 70 MB more at every start."""
    code = (f'from flag_sim.declarations.nodes import NODES; NODES["{node}"]; '
            'import sys; sys.exit("numba" in sys.modules)')
    assert subprocess.run([sys.executable, '-c', code]).returncode == 0
