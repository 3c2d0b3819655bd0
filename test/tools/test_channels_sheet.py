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

"""The sheet of all that the camera knows."""
from flag_sim.tools.channels import main
from PIL import Image
import pytest


def test_the_sheet_shows_six_pictures(tmp_path):
    """In none of them is all of one colour."""
    assert main([str(tmp_path / 'a.png')]) == 0
    with Image.open(tmp_path / 'a.png') as sheet:
        assert sheet.size == (960, 400)
        for column in range(3):
            for row in range(2):
                left, top = 320 * column, 200 * row
                part = sheet.crop((left, top + 30, left + 320, top + 200))
                assert len(part.getcolors(maxcolors=100000)) > 3


@pytest.mark.parametrize('arguments', [[], ['a', 'b'], ['a.txt'], ['/no/such/folder/a.png']])
def test_what_cannot_be_written_is_refused_at_once(arguments, capsys):
    with pytest.raises(SystemExit):
        main(arguments)
    assert 'usage' in capsys.readouterr().err
