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

"""The sheet of a dataset's clips."""
from flag_sim.dataset.__main__ import main as make
from flag_sim.tools.contact_sheet import COLUMNS, main, WIDTH
from PIL import Image
import pytest
from support.recipes import text


def test_the_sheet_shows_clips_channels_and_how_parameters_are_spread(tmp_path):
    recipe, folder = tmp_path / 'mine.yaml', tmp_path / 'set'
    recipe.write_text(text(channels=['colour', 'depth', 'labels', 'backward_flow']))
    assert make([str(recipe), '--output', str(folder), '--shard', '1/1']) == 0
    assert main([str(folder), str(tmp_path / 'a.png')]) == 0
    with Image.open(tmp_path / 'a.png') as sheet:
        assert sheet.size == (COLUMNS * WIDTH, 3 * WIDTH * 48 // 64)
        for row, parts in enumerate((3, 3, 1)):
            for column in range(parts):
                left, top = column * WIDTH, row * sheet.height // 3
                part = sheet.crop((left, top + 25, left + WIDTH, top + sheet.height // 3))
                assert len(part.getcolors(maxcolors=100000)) > 1 + (row == 0)


@pytest.mark.parametrize('file', ['a.txt', '/no/such/folder/a.png'])
def test_what_cannot_be_written_is_refused_at_once(tmp_path, file, capsys):
    with pytest.raises(SystemExit):
        main([str(tmp_path), file])
    assert 'usage' in capsys.readouterr().err


def test_a_folder_without_clips_is_said_to_be_one(tmp_path, capsys):
    assert main([str(tmp_path), str(tmp_path / 'a.png')]) == 1
    assert 'has no manifest' in capsys.readouterr().err


@pytest.mark.parametrize('width, height', [(2, 600), (600, 2)])
def test_slim_pictures_make_no_endless_sheet(tmp_path, width, height):
    recipe, folder = tmp_path / 'mine.yaml', tmp_path / 'set'
    recipe.write_text(text(channels=['colour']).replace('width: 64', f'width: {width}').replace(
        'height: 48', f'height: {height}'))
    assert make([str(recipe), '--output', str(folder), '--shard', '1/1']) == 0
    assert main([str(folder), str(tmp_path / 'a.png')]) == 0
    with Image.open(tmp_path / 'a.png') as sheet:
        assert sheet.width == COLUMNS * WIDTH and sheet.height <= 2 * 2 * WIDTH
