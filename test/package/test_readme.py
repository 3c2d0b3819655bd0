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

"""The examples of keyframes in the docs play."""
from pathlib import Path
import re

from flag_sim.animation import keys
from flag_sim.declarations.keyable import TARGETS
from flag_sim.declarations.nodes import defaults
import numpy as np
import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
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
