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

"""Kernels are vectorised, kept from start to start, and never out of date."""
import os
from pathlib import Path
import shutil
import subprocess
import sys

import flag_sim
import pytest

PACKAGE = Path(flag_sim.__file__).parent
USE = ('import numpy as np; from flag_sim.cloth import normals; '
       'print(normals.node_normals(np.random.default_rng(1).normal(size=(3, 3, 3)))[1, 1]); '
       'print(sum(normals._normalise.stats.cache_hits.values()))')


@pytest.fixture
def copy(tmp_path):
    """Return a folder with a copy of the package, its sources only."""
    shutil.copytree(PACKAGE, tmp_path / 'copy' / 'flag_sim',
                    ignore=shutil.ignore_patterns('__pycache__', 'nodes'))
    return tmp_path / 'copy'


def use(copy, **environment):
    """Run a kernel of the copy in a process of its own; return its result and its cache hits."""
    done = subprocess.run([sys.executable, '-c', USE], cwd=copy, check=True, text=True,
                          capture_output=True,
                          env={**os.environ, 'PYTHONPATH': str(copy), **environment})
    result, hits = done.stdout.strip().rsplit('\n', 1)
    return result, int(hits)


def test_the_second_start_compiles_nothing(copy):
    """Machine code is kept beside the package."""
    first, hits = use(copy)
    assert hits == 0
    assert use(copy) == (first, 1)


def test_code_just_compiled_and_code_loaded_round_alike(tmp_path):
    """A flag flies the same to the bit; backward Euler's sums and products are the most."""
    code = ('from flag_sim.cloth import Cloth; cloth = Cloth(solver="implicit"); '
            'print([cloth.advance(0.1, (6.0, 2.0, 0.5)).granted for _ in range(9)], '
            'hash(cloth.positions.tobytes()))')
    compiled, loaded = (
        subprocess.run([sys.executable, '-c', code], check=True, text=True, capture_output=True,
                       env={**os.environ, 'NUMBA_CACHE_DIR': str(tmp_path),
                            'PYTHONHASHSEED': '0'}).stdout for _ in range(2))
    assert compiled == loaded


def test_an_edit_anywhere_compiles_anew(copy):
    """A kernel that calls others in other files must not go on with their old code."""
    use(copy)
    with open(copy / 'flag_sim' / 'cloth' / 'springs.py', 'a') as file:
        file.write('# edited\n')
    assert use(copy)[1] == 0


def test_a_class_that_is_gone_compiles_anew(copy):
    """What an older version kept for a kernel's argument is not in the way of a newer one."""
    code = ('from typing import NamedTuple\n'
            'from flag_sim.kernels import kernel\n'
            'class {0}(NamedTuple):\n'
            '    number: float\n'
            '@kernel\n'
            'def double(pair):\n'
            '    return 2.0 * pair.number\n'
            'print(double({0}(4.0)))\n')
    for name in ('Before', 'After'):
        (copy / 'flag_sim' / 'pair.py').write_text(code.format(name))
        done = subprocess.run([sys.executable, '-c', 'import flag_sim.pair'], cwd=copy, text=True,
                              capture_output=True, env={**os.environ, 'PYTHONPATH': str(copy)})
        assert done.stdout == '8.0\n', done.stderr


def test_code_is_kept_where_neither_package_nor_home_can_be_written(copy, tmp_path):
    """Then a folder of this user's among the temporary ones is used."""
    for folder in ('', 'cloth'):
        (copy / 'flag_sim' / folder / '__pycache__').write_text('in the way of a folder')
    places = {'HOME': '/proc/nowhere', 'TMPDIR': str(tmp_path / 'temporary')}
    (tmp_path / 'temporary').mkdir()
    first, hits = use(copy, **places)
    assert hits == 0
    assert list((tmp_path / 'temporary').rglob('*.nbi'))
    assert use(copy, **places) == (first, 1)
