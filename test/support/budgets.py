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

"""Budgets of a study that end after so many rows, on a machine of any speed."""
from flag_sim.study.runner import Budget


class FewRows(Budget):
    """Allows a number of rows, however long they take."""

    def __init__(self, rows):
        super().__init__('test', 60.0)
        self._rows = rows

    def allows(self, seconds=0.0):
        """Count one row."""
        self._rows -= 1
        return self._rows >= 0
