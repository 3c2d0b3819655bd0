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

"""What imports what: each room only those below it, and nothing of ROS below `ros`."""
import ast
import importlib.util
from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIBRARY = ('cloth', 'drawing', 'jit', 'parallel', 'parameters')
ROOMS = {
    '': (),  # flag_sim/__init__.py
    'jit': (),
    'parallel': ('jit',),
    'parameters': (),
    'animation': ('parameters',),
    'cloth': ('jit', 'parallel', 'parameters'),
    'drawing': ('jit', 'parallel', 'parameters'),
    'protocol': (),
    'declarations': (*LIBRARY, 'animation', 'protocol'),
    'ros': ('animation', 'declarations', 'drawing', 'jit', 'parameters', 'protocol'),
    'nodes': (*LIBRARY, 'animation', 'declarations', 'protocol', 'ros', 'viewer'),
    'dataset': (*LIBRARY, 'animation', 'declarations', 'protocol', 'ros'),
    'study': (*LIBRARY, 'animation', 'declarations'),
    'viewer': ('animation', 'parameters', 'protocol'),
    'testing': ('declarations', 'parameters', 'tools'),
    'tools': ('cloth', 'dataset', 'drawing', 'parameters', 'protocol', 'viewer'),
}
"""Of every folder of the package, the others that it may import."""
WITH_ROS = ('ros', 'nodes')
"""The folders that need ROS to be imported."""
ALL = sorted((ROOT / 'flag_sim').rglob('*.py'))
PURE = [path for path in ALL if path.relative_to(ROOT).parts[1] not in WITH_ROS]
NODES = ('wind', 'physics', 'renderer', 'recorder', 'player', 'viewer')


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


def test_the_rooms_have_an_order():
    """Each may import only rooms that may not import it, not even by way of others."""
    heights = {}
    for _ in ROOMS:
        heights |= {room: 1 + max((heights[name] for name in below), default=0)
                    for room, below in ROOMS.items() if all(name in heights for name in below)}
    assert heights.keys() == ROOMS.keys()


@pytest.mark.parametrize('path', PURE, ids=dotted)
def test_no_ros(path):
    assert not [name for name in imports(path) if is_ros(name)]


@pytest.mark.parametrize('path', ALL, ids=dotted)
def test_nothing_beside_or_above(path):
    room = (dotted(path).split('.') + [''])[1]
    assert room in ROOMS, f'{room} has no place among the rooms'
    allowed = {room, *ROOMS[room]}
    assert not [name for name in imports(path)
                if name.startswith('flag_sim.') and name.split('.')[1] not in allowed]


def test_nodes_are_nodes_alone():
    """What they share or compute stands in another room."""
    found = {path.stem for path in (ROOT / 'flag_sim' / 'nodes').glob('*.py')}
    assert found == {'__init__', *NODES}


def test_imports_where_there_is_no_ros():
    hide = 'import importlib, sys; sys.modules["rclpy"] = None; '  # None: importing it fails
    modules = [dotted(path) for path in PURE]
    done = subprocess.run(
        [sys.executable, '-c', hide + f'[importlib.import_module(name) for name in {modules}]'],
        cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
