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

"""Kernels are loaded where they are kept; where they are not, nothing is compiled unasked."""
import os
import subprocess
import sys

from flag_sim.declarations.moving_cloth import CLOTH_KERNELS
from flag_sim.declarations.nodes import defaults
from flag_sim.declarations.picture_kernels import PICTURE_KERNELS
import pytest

CHOICES = {'CLOTH_KERNELS': (CLOTH_KERNELS, defaults('physics')),
           'PICTURE_KERNELS': (PICTURE_KERNELS, defaults('renderer'))}


@pytest.mark.parametrize('name', CHOICES)
def test_what_is_not_kept_is_not_compiled(name, tmp_path):
    """By a process that finds nothing."""
    choice, values = CHOICES[name]
    code = (f'from {choice.warm_up.__module__} import {name}\n'
            'from flag_sim.jit.cache import compilations\n'
            f'print({name}.load({choice.chosen(values)!r}), compilations())')
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True,
                          env={**os.environ, 'NUMBA_CACHE_DIR': str(tmp_path)})
    assert done.stdout == 'False 0\n'


@pytest.mark.parametrize('name', CHOICES)
def test_what_a_program_has_kept_is_loaded(name):
    """The program names all that the kernels depend on."""
    choice, values = CHOICES[name]
    exec(choice.program(values), {})
    assert choice.load(values)


def test_the_kernels_of_images_are_made_ready_without_the_file():
    """It is read where frames are drawn; a process beside may have another folder."""
    values = {**defaults('renderer'), 'flag.image': '/nowhere/gone.png', 'shadows': True}
    assert PICTURE_KERNELS.name(values) == 'the rasterizer with images and shadows'
    exec(PICTURE_KERNELS.program(values), {})
    assert PICTURE_KERNELS.load(values)
