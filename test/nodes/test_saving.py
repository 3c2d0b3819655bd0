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

"""What save_to writes is the whole shot: the wind's keys, and what other nodes are set to."""
import stat

from flag_sim.nodes.wind import Wind
from flag_sim.ros.parameter_node import BadParameter
import pytest
from rcl_interfaces.msg import Parameter as ParameterMessage, ParameterEvent, ParameterValue
import rclpy
from rclpy.parameter import Parameter
from support.forked import Graph
from support.watch import eventually, Watcher
import yaml


def content_of(path, node):
    """Return {name: value} of a params file's key; empty where it is not in it."""
    sections = yaml.safe_load(path.read_text()) if path.exists() else {}
    return sections.get(node, {}).get('ros__parameters', {})


def test_a_shot_is_saved_whole_in_any_namespace(tmp_path, domain):
    """What was set before, at the start, or without a key plays again; what is lacking is told."""
    saved = tmp_path / 'shot.yaml'
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        room = ('-r', '__ns:=/room')
        lab = ('-r', '__ns:=/lab', '-r', 'parameters:=/room/parameters')
        graph.start('physics', *room, '-p', 'damping:=0.2')
        graph.start('physics', *lab, '-p', 'grid.rows:=5', name='other')
        physics = watcher.parameters_of('/room/physics')
        for name, value in (('stiffness', 60.0), ('air.law', 'linear'), ('gravity', 9.81)):
            assert watcher.put(physics, name, value).successful
        graph.start('wind', *room, '-p', 'paused:=true', '-p', 'autokey:=true', '-p',
                    f'save_to:={saved}')
        wind = watcher.parameters_of('/room/wind')
        assert not saved.exists()  # nothing has changed yet
        assert watcher.put(wind, 'speed', 9.0).successful
        eventually(lambda: content_of(saved, '/lab/physics') == {'grid.rows': 5}, watcher)
        before = {'damping': 0.2, 'stiffness': 60.0, 'air.law': 'linear'}
        eventually(lambda: content_of(saved, '/room/physics') == before, watcher)
        assert saved.read_text().startswith('# no renderer was found, so what was set on it')
        assert watcher.put(physics, 'air.density', 1.0).successful  # becomes a key at 0
        eventually(lambda: content_of(saved, '/**/wind').get(
            'keys.physics.air.density.values') == [1.0], watcher)
        assert watcher.put(wind, 'autokey', False).successful
        assert watcher.put(physics, 'gravity', 1.5).successful      # becomes none
        after = {**before, 'air.density': 1.0, 'gravity': 1.5}
        eventually(lambda: content_of(saved, '/room/physics') == after, watcher)
        assert content_of(saved, '/**/wind')['tracks'] == ['wind.speed', 'physics.air.density']
        assert graph.end('physics') == 0
        graph.start('physics', *room, '--params-file', str(saved), name='again')
        physics = watcher.parameters_of('/room/physics')
        eventually(lambda: watcher.get(physics, 'gravity') == 1.5, watcher)
        assert {name: watcher.get(physics, name) for name in after} == after


def test_invalid_values_of_companions_are_not_saved(tmp_path, domain):
    """Anybody can publish an event in another's name."""
    saved = tmp_path / 'shot.yaml'
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('wind', '-p', 'paused:=true', '-p', 'autokey:=true', '-p', f'save_to:={saved}')
        wind = watcher.parameters_of('wind')
        events = watcher.node.create_publisher(ParameterEvent, '/parameter_events', 10)

        def publish(number):
            events.publish(ParameterEvent(node='/physics', changed_parameters=[
                ParameterMessage(name='stiffness', value=ParameterValue(
                    type=3, double_value=number))]))
            return 'no key was made: stiffness must be' in graph.log('wind')
        eventually(lambda: publish(-5.0), watcher)
        assert watcher.put(wind, 'speed', 9.0).successful
        eventually(saved.exists, watcher)
        assert content_of(saved, '/**/physics') == {}
        assert 'no physics was found' in saved.read_text()


def set_to(node, **values):
    """Set parameters of a node, as the service does; return whether it did, and the reason."""
    results = node.set_parameters([Parameter(name, value=value) for name, value in values.items()])
    return all(result.successful for result in results), results[0].reason


@pytest.mark.parametrize('start', ['', 'shot.yaml'])
def test_who_reaches_the_node_can_name_a_params_file_in_its_folder_alone(
        tmp_path, domain, monkeypatch, start):
    """No other file is written, replaced, widened or reached by a link."""
    home, folder = tmp_path / 'home', tmp_path / 'folder'
    for made in (home, folder):
        made.mkdir()
    key = 'ssh-ed25519 AAAA me@home\n'
    for name in ('authorized_keys', 'notes.yaml'):
        for made in (home, folder):
            (made / name).write_text(key)
            (made / name).chmod(0o600)
    (folder / 'link.yaml').symlink_to(home / 'new.yaml')
    (folder / 'out').symlink_to(home)
    monkeypatch.chdir(folder if not start else home)
    given = ['--ros-args', '-p', 'paused:=true']
    given += ['-p', f'save_to:={folder / start}'] if start else []
    with rclpy.init(domain_id=domain, args=given):
        node = Wind()
        for path in (home / 'authorized_keys', home / 'new.yaml', folder / 'authorized_keys',
                     folder / 'notes.yaml', folder / 'link.yaml', folder / 'out' / 'new.yaml',
                     folder / '.profile', folder / 'new', folder / ('x' * 300 + '.yaml'),
                     folder / 'a\0.yaml', folder):
            done, reason = set_to(node, save_to=str(path))
            assert not done and reason.startswith('save_to'), path
            done, _ = set_to(node, **{'events.names': [], 'speed': 7.0})
            assert done
        before = {file.name for file in folder.iterdir()}
        assert before - {'shot.yaml'} == {'authorized_keys', 'notes.yaml', 'link.yaml', 'out'}
        assert {file.name for file in home.iterdir()} == {'authorized_keys', 'notes.yaml'}
        for made in (home, folder):
            assert (made / 'notes.yaml').read_text() == key
            assert stat.S_IMODE((made / 'notes.yaml').stat().st_mode) == 0o600
        assert set_to(node, save_to=str(folder / 'good.yaml')) == (True, '')
        assert set_to(node, speed=8.0)[0]
        assert content_of(folder / 'good.yaml', '/**/wind')['speed'] == 8.0
        assert set_to(node, save_to='')[0]
        node.destroy_node()


@pytest.mark.usefixtures('still_log')
def test_what_was_put_in_the_place_of_the_file_stays(tmp_path, domain, capfd):
    """The node says so once, however many changes follow, and goes on."""
    path = tmp_path / 'shot.yaml'
    with rclpy.init(domain_id=domain, args=['--ros-args', '-p', f'save_to:={path}']):
        node = Wind()
        assert set_to(node, speed=7.0)[0]
        assert content_of(path, '/**/wind')['speed'] == 7.0
        path.unlink()
        path.write_text('precious')
        for number in range(20):
            assert set_to(node, speed=8.0 + 0.1 * number)[0]
        assert path.read_text() == 'precious'
        path.unlink()
        assert set_to(node, speed=7.5)[0]
        assert content_of(path, '/**/wind')['speed'] == 7.5
        node.destroy_node()
    assert capfd.readouterr().err.count('cannot save') == 1


def test_a_wind_whose_working_folder_is_gone_says_so(tmp_path, monkeypatch, domain):
    """Files are saved in it by default."""
    folder = tmp_path / 'gone'
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    with rclpy.init(domain_id=domain), pytest.raises(BadParameter, match='directory is gone'):
        Wind()
