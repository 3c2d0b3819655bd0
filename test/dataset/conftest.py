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

"""What the tests of datasets share."""
from flag_sim.dataset.__main__ import main
import pytest
from support.recipes import text


@pytest.fixture
def run(tmp_path, capsys):
    """Return a function that runs the command in this process: (status, what it said)."""
    def command(*arguments, content=text(), output=tmp_path / 'set'):
        path = tmp_path / 'mine.yaml'
        path.write_text(content)
        status = main([str(path), '--output', str(output), '--shard', '1/1', *arguments])
        return status, ''.join(capsys.readouterr())
    command.folder = tmp_path / 'set'
    return command
