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

"""The docstrings keep ROS's style."""
from pathlib import Path

import pytest

main = pytest.importorskip('ament_pep257.main', reason='ament_pep257 is not installed')

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.pep257
@pytest.mark.linter
def test_pep257(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert main.main(argv=['flag_sim', 'test', 'setup.py']) == 0
