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

"""The renderer's `flag.image`: read, refused, kept, scaled down; at its start and later."""
import os

from flag_sim.declarations.factories import look_of
from flag_sim.declarations.images import KEPT, picture_of
from flag_sim.declarations.nodes import defaults
from flag_sim.ros.parameter_node import BadParameter, to_parameter
import numpy as np
from PIL import Image
import pytest
from support.nodes import made


def save(path, level=100, size=(6, 4)):
    """Write a picture of one grey."""
    Image.new('RGB', size, (level, level, level)).save(path)
    return str(path)


def level_of(picture):
    """Return the linear light of a picture's first texel."""
    return picture.texture.mipmap(0)[0, 0, 0]


def put(node, value):
    """Set flag.image."""
    return node.set_parameters_atomically([to_parameter('flag.image', value)])


def test_a_missing_or_broken_file_is_refused_at_the_start(domain, tmp_path):
    (tmp_path / 'text.png').write_text('not a picture')
    for name, reason in (('gone.png', 'No such file'), ('text.png', 'not one of PNG, ')):
        with pytest.raises(BadParameter) as refused, made(
                'renderer', domain, tmp_path, f'flag.image:={tmp_path / name}'):
            pass
        assert f'{tmp_path / name}' in str(refused.value) and reason in str(refused.value)
        assert str(refused.value).startswith('flag.image')


def test_a_refused_image_leaves_the_old_one(domain, tmp_path):
    good, bad = save(tmp_path / 'good.png'), str(tmp_path / 'bad.png')
    with made('renderer', domain, tmp_path, f'flag.image:={good}') as node:
        texture = look_of(node.values).materials.flag_image
        assert texture.size == (6, 4)
        result = put(node, bad)
        assert not result.successful and bad in result.reason
        assert node.get_parameter('flag.image').value == good
        assert look_of(node.values).materials.flag_image is texture
        assert put(node, '').successful
        assert look_of(node.values).materials.flag_image is None
        # One of the package's own, by its name alone.
        assert put(node, 'cross.png').successful
        assert look_of(node.values).materials.flag_image.size == (768, 512)


def test_a_keyed_image_that_is_broken_leaves_the_frame_the_one_before(domain, tmp_path):
    good = save(tmp_path / 'good.png')
    with made('renderer', domain, tmp_path) as node:
        assert node._merge({'flag.image': good})['flag.image'] == good
        assert node._merge({'flag.image': str(tmp_path)})['flag.image'] == good
        assert str(tmp_path) in node._clash


def test_a_huge_image_is_scaled_down_with_a_word(domain, tmp_path):
    huge, said = save(tmp_path / 'huge.png', size=(6000, 10)), []
    with made('renderer', domain, tmp_path) as node:
        node._log.warn = lambda words, _: said.append(words)
        assert put(node, huge).successful
        assert put(node, save(tmp_path / 'small.png')).successful
    assert len(said) == 1
    assert f'{huge} has 6000 x 10 pixels' in said[0] and '2048 x 3' in said[0]


def test_a_file_that_broke_is_told_and_refused_where_it_is_set_again(domain, tmp_path):
    """As one that is written just now, a folder in its place, one that has gone."""
    path, said = save(tmp_path / 'flag.png', 100), []
    whole = (tmp_path / 'flag.png').read_bytes()

    def cut():
        (tmp_path / 'flag.png').write_bytes(whole[:50])

    def folder():
        (tmp_path / 'flag.png').unlink()
        (tmp_path / 'flag.png').mkdir()

    def gone():
        (tmp_path / 'flag.png').rmdir()

    with made('renderer', domain, tmp_path, f'flag.image:={path}') as node:
        node._log.warn = lambda words, _: said.append(words)
        first = picture_of(path)
        for spoil, reason in ((cut, ''), (folder, 'Is a directory'), (gone, 'No such file')):
            spoil()
            said.clear()
            other = node.set_parameters_atomically([to_parameter('camera.distance', 9.0)])
            assert other.successful and picture_of(path) is first
            assert len(said) == 1 and path in said[0] and reason in said[0]
            assert said[0].endswith('the picture that was read from it before stays')
            result = put(node, path)
            assert not result.successful and path in result.reason and reason in result.reason
            assert node._merge({'flag.image': path})['flag.image'] == path and not node._clash
        (tmp_path / 'flag.png').write_bytes(whole)
        said.clear()
        assert put(node, path).successful and not said and picture_of(path) is not first


def test_a_file_is_read_again_once_it_has_changed(tmp_path):
    path = tmp_path / 'flag.png'
    save(path, 100)
    first = picture_of(str(path))
    assert picture_of(str(path)) is first
    save(tmp_path / 'new.png', 200)
    os.replace(tmp_path / 'new.png', path)
    second = picture_of(str(path))
    assert level_of(second) > level_of(first)
    # One that has become unreadable, or has gone, stays what it was: frames go on.
    path.write_text('half of it')
    assert picture_of(str(path)) is second
    path.unlink()
    assert picture_of(str(path)) is second
    others = [save(tmp_path / f'{k}.png') for k in range(KEPT - 1)]
    for other in others:
        picture_of(other)
    assert picture_of(str(path)) is second
    for other in [*others, save(tmp_path / 'last.png')]:
        picture_of(other)
    with pytest.raises(ValueError, match=f'flag.image: {path}.*No such file'):
        picture_of(str(path))


def test_a_file_beside_goes_before_the_packages_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert picture_of('checker.png').size == (768, 512)
    save(tmp_path / 'checker.png')
    assert picture_of('checker.png').size == (6, 4)


def test_without_an_image_the_look_is_as_it_was():
    look = look_of(defaults('renderer'))
    assert look.materials.flag_image is None
    assert np.array_equal(look.materials.flag.color, (205.0, 35.0, 40.0))
