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

"""What imports what: nothing that stands higher, and nothing of ROS below the nodes."""
import ast
import importlib.util
from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROOMS = (
    ('jit', 'parameters', 'parallel'),
    ('animation', 'cloth', 'drawing', 'protocol'),
    ('declarations',),
    ('ros',),
    ('nodes',),
    ('study', 'tools'))
"""The folders of the package from the lowest up: what stands higher imports what stands lower."""
BELOW = {'jit': (), 'parameters': (), 'parallel': ('jit',), 'protocol': ('parameters',)}
"""Of these rooms alone, what they may import beside themselves."""
ROS = ('ros', 'nodes', 'tools')
MODULES = sorted(path for path in (ROOT / 'flag_sim').rglob('*.py')
                 if path.relative_to(ROOT).parts[1] not in ROS)
ALL = sorted((ROOT / 'flag_sim').rglob('*.py'))


def is_ros(module):
    top = module.partition('.')[0]
    return top.startswith(('rclpy', 'ament_')) or top.endswith(('_msgs', '_interfaces'))


def dotted(path):
    """Return the name by which a module is imported."""
    parts = path.relative_to(ROOT).with_suffix('').parts
    return '.'.join(parts[:-1] if parts[-1] == '__init__' else parts)


def imports(path):
    """Return the full names of all that a module imports, wherever in it the import stands."""
    here = dotted(path)
    package = here if path.name == '__init__.py' else here.rpartition('.')[0]
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = '.' * node.level + (node.module or '')
            base = importlib.util.resolve_name(base, package)
            # `from flag_sim import cloth` imports the module flag_sim.cloth
            names.update(f'{base}.{alias.name}' for alias in node.names)
    return names


@pytest.mark.parametrize('path', MODULES, ids=dotted)
def test_no_ros(path):
    assert not [name for name in imports(path) if is_ros(name)]


@pytest.mark.parametrize('path', ALL, ids=dotted)
def test_nothing_beside_or_above(path):
    room = (dotted(path).split('.') + [''])[1]
    height = next((height for height, rooms in enumerate(ROOMS) if room in rooms), None)
    assert height is not None or not room, f'{room} has no place among the rooms'
    below = {name for rooms in ROOMS[:height] for name in rooms} if room else ()
    allowed = {room, *BELOW.get(room, below)}
    assert not [name for name in imports(path)
                if name.startswith('flag_sim.') and name.split('.')[1] not in allowed]


def test_study_needs_no_ros():
    assert not [name for path in ALL if path.relative_to(ROOT).parts[1] == 'study'
                for name in imports(path)
                if name.startswith(('flag_sim.ros', 'flag_sim.nodes'))]


def test_imports_where_there_is_no_ros():
    hide = 'import importlib, sys; sys.modules["rclpy"] = None; '  # None: importing it fails
    modules = [dotted(path) for path in MODULES]
    done = subprocess.run(
        [sys.executable, '-c', hide + f'[importlib.import_module(name) for name in {modules}]'],
        cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
