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

"""What README and docs name exists: files, links, functions, packages, topics."""
import importlib
import re

from flag_sim.ros.topics import TOPICS
import pytest
from support.pages import PAGES, ROOT, text_of

FOLDERS = ('flag_sim', 'test', 'config', 'docs')


def anchors(path):
    """Return the anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r'^#+ (.*)', path.read_text(), re.MULTILINE)
    return {re.sub(r'[^\w -]', '', heading).lower().replace(' ', '-') for heading in headings}


def find(name):
    """Return the module, class, function or method of a dotted name."""
    parts = name.split('.')
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module('.'.join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            found = getattr(found, part)
        return found
    raise AssertionError(name)


@pytest.mark.parametrize('page', PAGES)
def test_links_lead_somewhere(page):
    for link in re.findall(r'\]\(([^):]+)\)', text_of(page)):
        name, _, anchor = link.partition('#')
        path = (ROOT / page).parent / name if name else ROOT / page
        assert path.exists(), link
        assert not anchor or anchor in anchors(path), link


@pytest.mark.parametrize('page', PAGES)
def test_names_exist(page):
    """Of dotted names something can be imported, and paths in the tree are those of files."""
    for name in re.findall(r'`(flag_sim(?:\.\w+)+)`', text_of(page)):
        assert find(name) is not None
    for path in re.findall(rf'`((?:{"|".join(FOLDERS)})/[\w./]*)`', text_of(page)):
        assert (ROOT / path).exists(), path
    for shot in re.findall(r'`config/(\w+)`', text_of(page)):
        assert (ROOT / f'config/{shot}.yaml').exists(), shot


def test_every_fault_has_a_test():
    """The tests that the table of faults names exist, and each line names one."""
    lines = [line for line in text_of('docs/faults.md').splitlines() if '::' in line]
    assert len(lines) > 10
    for line in lines:
        for path, name in re.findall(r'`(test/[\w/]+\.py)::(\w+)`', line):
            assert re.search(rf'^(def|class) {name}\b', (ROOT / path).read_text(), re.M), name
    rows = re.findall(r'^\| (?!fault|--)', text_of('docs/faults.md'), re.MULTILINE)
    assert len(rows) == len(lines)


def test_every_page_is_on_the_map():
    for page in PAGES[1:]:
        assert f']({page})' in text_of('README.md'), page


def test_every_picture_is_shown():
    shown = {name for page in PAGES
             for name in re.findall(r'!\[[^]]*\]\(([^)]+)\)', text_of(page))}
    for picture in (ROOT / 'docs').glob('*.png'):
        assert shown & {picture.name, f'docs/{picture.name}'}, picture


def test_readme_is_short():
    assert len(text_of('README.md').splitlines()) <= 150


def test_every_package_is_described():
    packages = {f'flag_sim/{path.parent.name}' for path in ROOT.glob('flag_sim/*/__init__.py')}
    rows = re.findall(r'^\| `(flag_sim/\w+)` \|', text_of('docs/architecture.md'), re.MULTILINE)
    assert set(rows) == packages and len(rows) == len(packages)


def test_every_equation_has_a_function():
    """1.1 to 1.14 and 2.1 to 2.5, each once; that the functions exist is tested above."""
    rows = re.findall(r'^\| ([\d., ]+) \|.*\| `flag_sim\..*\|$', text_of('docs/source.md'),
                      re.MULTILINE)
    assert ', '.join(rows).split(', ') == [
        *(f'1.{n}' for n in range(1, 15)), *(f'2.{n}' for n in range(1, 6))]


def test_the_table_of_topics_is_the_codes():
    """Every topic stands there with its type, and no other."""
    rows = re.findall(r'^\| `(\S+)` \| (\w+/\w+) \|', text_of('docs/protocol.md'), re.MULTILINE)
    assert dict(rows) == {
        name: f'{topic.message.__module__.split(".")[0]}/{topic.message.__name__}'
        for name, topic in TOPICS.items()}
