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

"""The tables of docs/dependencies.md are what setup.py and package.xml ask for."""
from pathlib import Path
import re

from catkin_pkg.package import parse_package
import pytest
from support.pages import text_of

ROOT = Path(__file__).resolve().parents[2]
ROW = re.compile(r'^\| `([\w-]+)` \| `([^`]+)` \| ([^|]+) \| (?:`([\w-]+)`|none) '
                 r'\| ([^|]+) \| ([^|]+) \|$', re.MULTILINE)
"""Name in pip, range, extras, name in rosdep, licence, reason."""
ONLY_ROSDEP = re.compile(r'^\| `([\w-]+)` \| ([^|`]+) \| ([^|`]+) \|$', re.MULTILINE)
"""Name in rosdep, licence, reason."""


@pytest.fixture(scope='module')
def page():
    return text_of('docs/dependencies.md')


@pytest.fixture(scope='module')
def required(setup):
    """Return {(name, range): extras that ask for it}; '' stands for every installation."""
    found = {}
    for extra, requirements in {'': setup['install_requires'], **setup['extras_require']}.items():
        for requirement in requirements:
            name, bounds = re.match(r'([\w-]+)([^;]+)', requirement).groups()
            found.setdefault((name, bounds.strip()), set()).add(extra)
    return found


def test_every_requirement_of_setup_has_its_row(page, required):
    """With its range and the extras that ask for it, and there is no other row."""
    rows = {(name, bounds): {'' if extra == 'always' else extra for extra in extras.split(', ')}
            for name, bounds, extras, *_ in ROW.findall(page)}
    assert rows == required
    assert len(ROW.findall(page)) == len(rows)


def test_every_requirement_has_a_lower_bound(required):
    """And an upper one, but for what builds the package, which pip brings in its own version."""
    for name, bounds in required:
        assert re.match(r'>=[\d.]+(,<[\d.]+)?$', bounds), name
        assert '<' in bounds or name == 'setuptools'


def test_every_dependency_of_package_xml_has_its_row(page):
    """In the same row as what pip knows it by, or in the table of those that pip has not."""
    package = parse_package(str(ROOT / 'package.xml'))
    asked = {depend.name for depend in package.exec_depends + package.test_depends}
    in_rows = {row[3] for row in ROW.findall(page)} - {''}
    others = {row[0] for row in ONLY_ROSDEP.findall(page)}
    assert in_rows | others == asked
    assert not in_rows & others


def test_every_row_has_licence_and_reason(page):
    for row in (*ROW.findall(page), *ONLY_ROSDEP.findall(page)):
        assert all(cell.strip() for cell in row[-2:]), row
