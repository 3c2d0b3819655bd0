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

"""Params files: shipped ones count in any namespace, and one that means nobody is told of."""
import os

from flag_sim.parameters import file_targets
from flag_sim.parameters.config import config_path
from flag_sim.parameters.file_targets import given_files, is_meant, keys_in
import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from support.forked import Graph
from support.watch import Watcher
import yaml

KEYS = ('/wind', 'wind', '/**', '/**/wind', '/*/wind', '/cam1/wind', '/cam1/*', '/**/cam1/wind',
        '/cam1/**', '/winds', '/**/win', '/a/b/wind', '/a/**/wind')


@pytest.mark.parametrize('namespace', ['', '/cam1', '/a/b'])
def test_a_key_is_meant_for_a_node_as_rclpy_has_it(tmp_path, domain, namespace):
    """With wildcards for namespaces, and without."""
    path = tmp_path / 'given.yaml'
    path.write_text(yaml.safe_dump({key: {'ros__parameters': {f'p{n}': True}}
                                    for n, key in enumerate(KEYS)}))
    context = Context()
    rclpy.init(context=context, domain_id=domain, args=[
        'x', '--ros-args', '--params-file', str(path), '-r', f'__ns:={namespace or "/"}'])
    node = Node('wind', context=context)
    taken = {KEYS[int(name[1:])] for name in node._parameter_overrides}
    assert {key for key in KEYS if is_meant(key, node.get_fully_qualified_name())} == taken
    node.destroy_node()
    rclpy.shutdown(context=context)


def keys_of(path, content):
    """Return the keys in a file of that content."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return keys_in(path)


def test_keys_may_be_nested(tmp_path):
    """As namespaces that hold nodes; and a file may hold nothing."""
    path = tmp_path / 'x.yaml'
    assert keys_of(path, '/cam1: {wind: {ros__parameters: {"": [[1], {a: 2}], b: }}, '
                         'b: {c: {}}}\n/b: {ros__parameters: {ros__parameters: {}}}') == [
        '/cam1/wind', '/b']
    assert keys_of(path, '') == []
    assert given_files(['x', '--ros-args', '--params-file', 'a', '-r', 'b:=c', '--params-file',
                        'd']) == ['a', 'd']


@pytest.mark.parametrize(('content', 'said'), [
    ('ssh-ed25519 AAAA me@home\n', 'holds something else'), ('a: {b: 1}', 'holds something else'),
    ('a: [{ros__parameters: {}}]', 'holds something else'), ('{[a]: {}}', 'a key is not a text'),
    ('a: &a {b: *a}', 'has an alias'), ('a: ' * 100, 'holds something else'),
    ('{a: ' * 100 + '}' * 100, 'more than 64 levels'),
    ('a: {ros__parameters: ' + '[' * 10**5, 'not YAML|levels'),
    (b'\xff\xfe\x00', 'not YAML'), (b'\x00', 'not YAML')])
def test_what_is_no_params_file_is_refused(tmp_path, content, said):
    """In a line, whatever it is; nothing is made of its content."""
    with pytest.raises(ValueError, match=said) as refused:
        keys_of(tmp_path / 'x.yaml', content)
    assert len(str(refused.value)) < 300 + len(str(tmp_path))


def test_a_params_file_is_a_file_of_bounded_size(tmp_path, monkeypatch):
    """A pipe that nobody writes to is not waited for."""
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(ValueError, match='is not a file'):
        keys_in(tmp_path / 'pipe')
    monkeypatch.setattr(file_targets, 'LARGEST', 3)
    with pytest.raises(ValueError, match='larger than'):
        keys_of(tmp_path / 'x.yaml', 'a: {}')


def test_a_shot_counts_in_a_namespace(tmp_path, domain):
    """A second flag in a graph plays it, without a word."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('wind', '-r', '__ns:=/cam1', '--params-file', str(config_path('gust.yaml')))
        wind = watcher.parameters_of('/cam1/wind')
        assert watcher.get(wind, 'frames') == 360
        assert list(watcher.get(wind, 'tracks')) == ['wind.speed', 'wind.azimuth']
        assert 'meant' not in graph.log('wind')


def test_a_file_in_which_nothing_is_meant_for_a_node_is_told_of(tmp_path, domain):
    """As a warning, with what helps, where it has the node's name in another namespace."""
    mine, word = tmp_path / 'mine.yaml', tmp_path / 'word.yaml'
    mine.write_text('/wind: {ros__parameters: {speed: 9.0}}')
    word.write_text('wind')  # which rclpy passes over
    with Graph(tmp_path / 'log', domain) as graph:
        for node in ('wind', 'recorder'):
            graph.start(node, '-r', '__ns:=/cam1', '--params-file', str(mine),
                        '--params-file', str(word), '-p', f'path:={tmp_path / "bag"}')
            graph.wait_ready(node)
            graph.end(node)
        warning, information = graph.log('wind'), graph.log('recorder')
    text = f'nothing in {mine} is meant for /cam1/%s; it has parameters for /wind'
    assert f'{text % "wind"}: all of it is ignored. /**/wind instead of /wind counts' in warning
    assert '[WARN]' in warning
    assert f'{word} is not a params file: it holds something else than parameters' in warning
    assert text % 'recorder' in information and 'ignored' not in information
