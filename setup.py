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

"""Installs flag_sim by colcon or by pip, and puts its executables where `ros2 run` looks."""
from glob import glob
import os

from setuptools import Distribution, find_packages, setup

NAME = 'flag_sim'
EXECUTABLES = {
    **{node: f'nodes.{node}'
       for node in ('physics', 'player', 'recorder', 'renderer', 'viewer', 'wind')},
    'dataset': 'dataset.__main__',
    'study': 'study.__main__',
    'tune': 'study.tune',
}

# `ros2 run` looks in lib/flag_sim. setup.cfg sends colcon's executables there, but pip always
# makes them in bin/: this script, installed in lib/flag_sim under each name, passes on to them.
# A `ros2` that is made of wheels in another environment hands down where its own libraries are,
# and that they are found: ours would be taken from there.
FORWARD = r"""#!/bin/sh
if [ -n "$_ROS_WHEELS_BOOTSTRAP_COMPLETE" ]; then
  unset _ROS_WHEELS_BOOTSTRAP_COMPLETE
  LD_LIBRARY_PATH=$(printf %s "$LD_LIBRARY_PATH" | tr : '\n' \
                    | grep -v '/site-packages/ros_[^/]*[.]libs$' | paste -sd : -)
fi
exec "$(dirname "$0")/../../bin/$(basename "$0")" "$@"
"""


class InstallData(Distribution().get_command_class('install_data')):
    """Adds the forwarding scripts to what pip installs."""

    def run(self):
        super().run()
        folder = os.path.join(self.install_dir, 'lib', NAME)
        if os.path.isdir(folder):  # colcon: the executables themselves are there
            return
        os.makedirs(folder)
        for name in EXECUTABLES:
            path = os.path.join(folder, name)
            with open(path, 'w') as file:
                file.write(FORWARD)
            os.chmod(path, 0o755)
            self.outfiles.append(path)


class WithData(Distribution):
    """Lets setuptools install data_files in an editable install, too, where it asks for this."""

    has_data = Distribution.has_data_files


setup(
    name=NAME,
    distclass=WithData,
    version='0.1.0',
    description='A flag in the wind, simulated and filmed on the CPU, as ROS 2 nodes',
    author='The flag_sim Authors',
    maintainer='The flag_sim Authors',
    maintainer_email='maintainers@users.noreply.h-seed-e027b529.example',
    license='Apache-2.0',
    packages=find_packages(exclude=['test', 'test.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
        ('share/' + NAME + '/config', sorted(glob('config/*'))),
    ],
    cmdclass={'install_data': InstallData},
    entry_points={
        'console_scripts': [f'{name} = {NAME}.{module}:main'
                            for name, module in EXECUTABLES.items()],
    },
    zip_safe=False,  # the compiled kernels are cached beside their modules
    # The ranges hold what was tried together; numba 0.61 is the first for all four Pythons,
    # numpy 1.26 is that of Ubuntu 24.04, for which ROS itself is built.
    python_requires='>=3.10,<3.14',
    install_requires=[
        'numpy>=1.26,<2.6',
        'numba>=0.61,<0.69',
    ],
    extras_require={
        # For a machine without a ROS installation: ROS 2 Kilted as wheels, all of one release.
        'ros': [
            'ros-kilted-rclpy>=9.1.2,<9.2',
            'ros-kilted-rmw-fastrtps-cpp>=9.3.3,<9.4',
            'ros-kilted-ament-index-python>=1.11,<1.12',
            'ros-kilted-builtin-interfaces>=2.3,<2.4',
            'ros-kilted-diagnostic-msgs>=5.5,<5.6',
            'ros-kilted-geometry-msgs>=5.5,<5.6',
            'ros-kilted-rcl-interfaces>=2.3,<2.4',
            'ros-kilted-rosgraph-msgs>=2.3,<2.4',
            'ros-kilted-rosidl-parser>=4.9.5,<4.10',
            'ros-kilted-sensor-msgs>=5.5,<5.6',
            'ros-kilted-std-msgs>=5.5,<5.6',
            'ros-kilted-visualization-msgs>=5.5,<5.6',
            'pyyaml>=6.0.1,<7',  # 6.0 has no wheel for 3.12, nor can it be built
        ],
        'record': [
            'rosbags>=0.11,<0.12',
            'lz4>=4,<5',
        ],
        # The lower bounds leave out CVE-2024-28219 and CVE-2024-34062.
        'pictures': ['av>=12,<19', 'pillow>=10.3,<14', 'tqdm>=4.66.3,<5'],
        'study': ['matplotlib>=3.6,<4', 'pyyaml>=6.0.1,<7'],
        'dataset': ['distributed>=2024.8,<2027', 'isal>=1.7,<2', 'pyarrow>=15,<27',
                    'pyyaml>=6.0.1,<7', 'tqdm>=4.66.3,<5'],
        # The window; qtpy takes PyQt5 as well, which ROS installations have. With Python before
        # 3.12, PySide6 6.12 drops a reference to None with every call, until Python ends.
        'viewer': ['qtpy>=2.4,<3', 'PySide6-Essentials>=6.6,<6.12', 'pyyaml>=6.0.1,<7'],
        # For those whose tests use flag_sim.testing.
        'testing': ['pytest>=7.4,<10'],
        # The linters are ROS's own, with the plugins that their package.xml files ask for.
        'test': [
            'pytest>=7.4,<10',
            'pytest-xdist>=3.5,<4',
            'scipy>=1.11,<2',
            'hypothesis>=6.98,<7',
            'mcap-ros2-support>=0.5,<0.7',  # reads our bags with no ROS
            # Other programs that draw the same scene; wheels exist for these processors alone.
            'embreex>=4.4,<5; platform_machine == "x86_64"',
            'moderngl>=5.10,<6; platform_machine == "x86_64"',
            'catkin_pkg>=1,<2',
            'setuptools>=78.1.1',  # a test builds a wheel; before: CVE-2025-47273
            'ros-kilted-ament-flake8>=0.19.2,<0.20',
            'ros-kilted-ament-pep257>=0.19.2,<0.20',
            'ros-kilted-ament-lint>=0.19.2,<0.20',
            'flake8>=7,<8',
            'flake8-blind-except>=0.2,<0.3',
            'flake8-builtins>=2.2,<4',
            'flake8-class-newline>=1.6,<2',
            'flake8-comprehensions>=3.14,<4',
            'flake8-deprecated>=2.2,<3',
            'flake8-docstrings>=1.7,<2',
            'flake8-import-order>=0.18.2,<0.20',
            'flake8-quotes>=3.4,<4',
            'pydocstyle>=6.3,<7',
            'vermin>=1.6,<2',  # what came after the oldest Python
        ],
    },
)
