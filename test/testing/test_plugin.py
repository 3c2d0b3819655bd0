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

"""What the fixtures for others' tests hand over, and what is said where a frame is not golden."""
import os
from pathlib import Path
import subprocess
import sys

from flag_sim.testing import Golden
from flag_sim.testing.film import play
import numpy as np
from PIL import Image
import pytest

ROOT = Path(__file__).resolve().parents[2]
THEIRS = """
import flag_sim.testing


def test_two_films_of_a_test_have_a_folder_each(film, monkeypatch):
    monkeypatch.setattr(flag_sim.testing, 'play', lambda folder, *_: folder)
    assert film(3) != film(3)


def test_a_flag(film, golden):
    filmed = film(3, ['camera/image_raw', 'camera/labels/image_raw', 'vertices'], 'storm',
                  renderer={'width': 64, 'height': 48},
                  physics={'grid.columns': 5, 'grid.rows': 4})
    frames = list(filmed)
    assert [round(30 * frame['stamp']) for frame in frames] == [0, 1, 2]
    assert frames[2]['camera/image_raw'].shape == (48, 64, 3)
    assert frames[2]['camera/labels/image_raw'].max() == 2
    assert frames[2]['vertices'].shape == (4, 5, 6)
    golden('flag', frames[2]['camera/image_raw'])
"""


def run(folder, *arguments):
    """Run others' test in a process of its own; return the process."""
    (folder / 'conftest.py').write_text("pytest_plugins = ['flag_sim.testing']\n")
    (folder / 'test_theirs.py').write_text(THEIRS)
    return subprocess.run(
        [sys.executable, '-m', 'pytest', '-q', '-p', 'no:cacheprovider', str(folder), *arguments],
        cwd=folder, capture_output=True, text=True, timeout=600,
        env={**os.environ, 'PYTHONPATH': str(ROOT)})


def test_a_test_of_others_films_a_flag_and_compares_it(tmp_path):
    """The first run stores a golden frame; in the next it is the same."""
    stored = run(tmp_path, '--golden-update')
    assert stored.returncode == 0, stored.stdout
    again = run(tmp_path)
    assert again.returncode == 0, again.stdout
    assert [path.name for path in (tmp_path / 'golden').iterdir()] == ['flag.png']


def test_a_picture_shows_what_differs(tmp_path):
    golden, image = Golden(tmp_path / 'golden'), np.full((4, 6, 3), 100, np.uint8)
    with pytest.raises(AssertionError, match='store what is seen by pytest --golden-update'):
        golden('x', image)
    Golden(tmp_path / 'golden', True)('x', image)
    golden('x', image)
    other = image.copy()
    other[1, 2, 0] = 107
    golden('x', other, levels=7)
    with pytest.raises(AssertionError, match='1 pixels differ .* more than 6 levels, by up to 7'):
        golden('x', other, levels=6)
    with Image.open(tmp_path / 'golden' / 'x.difference.png') as shown:
        difference = np.asarray(shown)
    assert difference[1, 2, 0] == 56 and difference.sum() == 56
    with pytest.raises(AssertionError, match='is 6 x 4 pixels, and what was seen 6 x 3'):
        golden('x', image[:3])
    golden('x', image)
    assert [path.name for path in (tmp_path / 'golden').iterdir()] == ['x.png']


def test_arrays_of_any_layout_are_compared(tmp_path):
    image = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
    Golden(tmp_path, True)('x', image[:, ::-1])
    Golden(tmp_path)('x', np.ma.masked_array(image[:, ::-1]))
    with pytest.raises(AssertionError, match='pixels differ'):
        Golden(tmp_path)('x', np.ma.masked_array(image))


def test_what_is_no_picture_is_refused(tmp_path):
    golden = Golden(tmp_path / 'golden', True)
    for rgb in (np.zeros((4, 4), np.uint8), np.zeros((4, 4, 4), np.uint8), np.zeros((4, 4, 3)), 3,
                np.zeros((0, 3, 3), np.uint8), np.zeros((3, 0, 3), np.uint8)):
        with pytest.raises(ValueError, match='rgb must be of shape'):
            golden('x', rgb)
    for name in ('a/x', '', None, 3):
        with pytest.raises(ValueError, match='without folders'):
            golden(name, np.zeros((4, 4, 3), np.uint8))
    for name in (300 * 'x', 121 * 'ä', 'a\0b'):
        with pytest.raises(ValueError, match='name must be of a file, of at most 240 bytes'):
            golden(name, np.zeros((4, 4, 3), np.uint8))
    for levels in (-1, 256, np.nan, np.zeros(3), '1'):
        with pytest.raises(ValueError, match='levels must be'):
            golden('x', np.zeros((4, 4, 3), np.uint8), levels)
    assert not (tmp_path / 'golden').exists()


def test_the_longest_name_has_room_for_what_differs(tmp_path):
    golden = Golden(tmp_path, True)
    golden(240 * 'x', np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(AssertionError, match='x.difference.png'):
        Golden(tmp_path)(240 * 'x', np.ones((4, 4, 3), np.uint8))


def test_a_stored_frame_that_is_broken_is_told(tmp_path):
    (tmp_path / 'x.png').write_text('half of it')
    with pytest.raises(AssertionError, match='x.png cannot be read: .* by pytest --golden-update'):
        Golden(tmp_path)('x', np.zeros((4, 4, 3), np.uint8))


def test_a_folder_that_cannot_be_written_says_what_differs(tmp_path, monkeypatch):
    """As where sources are mounted read-only; what is as stored passes."""
    image = np.full((4, 4, 3), 100, np.uint8)
    Golden(tmp_path / 'golden', True)('x', image)
    golden = Golden(tmp_path / 'golden')

    def fail(*_, **__):
        raise OSError(30, 'Read-only file system')
    monkeypatch.setattr(Path, 'unlink', fail)
    monkeypatch.setattr(Image.Image, 'save', fail)
    golden('x', image)
    with pytest.raises(AssertionError, match='16 pixels differ'):
        golden('x', image + np.uint8(1))


def test_what_cannot_be_filmed_says_why(tmp_path):
    for given, said in (
            ({'frames': 0}, 'frames must be'), ({'topics': 'vertices'}, 'topics must be'),
            ({'topics': []}, 'topics must be'),
            ({'renderer': {'widht': 3}}, "renderer has no parameter 'widht'"),
            ({'wind': {'frames': 5}}, 'wind: frames cannot be given: it is the first argument'),
            ({'wind': {'speed': 3.0, 'pace': 'realtime'}}, 'wind: pace cannot be given'),
            ({'wind': {'wait_for': []}}, 'wind: wait_for cannot be given'),
            ({'wind': {'paused': True}}, 'wind: paused cannot be given'),
            ({'shot': tmp_path}, 'shot .* cannot be read: Is a directory'),
            ({'shot': 'gone.yaml'}, 'shot gone.yaml cannot be read: No such file'),
            ({'shot': Path('/dev/null')}, '/dev/null is not a file')):
        with pytest.raises(ValueError, match=said):
            play(tmp_path / 'c', **{'frames': 3, **given})
    assert not (tmp_path / 'c').exists()
    with pytest.raises(TypeError, match="'camera' is none of wind, physics, renderer"):
        play(tmp_path / 'a', 3, camera={})
    with pytest.raises(AssertionError, match='refused: gravity must be'):
        play(tmp_path / 'b', 3, physics={'gravity': 'down'})
