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

"""What a node answers to --help: its purpose, its usage and its parameters."""
from collections.abc import Collection
import inspect
import textwrap

from flag_sim.declarations.nodes import NODES

WIDTH = 99
TAIL = """\
Lists are written [a, b]. A params file sets many parameters at once; while the node runs,
`ros2 param set /{name} ...` changes those that are not marked "at the start". Beside these
there are those of every ROS node, such as use_sim_time and qos_overrides.
Exit status: 0 when it is ended or has done its work, 1 when it cannot start or go on."""


def asks_for_help(arguments: Collection[str]) -> bool:
    """Return whether the arguments, without the program's name, ask for help."""
    return not {'-h', '--help'}.isdisjoint(arguments)


def usage(node_class: type) -> str:
    """Return the help text of a node's class, which is named as its node and executable."""
    name = node_class.__name__.lower()
    return '\n'.join([
        f'usage: {name} [--help] [--ros-args [-p PARAMETER:=VALUE]... [--params-file FILE]...',
        f'{"":{len(name) + 7}} [-r FROM:=TO]... [-r __ns:=/NAMESPACE]]', '',
        inspect.getdoc(node_class), '', 'Parameters, with their defaults:',
        *(line for declaration in NODES[name] for line in _lines(declaration)), '',
        TAIL.format(name=name)])


def _lines(declaration):
    unit = f' {declaration.unit}' if declaration.unit else ''
    default = f'  {declaration.name}: {_words(declaration.default)}{unit}'
    start = '; at the start' if declaration.fixed else ''
    effect = f'{declaration.effect}; {declaration.rule}{start}'
    return [default, *textwrap.wrap(effect, WIDTH, initial_indent=' ' * 6,
                                    subsequent_indent=' ' * 6)]


def _words(value):
    """Return a value as it is typed in a params file."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f'[{", ".join(map(_words, value))}]'
    if isinstance(value, float):
        return f'{value:.6g}'
    return str(value) or "''"
