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

"""Simulation and drawing know nothing of ROS, and nothing of one another."""
import ast
import importlib.util
from pathlib import Path
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAYERS = ('animation', 'cloth', 'drawing')
# What stands above them: dials make cloths and looks for study and nodes.
ABOVE = {'study': {'nodes'}, 'dials': {'nodes', 'study'}}
MODULES = sorted(path for path in (ROOT / 'flag_sim').rglob('*.py') if path.parent.name != 'nodes')


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


@pytest.mark.parametrize('path', MODULES, ids=dotted)
def test_nothing_beside_or_above(path):
    own = (dotted(path).split('.') + [''])[1]
    others = ABOVE.get(own, {*LAYERS, *ABOVE, 'nodes'} - {own})
    assert not [name for name in imports(path)
                if name.startswith('flag_sim.') and name.split('.')[1] in others]


def test_imports_where_there_is_no_ros():
    hide = 'import importlib, sys; sys.modules["rclpy"] = None; '  # None: importing it fails
    modules = [dotted(path) for path in MODULES]
    done = subprocess.run(
        [sys.executable, '-c', hide + f'[importlib.import_module(name) for name in {modules}]'],
        cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
