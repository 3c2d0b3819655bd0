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

"""Skips the tests of the window, each file by its name, where no window can be made."""
import pytest
from support.qt import why_no_qt

WHY_NOT = why_no_qt()


class SkippedModule(pytest.Module):
    """A file of tests that is not imported, as its own imports would fail."""

    def collect(self):
        pytest.skip(WHY_NOT)


def pytest_pycollect_makemodule(module_path, parent):
    """Return what stands for a file of tests; None: pytest's own."""
    return SkippedModule.from_parent(parent, path=module_path) if WHY_NOT else None
