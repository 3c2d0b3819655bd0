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

"""The code runs on the oldest Python that setup.py promises: it uses nothing that came later."""
import importlib.util
from pathlib import Path
import re
import subprocess
import sys

import pytest

ROOT = Path(__file__).resolve().parents[2]
OLDEST = re.search(r"python_requires='>=([0-9.]+),", (ROOT / 'setup.py').read_text())[1]


@pytest.mark.linter
@pytest.mark.skipif(importlib.util.find_spec('vermin') is None, reason='vermin is not installed')
def test_nothing_is_newer_than_the_oldest_python():
    found = subprocess.run(
        [sys.executable, '-c', 'import vermin; vermin.main()', f'-t={OLDEST}-', '--violations',
         '--no-parse-comments', '-vvv', 'flag_sim', 'test', 'setup.py'],
        cwd=ROOT, capture_output=True, text=True)
    assert found.returncode == 0, found.stdout + found.stderr
