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

"""What package.xml, setup.py and CHANGELOG.rst say agrees with the code, and with one another."""
import ast
import os
from pathlib import Path
import re
import runpy
import shutil
import subprocess
import sys
import zipfile

from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package
from flag_sim.declarations.nodes import NODES
import pytest
import setuptools

ROOT = Path(__file__).resolve().parents[2]

# Libraries that are not ROS packages, by the name that is imported: the name that rosdep and
# the name that pip knows them by. A ROS package is called by one name everywhere.
LIBRARIES = {
    'av': (None, 'av'),  # which rosdep does not know: without it no movie is written
    'PIL': ('python3-pil', 'pillow'),
    'dask': (None, 'distributed'),  # which brings it
    'distributed': (None, 'distributed'),  # which rosdep does not know, as isal and pyarrow
    'isal': (None, 'isal'),
    'pyarrow': (None, 'pyarrow'),
    'catkin_pkg': ('python3-catkin-pkg-modules', 'catkin_pkg'),
    'hypothesis': ('python3-hypothesis', 'hypothesis'),
    'llvmlite': ('python3-numba', 'numba'),  # which is built on it
    'lz4': ('python3-lz4', 'lz4'),
    'matplotlib': ('python3-matplotlib', 'matplotlib'),
    'numba': ('python3-numba', 'numba'),
    'numpy': ('python3-numpy', 'numpy'),
    'qtpy': ('python3-qtpy', 'qtpy'),
    'pytest': ('python3-pytest', 'pytest'),
    'rosbags': ('python3-rosbags-pip', 'rosbags'),
    'scipy': ('python3-scipy', 'scipy'),
    'setuptools': ('python3-setuptools', 'setuptools'),
    'tqdm': ('python3-tqdm', 'tqdm'),
    'yaml': ('python3-yaml', 'pyyaml'),
}
WITHOUT_WHEELS = ('tf2_msgs',)
"""ROS packages that pip does not have, without which something is left out."""


@pytest.fixture(scope='module')
def package():
    return parse_package(str(ROOT / 'package.xml'))


def names_of(nodes):
    """Return the first names of what is imported among nodes of a syntax tree."""
    names = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names.update(alias.name.split('.')[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module.split('.')[0])
    return names


def imported():
    """Return the names that flag_sim/ imports and that Python does not bring."""
    names = set()
    for path in (ROOT / 'flag_sim').rglob('*.py'):
        names |= names_of(ast.walk(ast.parse(path.read_text())))
    return sorted(names - set(sys.stdlib_module_names) - {'flag_sim'})


def imported_by_tests():
    """
    Return the names that the tests cannot do without and that Python does not bring.

    What is imported within a function is other programs, without which their tests are skipped.
    """
    tests = [path for path in (ROOT / 'test').rglob('*.py')
             if path.relative_to(ROOT).parts[1] != 'benchmark']
    names = set().union(*(names_of(ast.parse(path.read_text()).body) for path in tests))
    own = {'flag_sim', 'support', *(path.stem for path in tests)}
    return sorted(names - set(sys.stdlib_module_names) - own)


def test_package_is_valid(package):
    warnings = []
    package.validate(warnings=warnings)
    assert not warnings
    assert package.package_format == 3
    assert package.get_build_type() == 'ament_python'


def test_package_and_setup_agree(package, setup):
    assert setup['name'] == package.name
    assert setup['version'] == package.version
    assert [setup['license']] == package.licenses
    (maintainer,) = package.maintainers
    assert (setup['maintainer'], setup['maintainer_email']) == (maintainer.name, maintainer.email)


# catkin_pkg calls what newer docutils has renamed
@pytest.mark.filterwarnings('ignore:.*traverse:DeprecationWarning')
def test_changelog_has_the_version(package):
    changelog = get_changelog_from_path(str(ROOT / 'CHANGELOG.rst'), package.name)
    newest = next(iter(changelog.foreach_version(reverse=True)))[0]
    assert newest == package.version


def assert_declared(name, depends, setup, extras):
    """Assert that package.xml's `depends` and setup.py's `extras` have what is imported."""
    in_rosdep, in_pip = LIBRARIES.get(name, (name, 'ros-kilted-' + name.replace('_', '-')))
    assert in_rosdep in [None, *(depend.name for depend in depends)]
    if name in WITHOUT_WHEELS:
        return
    requirements = list(setup['install_requires'])
    for extra in extras:
        requirements += setup['extras_require'][extra]
    assert in_pip in [re.match(r'[\w-]+', requirement)[0] for requirement in requirements]


EXTRAS = ('ros', 'record', 'pictures', 'study', 'dataset', 'viewer', 'testing')


@pytest.mark.parametrize('name', imported())
def test_import_is_declared(name, package, setup):
    assert_declared(name, package.exec_depends, setup, EXTRAS)


@pytest.mark.parametrize('name', imported_by_tests())
def test_import_of_the_tests_is_declared(name, package, setup):
    assert_declared(name, package.exec_depends + package.test_depends, setup, (*EXTRAS, 'test'))


def test_every_executable_is_a_module(setup):
    """Of which test_usage asks all for --help: nodes that have parameters, and the others."""
    assert set(NODES) | {'dataset', 'study', 'tune'} == {
        command.split()[0] for command in setup['entry_points']['console_scripts']}
    for command in setup['entry_points']['console_scripts']:
        module = re.fullmatch(
            r'(\w+) = flag_sim\.(nodes\.\1|dataset\.__main__|study\.(\1|__main__)):main', command)
        assert module, command
        assert (ROOT / 'flag_sim' / f'{module[2].replace(".", "/")}.py').is_file()


def test_a_ros2_of_wheels_hands_its_libraries_to_nobody(tmp_path):
    """Where `ros2 run` finds the executables, their own libraries count, and what the user set."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        patch.setattr(setuptools, 'setup', lambda **arguments: None)
        forward = runpy.run_path('setup.py')['FORWARD']
    say = '#!/bin/sh\necho "$1"; env'
    for path, script in (('lib/flag_sim/wind', forward), ('bin/wind', say)):
        (tmp_path / path).parent.mkdir(parents=True)
        (tmp_path / path).write_text(script)
        (tmp_path / path).chmod(0o755)
    own = '/opt/mine/lib'
    theirs = '/venv/lib/python3.11/site-packages/ros_kilted_rclpy.libs'
    for given, left in ((f'{theirs}:{own}:{theirs}', own), (theirs, ''), (own, own)):
        said = subprocess.run(
            [tmp_path / 'lib/flag_sim/wind', 'an argument'], check=True, capture_output=True,
            text=True, env={'PATH': os.environ['PATH'], 'LD_LIBRARY_PATH': given,
                            '_ROS_WHEELS_BOOTSTRAP_COMPLETE': '1'}).stdout.splitlines()
        assert said[0] == 'an argument'
        assert f'LD_LIBRARY_PATH={left}' in said
        assert not [line for line in said if line.startswith('_ROS_WHEELS')]


def test_an_editable_install_serves_ros2_too(setup, tmp_path):
    """Its wheel has the index entry that `ros2 pkg` looks for, and `ros2 run`'s executables."""
    for name in ('setup.py', 'setup.cfg', 'pyproject.toml', 'package.xml', 'README.md'):
        shutil.copy(ROOT / name, tmp_path)
    for name in ('config', 'resource'):
        shutil.copytree(ROOT / name, tmp_path / name)
    (tmp_path / 'flag_sim').mkdir()
    (tmp_path / 'flag_sim' / '__init__.py').touch()
    build = 'from setuptools import build_meta; build_meta.build_editable("wheels")'
    (tmp_path / 'wheels').mkdir()
    subprocess.run([sys.executable, '-c', build], cwd=tmp_path, check=True, capture_output=True)
    with zipfile.ZipFile(next((tmp_path / 'wheels').glob('*.whl'))) as wheel:
        modes = {re.sub('^.*[.]data/data/', '', info.filename): info.external_attr >> 16
                 for info in wheel.infolist()}
    assert 'share/ament_index/resource_index/packages/flag_sim' in modes
    assert {'share/flag_sim/package.xml', 'share/flag_sim/config/gust.yaml'} < set(modes)
    for command in setup['entry_points']['console_scripts']:
        assert modes[f'lib/flag_sim/{command.split()[0]}'] & 0o111 == 0o111


def test_every_config_is_installed(setup):
    installed = dict(setup['data_files'])['share/flag_sim/config']
    present = [path.relative_to(ROOT).as_posix() for path in (ROOT / 'config').iterdir()]
    assert sorted(installed) == sorted(present)
