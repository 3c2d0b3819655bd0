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

"""The XML files are well formed, and package.xml keeps the schema that it names."""
from pathlib import Path

import pytest

# Part of a ROS installation; PyPI has no wheel of it. It calls the program xmllint.
main = pytest.importorskip('ament_xmllint.main', reason='ament_xmllint is not installed')

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.xmllint
@pytest.mark.linter
def test_xmllint(monkeypatch):
    monkeypatch.chdir(ROOT)
    assert main.main(argv=['package.xml', 'config']) == 0
