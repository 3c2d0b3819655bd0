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

"""Parameters, params files and keyframes in the docs and in config/ are those of the code."""
from pathlib import Path
import re

from flag_sim.animation import keys
from flag_sim.declarations.nodes import defaults, named, NODES, SCENE
from flag_sim.declarations.targets import TARGETS
import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
PARAMETERS = (ROOT / 'docs' / 'parameters.md').read_text()
GROUPS = {'scene': SCENE, **{node: [one for one in declarations if one not in SCENE]
                             for node, declarations in NODES.items()}}


def rows_of(declarations):
    """Return the table rows for some parameters."""
    for declaration in declarations:
        default = declaration.default
        default = ', '.join(map(str, default)) if declaration.is_list else default
        if isinstance(default, float):
            default = f'{default:.4g}'
        if isinstance(default, bool):
            default = str(default).lower()
        if declaration.choices:
            legal = ', '.join(map(str, declaration.choices))
        elif declaration.low is None:
            legal = ''
        else:
            digits = 'd' if isinstance(declaration.default, int) else '.4g'
            legal = f'{declaration.low:{digits}} to {declaration.high:{digits}}'
        yield (f'| `{declaration.name}` | {default if default != "" else "(empty)"} | {legal} '
               f'| {declaration.unit} | {declaration.effect} |')


@pytest.mark.parametrize('group', GROUPS)
def test_the_table_of_parameters_is_the_codes(group):
    """Every parameter has its row, word for word, and there are no others."""
    section = re.search(rf'## {group}\n(.*?)(?=\n#|\Z)', PARAMETERS, re.DOTALL)
    assert section, f'no section {group}'
    rows = [row for row in section[1].splitlines() if row.startswith('| `')]
    assert rows == list(rows_of(GROUPS[group]))


@pytest.mark.parametrize('path', sorted((ROOT / 'config').glob('*.yaml')), ids=lambda p: p.name)
def test_params_files_name_real_parameters(path):
    """Every value in config/ is one that its node accepts, in whatever namespace it is."""
    for node, content in yaml.safe_load(path.read_text()).items():
        declarations = named(node.removeprefix('/**/'))
        for name, value in content['ros__parameters'].items():
            if not name.startswith('keys.'):
                declarations[name].accept(value)
        if node == '/**/wind':
            values = {name: declaration.default for name, declaration in declarations.items()}
            keys.read_timeline({**values, **content['ros__parameters']}, TARGETS)


KEYFRAMES = (ROOT / 'docs' / 'keyframes.md').read_text()
EXAMPLES = [yaml.safe_load(block)['/wind']['ros__parameters']
            for block in re.findall(r'```yaml\n(.*?)```', KEYFRAMES, re.DOTALL)]
DEFAULTS = defaults('wind')


@pytest.mark.parametrize('example', EXAMPLES, ids=lambda example: example['tracks'][0])
def test_the_examples_of_keyframes_play_without_a_warning(example):
    """All keys that they show are good ones, of the parameters that there are."""
    for name in example.keys() - DEFAULTS.keys():
        assert keys.is_key_name(name)
        keys.accept_keys(name, example[name], TARGETS)
    assert not keys.warnings(keys.read_timeline({**DEFAULTS, **example}, TARGETS))


def test_the_turntable_turns_on_and_on():
    """Once around in eight seconds, at one speed, also where a round ends."""
    example = next(example for example in EXAMPLES if 'renderer.camera.azimuth' in
                   example['tracks'])
    timeline = keys.read_timeline({**DEFAULTS, **example}, TARGETS)
    angles = [keys.values_at(timeline, frame / 30.0, TARGETS)['renderer.camera.azimuth']
              for frame in range(1000)]
    steps = np.diff(np.unwrap(angles))
    assert np.allclose(steps, 2.0 * np.pi / 240.0, rtol=0.0, atol=1e-5)


if __name__ == '__main__':
    for name, some in GROUPS.items():
        print(f'## {name}\n\n| name | default | range | unit | effect |\n|---|---|---|---|---|')
        print('\n'.join(rows_of(some)) + '\n')
