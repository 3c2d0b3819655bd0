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

"""The page of all parameters, docs/parameters.md: `python -m flag_sim.declarations.page`."""
from flag_sim.declarations.nodes import NODES
from flag_sim.declarations.scene import SCENE
from flag_sim.parameters.declaration import Declaration

INTRODUCTION = """\
# Parameters

The parameters of every node, with default, range and unit. The nodes tell the same: `ros2 param list /physics`,
`ros2 param describe /physics stiffness`. Those under *scene* belong to physics and renderer alike; under `/**` in a params
file they are set for both. A coefficient of zero switches its term off. A limit that is rounded here or in a refusal, as 1.571 for
half of pi, may be typed as it is printed: it is then the exact limit. `threads`, `publish_clock`, `stamp.*` and what says how a bag is
recorded or played (`path`, `storage` and the like), and `camera.frame_id` are read once, at the start; all others can be set while a node runs.

This page is made of the declarations in the code by `make parameters`.
"""  # noqa: E501
HEAD = """\
| name | default | range | unit | effect |
|---|---|---|---|---|
"""


def page() -> str:
    """Return the whole page: a table for what nodes share, and one for each node's own."""
    groups = {'scene': SCENE}
    groups |= {node: [declaration for declaration in NODES[node] if declaration not in SCENE]
               for node in NODES}
    tables = [f'## {title}\n\n{HEAD}' + ''.join(map(_row, group))
              for title, group in groups.items()]
    return '\n'.join([INTRODUCTION, *tables])


def _row(declaration: Declaration) -> str:
    """Return the table's row of a parameter."""
    one = declaration
    cells = (f'`{one.name}`', _text(one.default) or '(empty)', _range(one), one.unit, one.effect)
    return f'| {" | ".join(cells)} |\n'


def _range(declaration):
    """Return in a few words which values are allowed; nothing where all of the type are."""
    if declaration.choices:
        return ', '.join(map(str, declaration.choices))
    if declaration.low is None:
        return ''
    digits = '.4g' if declaration.kind is float else 'd'
    return f'{declaration.low:{digits}} to {declaration.high:{digits}}'


def _text(value):
    """Return a default as people write it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return ', '.join(map(str, value))
    return f'{value:.4g}' if isinstance(value, float) else str(value)


if __name__ == '__main__':
    print(page(), end='')
