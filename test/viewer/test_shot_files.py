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

"""Params files as the window loads and saves them."""
from flag_sim.parameters.config import config_path
from flag_sim.viewer import shot_files
import pytest
import yaml


def test_what_is_shipped_is_shots_and_presets():
    found = {kind: [path.stem for path in paths] for kind, paths in shot_files.shipped().items()}
    assert found['shots'] == [
        'calm', 'flight', 'gust', 'parade', 'storm', 'sunrise', 'turn']
    assert found['presets'] == ['accurate', 'balanced', 'preview', 'seed']
    assert 'wind turns round' in shot_files.comment_of(config_path('turn.yaml'))


def test_each_node_gets_what_is_meant_for_it():
    sections = shot_files.read_sections(config_path('turn.yaml'))
    assert shot_files.values_for(sections, '/left/physics') == {'preroll': 4.0}
    values = shot_files.wind_values(shot_files.values_for(sections, '/wind'))
    assert values['tracks'] == ['wind.azimuth'] and values['events.names'] == []
    assert {name: value for name, value in values.items()
            if not name.startswith(('tracks', 'keys.', 'events.'))} == {
        'speed': 8.0, 'gust.intensity': 0.1}  # not how it is filmed
    assert shot_files.wind_values({'speed': 3.0, 'pace': 'lockstep'}) == {'speed': 3.0}


def test_nested_names_and_namespaces_are_read(tmp_path):
    """As `ros2 param dump` writes them."""
    (tmp_path / 'a.yaml').write_text(
        'left: {wind: {ros__parameters: {gust: {length: 3.0, seed: 1}, speed: 2.0}}}')
    sections = shot_files.read_sections(tmp_path / 'a.yaml')
    assert shot_files.values_for(sections, '/left/wind') == {
        'gust.length': 3.0, 'gust.seed': 1, 'speed': 2.0}
    assert not shot_files.values_for(sections, '/wind')


def test_a_node_of_another_name_gets_what_is_for_its_role():
    """Unless the file has something by its own name."""
    sections = {'/**': {'pole.height': 2.0}, '/**/renderer': {'width': 64}, '/left': {'width': 32}}
    assert shot_files.values_for(sections, '/other', 'renderer') == {
        'pole.height': 2.0, 'width': 64}
    assert shot_files.values_for(sections, '/robot/other', 'renderer')['width'] == 64
    assert shot_files.values_for(sections, '/left', 'renderer') == {
        'pole.height': 2.0, 'width': 32}
    assert shot_files.values_for(sections, '/other', 'physics') == {'pole.height': 2.0}


def test_a_broken_file_is_named_once_and_not_by_a_number(tmp_path):
    (tmp_path / 'a.yaml').write_text('a: {b: "')
    words = r'a.yaml is not YAML: .* in line 1, column \d'
    with pytest.raises(ValueError, match=words) as refused:
        shot_files.read_sections(tmp_path / 'a.yaml')
    assert str(refused.value).count('a.yaml') == 1


@pytest.mark.parametrize('content', ['', '[1, 2]', 'a: 1', '{', 'a: {ros__parameters: 3}',
                                     'a: {ros__parameters: [1]}', '&a [*a]', '\0'])
def test_what_is_no_params_file_is_refused(tmp_path, content):
    path = tmp_path / 'a.yaml'
    path.write_text(content)
    try:
        assert shot_files.read_sections(path) == {}
    except ValueError as error:
        assert str(error)


def test_what_is_saved_is_read_again(tmp_path):
    nodes = {'/wind': {'speed': 3.0, 'tracks': []}, '/physics': {'solver': 'xpbd'}}
    shot_files.save(tmp_path / 'a.yaml', nodes)
    sections = shot_files.read_sections(tmp_path / 'a.yaml')
    assert {node: shot_files.values_for(sections, node) for node in nodes} == nodes
    assert yaml.safe_load((tmp_path / 'a.yaml').read_text())
    (tmp_path / 'b.yaml').write_text('precious: 1')
    with pytest.raises(ValueError, match='not replaced'):
        shot_files.save(tmp_path / 'b.yaml', nodes)
