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

"""The run that compiles the kernels and those that load them draw the same pictures."""
import os
import subprocess
import sys

import pytest
from support.soak import SOAK

SCRIPT = """
import hashlib
import sys

from flag_sim.drawing import Camera, Picture, Style
import numpy as np

s, z = np.meshgrid(np.linspace(0.0, 2.25, 31), np.linspace(8.9, 7.4, 21))
flag = np.stack([0.05 + s, 0.3 * s + 0.15 * s * np.sin(5.0 * s + z), z - 0.1 * s], axis=-1)
styles = {'plain': Style(), 'painter': Style(hidden_surface='painter'),
          'samples': Style(samples=4), 'outline': Style(outline=True)}
for name in sys.argv[1:]:
    picture = Picture()
    frame = picture.draw(flag, camera=Camera(320, 240), style=styles[name], channels=['depth'])
    digest = hashlib.sha256(frame.colour)
    digest.update(frame.depth)
    print(name, digest.hexdigest())
"""


@pytest.mark.skipif(not SOAK, reason='compiles all kernels twice: make soak')
def test_the_same_pictures_whatever_was_compiled_or_drawn_before(tmp_path):
    """Compile with one style first, load with another one first."""
    names = ['samples', 'plain', 'painter', 'outline']
    told = []
    for order in (names, names[::-1]):
        run = subprocess.run([sys.executable, '-c', SCRIPT, *order], check=True, text=True,
                             capture_output=True, timeout=300,
                             env={**os.environ, 'NUMBA_CACHE_DIR': str(tmp_path)})
        told.append(sorted(run.stdout.splitlines()))
    assert any(tmp_path.rglob('*.nbc'))
    assert len(told[0]) == len(names)
    assert told[0] == told[1]
