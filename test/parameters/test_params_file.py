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

"""Params files as they are saved: whole or not at all."""
import os
from pathlib import Path
import stat

from flag_sim.parameters.params_file import (
    check_path, check_within, save_parameters, start_folder)
import pytest
from support.tracks import wind_values
import yaml


def test_a_saved_animation_is_the_same(tmp_path):
    """What is written is what was there, and nothing else is left beside it."""
    values = wind_values(wind__speed=([0.0, 1.0], [0.0, 10.0], ['ease', 'step']))
    save_parameters(tmp_path / 'shot.yaml', '/wind', values)
    loaded = yaml.safe_load((tmp_path / 'shot.yaml').read_text())
    assert loaded == {'/**/wind': {'ros__parameters': values}}
    assert [path.name for path in tmp_path.iterdir()] == ['shot.yaml']


def test_a_saved_shot_holds_the_other_nodes_and_says_what_it_lacks(tmp_path):
    """For any namespace, as the shipped files; a node with nothing but defaults needs none."""
    others = {'/cam/physics': {'stiffness': 60.0, 'solver': 'rk4'}, '/cam/renderer': {}}
    save_parameters(tmp_path / 'shot.yaml', '/cam/wind', {'speed': 1.0}, others,
                    ['no renderer was found'])
    text = (tmp_path / 'shot.yaml').read_text()
    assert yaml.safe_load(text) == {
        '/**/wind': {'ros__parameters': {'speed': 1.0}},
        '/**/physics': {'ros__parameters': others['/cam/physics']}}
    assert text.startswith('# no renderer was found, so what was set on it is not in this file.\n')


def test_a_saved_shot_keeps_nodes_of_one_name_apart(tmp_path):
    """Also where one of them has nothing but defaults: the other's must not count for it."""
    others = {'/a/physics': {'stiffness': 60.0}, '/b/physics': {}, '/b/renderer': {'threads': 2}}
    save_parameters(tmp_path / 'shot.yaml', '/a/wind', {'speed': 1.0}, others)
    assert yaml.safe_load((tmp_path / 'shot.yaml').read_text()).keys() == {
        '/**/wind', '/a/physics', '/**/renderer'}


def test_a_file_that_cannot_be_replaced_stays(tmp_path, monkeypatch):
    """What was saved before is still whole, and half of the new is not left behind."""
    path = tmp_path / 'shot.yaml'
    save_parameters(path, '/wind', {'speed': 1.0})
    before = path.read_text()

    def fail(*_):
        raise OSError('no space left on device')
    monkeypatch.setattr('os.replace', fail)
    with pytest.raises(OSError, match='no space left'):
        save_parameters(path, '/wind', {'speed': 2.0})
    assert path.read_text() == before
    assert [path.name for path in tmp_path.iterdir()] == ['shot.yaml']


def test_a_path_that_cannot_be_written_is_refused(tmp_path):
    """Before anything is lost."""
    with pytest.raises(ValueError, match='there is no folder'):
        check_path(tmp_path / 'none' / 'shot.yaml')
    with pytest.raises(ValueError, match='is a folder'):
        check_path(tmp_path)


KNOWN = ('wind', 'physics', 'renderer')


@pytest.mark.parametrize('content', [
    'ssh-ed25519 AAAA me@home', '', 'a: 1', '/**/robot: {ros__parameters: {speed: 1.0}}',
    '/**/wind: {ros__parameters: {speed: 1.0}}\nrobot: {ros__parameters: {speed: 1.0}}'])
def test_a_file_of_another_kind_is_never_replaced(tmp_path, content):
    """Nor one that holds what would be lost; not even where it came after the check."""
    path = tmp_path / 'x.yaml'
    path.write_text(content)
    with pytest.raises(ValueError, match='is not a params file of wind alone'):
        check_path(path, KNOWN)
    with pytest.raises(ValueError, match='is not a params file of wind alone'):
        save_parameters(path, '/a/wind', {'speed': 1.0}, known=KNOWN)
    assert path.read_text() == content
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize('mode', [0o600, 0o640, 0o444])
def test_a_file_keeps_its_mode(tmp_path, mode):
    """Nobody else can read what was closed to others; a new one is as the umask has it."""
    path = tmp_path / 'x.yaml'
    before = os.umask(0o027)
    try:
        save_parameters(path, '/wind', {'speed': 1.0})
        assert stat.S_IMODE(path.stat().st_mode) == 0o640
        path.chmod(mode)
        save_parameters(path, '/wind', {'speed': 2.0})
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == mode
    assert yaml.safe_load(path.read_text())['/**/wind']['ros__parameters'] == {'speed': 2.0}


def test_no_link_is_followed(tmp_path):
    """Neither one at the path, dangling or not, nor at any name that can be foreseen."""
    other = tmp_path / 'other'
    other.mkdir()
    save_parameters(other / 'mine.yaml', '/wind', {'speed': 1.0})
    before = (other / 'mine.yaml').read_text()
    path = tmp_path / 'x.yaml'
    for target in (other / 'mine.yaml', other / 'new.yaml'):
        path.symlink_to(target)
        with pytest.raises(ValueError, match='is a link'):
            check_path(path)
        with pytest.raises(ValueError, match='is a link'):
            save_parameters(path, '/wind', {'speed': 2.0})
        path.unlink()
    for name in (f'.x.yaml-{os.getpid()}', '.x.yaml', '.x.yaml~', 'x.yaml.tmp'):
        (tmp_path / name).symlink_to(other / 'mine.yaml')
    save_parameters(path, '/wind', {'speed': 2.0})
    assert (other / 'mine.yaml').read_text() == before
    assert [file.name for file in other.iterdir()] == ['mine.yaml']


def test_a_file_that_was_written_is_known_again(tmp_path, monkeypatch):
    """It is not read at every change; one that somebody put in its place is."""
    path = tmp_path / 'x.yaml'
    last = save_parameters(path, '/wind', {'speed': 1.0})
    with monkeypatch.context() as patched:
        patched.delattr('flag_sim.parameters.params_file.keys_in')
        last = save_parameters(path, '/wind', {'speed': 2.0}, last=last)
    path.write_text('precious')
    with pytest.raises(ValueError, match='it is not replaced'):
        save_parameters(path, '/wind', {'speed': 3.0}, last=last)
    assert path.read_text() == 'precious'


@pytest.mark.parametrize('name', [
    '../x.yaml', 'sub/x.yaml', 'sub/../../x.yaml', 'link/x.yaml', '/etc/x.yaml', 'loop/x.yaml',
    '.x.yaml', '.yaml', 'authorized_keys', 'x' * 5000 + '.yaml', 'x\0.yaml', '..',
    'x.yaml/y.yaml', '/nowhere/x.yaml'])
def test_while_running_only_one_folder_counts(tmp_path, monkeypatch, name):
    """Of others not even their existence is told."""
    folder = tmp_path / 'folder'
    (folder / 'sub').mkdir(parents=True)
    (folder / 'link').symlink_to(tmp_path)
    (folder / 'loop').symlink_to(folder / 'loop')
    monkeypatch.chdir(folder)
    for good in ('x.yaml', './y.yml', str(folder / 'z.yaml'), 'sub/../x.yaml'):
        check_within(good, folder)
    with pytest.raises(ValueError, match=f'must be a .yaml file in {folder}'):
        check_within(name, folder)


def test_the_folder_is_that_of_the_start(tmp_path, monkeypatch):
    """Of the path that was given then, or the working folder."""
    monkeypatch.chdir(tmp_path)
    assert start_folder('') == start_folder('x.yaml') == tmp_path
    assert start_folder('/proc/x.yaml') == Path('/proc')


@pytest.mark.parametrize('name', ['x' * 300, 'x' * 5000, 'x\0y', 'loop/x', 'file/x'])
def test_a_path_that_is_none_is_refused(tmp_path, name):
    """As a value, which ends no node."""
    (tmp_path / 'loop').symlink_to(tmp_path / 'loop')
    (tmp_path / 'file').write_text('')
    with pytest.raises(ValueError):
        check_path(tmp_path / name)
