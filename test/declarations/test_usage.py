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

"""What executables answer to --help."""
import importlib
import subprocess
import sys

from flag_sim.declarations.nodes import NODES
import pytest
import rclpy


@pytest.mark.parametrize('name', NODES)
@pytest.mark.parametrize('arguments', [['--help'], ['-h'], ['--ros-args', '-p', 'a:=1', '--help']])
def test_a_node_tells_its_parameters(name, arguments, capsys):
    """Each with default, unit, effect and rule, whatever else is asked; ROS is not started."""
    main = importlib.import_module(f'flag_sim.nodes.{name}').main
    assert main([name, *arguments]) == 0 and not rclpy.ok()
    said = capsys.readouterr().out
    assert said.startswith(f'usage: {name} [--help] [--ros-args')
    assert max(map(len, said.splitlines())) <= 99
    for declaration in NODES[name]:
        line = next(line for line in said.splitlines()
                    if line.startswith(f'  {declaration.name}: '))
        assert line.endswith(f' {declaration.unit}') or not declaration.unit
        words = ' '.join(said.split())
        assert f'{declaration.effect}; {declaration.rule}' in words


@pytest.mark.parametrize('module', [
    'dataset.__main__', 'study.__main__', 'study.tune', 'tools.demo', 'tools.view'])
def test_a_command_tells_its_options(module, capsys):
    """Each with its default, where it has one."""
    main = importlib.import_module(f'flag_sim.{module}').main
    with pytest.raises(SystemExit) as end:
        main(['--help'])
    said = ' '.join(capsys.readouterr().out.split())
    assert end.value.code == 0 and said.startswith('usage: ')
    for default in {'dataset.__main__': ('(as the recipe says)',),
                    'study.__main__': ('[min] (5)', '(out/study, or out/real)'),
                    'study.tune': ('[Hz] (30)', '[pixel]'),
                    'tools.demo': ('(gust)', '(out)'), 'tools.view': ('(turn)', '(none)')}[module]:
        assert default in said


def test_only_the_beginning_may_be_read():
    """By `head`: without a traceback."""
    done = subprocess.run(
        f'{sys.executable} -m flag_sim.nodes.renderer --help | head -1', shell=True, text=True,
        capture_output=True)
    assert done.stdout.startswith('usage: renderer') and not done.stderr
