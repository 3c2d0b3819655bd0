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

"""The same bytes on another kind of processor, for which the kernels are compiled here too."""
import os
from pathlib import Path
import subprocess
import sys

import pytest
from support import digests
from support.soak import SOAK

ROOT = Path(__file__).resolve().parents[2]


def digests_of(cache, **environment):
    """Return {what: digest} as a process with environment variables of its own compiles it."""
    process = subprocess.run(
        [sys.executable, digests.__file__], capture_output=True, text=True, check=True,
        env={**os.environ, 'PYTHONPATH': str(ROOT), 'NUMBA_CACHE_DIR': str(cache), **environment})
    return dict(line.split('\t') for line in process.stdout.splitlines())


@pytest.mark.skipif(not SOAK, reason='compiles all kernels twice: make soak')
@pytest.mark.skipif('avx2' not in Path('/proc/cpuinfo').read_text(), reason='no AVX2 here')
def test_a_processor_of_2013_makes_the_same_bytes(tmp_path):
    """Haswell has AVX2 and FMA; those with AVX-512 have vectors twice as long."""
    here = digests_of(tmp_path / 'here')
    haswell = digests_of(tmp_path / 'haswell', NUMBA_CPU_NAME='haswell')
    assert len(here) == 21 and here == haswell
