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

"""`~` means the home in every path that is given, as parameter and on the command line."""
from pathlib import Path

from flag_sim.nodes.player import Player
from flag_sim.nodes.recorder import Recorder
from flag_sim.nodes.wind import Wind
from flag_sim.parameters import checks
from flag_sim.parameters.arguments import given_path
from flag_sim.ros.bag import Bag
from flag_sim.ros.parameter_node import BadParameter
from flag_sim.study import __main__ as study, tune
from flag_sim.tools import demo
import pytest
from rcl_interfaces.msg import ParameterEvent
import rclpy
from rclpy.parameter import Parameter

ROOT = Path(__file__).resolve().parents[2]
NOBODY = '~no_such_user/x'


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """Make a home, and a working folder in which nothing may appear; return the home."""
    for name in ('home', 'work'):
        (tmp_path / name).mkdir()
    monkeypatch.setenv('HOME', str(tmp_path / 'home'))
    monkeypatch.chdir(tmp_path / 'work')
    yield tmp_path / 'home'
    assert not list((tmp_path / 'work').iterdir())


def start(make, domain, *arguments):
    """Start a node with parameters, and end it."""
    given = [part for argument in arguments for part in ('-p', argument)]
    with rclpy.init(domain_id=domain, args=['--ros-args', *given]):
        node = make()
        node.close()
        node.destroy_node()


def test_the_recorder_and_the_player_know_the_home(domain, home):
    """A bag that is made there is found there."""
    start(Recorder, domain, 'path:=~/bag', 'topics:=[vertices]')
    assert (home / 'bag' / 'metadata.yaml').exists()
    bag = Bag('~/other', 'mcap', 'none')
    bag.add_topic('/parameters', ParameterEvent)
    bag.close()
    start(Player, domain, 'path:=~/other')
    assert (home / 'other').exists()


def test_the_winds_file_is_in_the_home(domain, home):
    """Given at the start, and while running."""
    with rclpy.init(domain_id=domain, args=['--ros-args', '-p', 'save_to:=~/a.yaml']):
        node = Wind()
        for name in ('~/b.yaml', NOBODY):
            (result,) = node.set_parameters([Parameter('save_to', value=name)])
            assert result.successful == (name != NOBODY)
        assert 'no home is known of such a user' in result.reason
        node.destroy_node()
    assert (home / 'b.yaml').exists()


@pytest.mark.parametrize('make, name', [
    (Recorder, 'path'), (Player, 'path'), (Wind, 'save_to')])
def test_the_home_of_nobody_is_refused(domain, make, name):
    """By its parameter, in words."""
    with pytest.raises(BadParameter, match=f'{name} {NOBODY}: no home is known of such a user'):
        start(make, domain, f'{name}:={NOBODY}')


@pytest.mark.parametrize('run, arguments, said', [
    (tune.main, ['--error-px=4', '--output=~/tuned/x.yaml'], 'there is no folder {home}/tuned'),
    (tune.main, ['--error-px=4', '--output=~/x.yaml', '--params-file=~/mine.yaml'],
     '{home}/mine.yaml cannot be read'),
    (study.main, ['--output=~/file'], '{home}/file'),
    (demo.main, ['--shot=balanced', f'--out={NOBODY}'], 'no home is known of such a user'),
    (study.main, [f'--output={NOBODY}'], 'no home is known of such a user'),
])
def test_commands_know_the_home(run, arguments, said, home, capfd):
    """Their refusals show where they have looked."""
    (home / 'file').write_text('not a folder')
    try:
        assert run(arguments) != 0
    except SystemExit as end:
        assert end.code != 0
    assert said.format(home=home) in capfd.readouterr().err


def test_all_commands_take_paths_alike(home):
    """No parser reads one by itself, those of the benchmarks neither."""
    assert given_path('~/x') == checks.path('path', '~/x') == home / 'x'
    sources = [*(ROOT / 'flag_sim').rglob('*.py'), *(ROOT / 'test' / 'benchmark').glob('*.py')]
    assert not [source for source in sources if 'type=' + 'Path' in source.read_text()]
    assert sum('type=given_path' in source.read_text() for source in sources) >= 7
