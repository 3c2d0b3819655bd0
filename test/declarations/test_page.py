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

"""The page of parameters is the one that the declarations make."""
from pathlib import Path

from flag_sim.declarations.nodes import NODES
from flag_sim.declarations.page import page

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'parameters.md'


def test_the_page_is_not_stale():
    assert PAGE.read_text() == page(), (
        'docs/parameters.md is not what the declarations say: make it again by `make parameters` '
        '(`python3 -m flag_sim.declarations.page > docs/parameters.md`)')


def test_every_parameter_has_its_row():
    """With default, range, unit and effect."""
    rows = page().splitlines()
    for node in NODES:
        for one in NODES[node]:
            assert [row for row in rows if row.startswith(f'| `{one.name}` | ')
                    and row.endswith(f' | {one.unit} | {one.effect} |')]
    assert ('| `pole.diameter` | 0.1 | 0.001 to 10 | m | diameter of the pole; radius of its tip |'
            in rows)
    assert '| `tracks` | (empty) |  |  | keyed' in page()
    assert '| `air.law` | quadratic | quadratic, linear, seed |  | how' in page()
