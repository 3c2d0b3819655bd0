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

"""A copy of the package with one kernel more, and what a process finds kept of that."""
import os
from pathlib import Path
import shutil
import subprocess
import sys

import flag_sim

PACKAGE = Path(flag_sim.__file__).parent
THIRDS = """
from flag_sim.jit.kernels import kernel
@kernel
def third(number):
    return number / 3.0
"""
USE = ('from flag_sim import thirds; print(thirds.third(1.0)); '
       'print(sum(thirds.third.stats.cache_hits.values()))')


def copied(folder):
    """Copy the package, its sources only, into a folder; return it."""
    shutil.copytree(PACKAGE, folder / 'flag_sim',
                    ignore=shutil.ignore_patterns('__pycache__', 'nodes', 'ros', 'tools'))
    (folder / 'flag_sim' / 'thirds.py').write_text(THIRDS)
    return folder


def use(copy, **environment):
    """Run the copy's own kernel in a process; return its result and its cache hits."""
    done = subprocess.run([sys.executable, '-c', USE], cwd=copy, check=True, text=True,
                          capture_output=True,
                          env={**os.environ, 'PYTHONPATH': str(copy), **environment})
    result, hits = done.stdout.strip().rsplit('\n', 1)
    return result, int(hits)
