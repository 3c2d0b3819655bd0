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

"""Params files in config/ set parameters that there are, to values that they take."""
from pathlib import Path

from flag_sim.animation import keys
from flag_sim.declarations.keyable import TARGETS
from flag_sim.declarations.nodes import defaults, named, scene
from flag_sim.declarations.objects import boxes_of
from flag_sim.declarations.scene import check_scene
import pytest
import yaml

CONFIG = Path(__file__).resolve().parents[2] / 'config'
RECIPES = ('flag_wind.yaml',)
"""What is no params file, but a dataset's recipe; test/dataset reads it."""
FILES = sorted(path for path in CONFIG.glob('*.yaml') if path.name not in RECIPES)


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.name)
def test_params_files_name_real_parameters(path):
    """Every value is one that its node accepts, in whatever namespace it is."""
    contents = {key.removeprefix('/**').removeprefix('/'): content['ros__parameters']
                for key, content in yaml.safe_load(path.read_text()).items()}
    shared = contents.pop('', {})
    assert shared.keys() <= {declaration.name for declaration in scene()}
    for name, given in contents.items():
        declarations = {**named(name), **{one.name: one for one in scene()}}
        given = {**shared, **given}
        for parameter, value in given.items():
            if not parameter.startswith('keys.'):
                declarations[parameter].accept(value)
        values = {**defaults(name), **given}
        if name in ('physics', 'renderer'):
            check_scene(values)
        if name == 'renderer':
            boxes_of(values)
        if name == 'wind':
            keys.read_timeline(values, TARGETS)
