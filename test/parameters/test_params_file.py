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
from flag_sim.parameters.params_file import check_path, save_parameters
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
