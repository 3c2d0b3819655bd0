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

"""Every command of README and docs is run, in the order of its page, as a reader would."""
import re

import pytest
from support.pages import blocks, commands, PAGES, ROOT
from support.terminal import Terminal

SETS_UP = 'downloads and builds; test_package builds a wheel, and CI sets up .venv'
OTHERS = 'a program of another package'
A_NAME = 'names a command in a sentence, without what it needs'
SECURITY = 'needs a middleware with security, which the wheels are not'
NOT_RUN = {
    'cd ~/ros2_ws/src && git clone <this repository> flag_sim && cd ..': SETS_UP,
    'colcon build --packages-select flag_sim && source install/setup.bash': SETS_UP,
    'python3 -m venv env && . env/bin/activate': SETS_UP,
    'ros2 run flag_sim dataset config/flag_wind.yaml --output flags --clips 20':
        'takes minutes; test/dataset runs the command, and reads this recipe',
    'export AMENT_PREFIX_PATH=$VIRTUAL_ENV': 'test_package looks for what ros2 would find there',
    'ros2 bag reindex my_bag': OTHERS,
    'ros2 security create_keystore keys': OTHERS,
    'ros2 security create_enclave keys /flag_sim/wind': OTHERS,
    'ros2 security create_permission keys /flag_sim/wind config/sros2_policy.xml': OTHERS,
    'export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST': 'all tests have it',
    'export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce '
    'ROS_SECURITY_KEYSTORE=$PWD/keys': SECURITY,
    'ros2 run flag_sim wind --ros-args --enclave /flag_sim/wind': SECURITY,
    'ros2 bag record': A_NAME,
    'ros2 bag play --loop': A_NAME,
    'ros2 bag': A_NAME,
    'ros2 param load': A_NAME,
    'ros2 param set': A_NAME,
}
"""Commands that are not run here, each with the reason; nor is any that installs with pip."""


@pytest.fixture(scope='module')
def terminal(tmp_path_factory):
    """Return a terminal in a folder with the files that the docs speak of, no node running."""
    folder = tmp_path_factory.mktemp('folder')
    (folder / 'config').symlink_to(ROOT / 'config')
    (folder / 'more_keys.yaml').write_text(blocks('docs/keyframes.md', 'yaml')[0])
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        with Terminal(folder) as terminal:
            yield terminal


@pytest.mark.parametrize('page', [page for page in PAGES if commands(page)])
def test_the_commands_of_a_page_run(terminal, page):
    for command in commands(page):
        if command not in NOT_RUN and not command.startswith('pip install'):
            print(command)
            terminal.run(command)


def test_what_is_not_run_stands_in_the_docs():
    assert set(NOT_RUN) <= {command for page in PAGES for command in commands(page)}


def test_extras_that_are_installed_exist():
    """The words in `pip install '.[...]'` are extras of setup.py."""
    setup = (ROOT / 'setup.py').read_text()
    shown = {command for page in PAGES for command in commands(page)}
    named = [re.search(r'\[(.*)\]', command) for command in shown if "'.[" in command]
    assert named
    for extra in ','.join(match[1] for match in named).split(','):
        assert f"'{extra}': [" in setup


@pytest.mark.parametrize('page', [page for page in PAGES if blocks(page, 'python')])
def test_the_python_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for code in blocks(page, 'python'):
        exec(compile(code, page, 'exec'), {})
    if page == 'README.md':
        assert (tmp_path / 'flag.png').stat().st_size > 5000
