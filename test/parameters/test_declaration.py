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

"""Parameters: what is accepted, what is refused, and that all places agree on them."""
import array
import math
import re

from flag_sim.declarations.nodes import NODES
from flag_sim.parameters import checks
from flag_sim.parameters.declaration import as_typed, Declaration
from flag_sim.study.candidates import CHOSEN
import numpy as np
import pytest
import yaml

NUMBER = Declaration('n', 1.0, 'a number', 'm', 0.0, 2.0)
SOME = Declaration('s', 1, 'some', choices=(1, 4))
COLOR = Declaration('c', [1.0, 2.0, 3.0], 'a colour', '', 0.0, 255.0, length=3)


@pytest.mark.parametrize('declaration, value, expected', [
    (NUMBER, 2, 2.0),
    (COLOR, [1, 2, 3.5], [1.0, 2.0, 3.5]),
    (Declaration('k', 3, 'count', '', 0, 9), 9, 9),
    (Declaration('b', False, 'switch'), True, True),
    (Declaration('w', 'a', 'word', choices=('a', 'b')), 'b', 'b'),
    (SOME, 4, 4),
    (Declaration('l', [], 'names', item=str), ['x', 'y'], ['x', 'y']),
])
def test_good_values_come_back_in_the_parameters_type(declaration, value, expected):
    """A whole number is good for a number; everything else is kept."""
    accepted = declaration.accept(value)
    assert accepted == expected
    assert type(accepted) is type(declaration.default)


@pytest.mark.parametrize('declaration, value', [
    (NUMBER, 2.1), (NUMBER, -0.1), (NUMBER, float('nan')), (NUMBER, float('inf')),
    (NUMBER, 'one'), (NUMBER, True), (NUMBER, None), (NUMBER, [1.0]),
    (COLOR, [1.0, 2.0]), (COLOR, [1.0, 2.0, 256.0]), (COLOR, 'red'), (COLOR, 4),
    (Declaration('k', 3, 'count', '', 0, 9), 2.5), (Declaration('k', 3, 'count', '', 0, 9), 10),
    (SOME, 2), (SOME, True), (SOME, 4.0), (SOME, '4'),
    (Declaration('b', False, 'switch'), 1),
    (Declaration('w', 'a', 'word', choices=('a', 'b')), 'c'),
    (NUMBER, array.array('d', [1.0])), (COLOR, array.array('d', [1.0])),
    (Declaration('l', [], 'names', item=str), [1]), (Declaration('l', [], 'names', item=str), 'x'),
])
def test_bad_values_are_refused_with_the_rule_and_the_value(declaration, value):
    """The message holds the name, the rule and what was given."""
    with pytest.raises(ValueError) as refusal:
        declaration.accept(value)
    given = value.tolist() if isinstance(value, array.array) else value
    for part in (declaration.name, declaration.rule, f'not {given!r}'):
        assert part in str(refusal.value)


def test_a_range_of_whole_numbers_is_told_in_whole_numbers():
    """As `ros2 param describe` shows it, and a refusal: to the last one that is allowed."""
    frames = next(declaration for declaration in NODES['wind'] if declaration.name == 'frames')
    assert frames.rule == 'a whole number from 0 to 2147483647 [frames]'


def test_a_list_is_told_as_a_list():
    """Of any length, in the plural; of a fixed one, with it."""
    assert Declaration('l', [], 'names', item=str).rule == 'a list of texts'
    assert Declaration('t', [], 'times', 's', 0.0, 9.0).rule == 'a list of numbers from 0 to 9 [s]'
    assert COLOR.rule == 'a list of 3 values, each a number from 0 to 255'


LIMITED = [one for declarations in NODES.values() for one in declarations if one.low is not None]


@pytest.mark.parametrize('declaration', LIMITED, ids=lambda declaration: declaration.name)
def test_a_limit_that_is_printed_is_accepted(declaration):
    """In the rule, in the descriptor or in docs, with however many digits; and is the limit."""
    def accept(number):
        if declaration.is_list:
            return declaration.accept([number] * (declaration.length or 1))[0]
        return declaration.accept(number)
    printed = re.search(r'from (\S+) to (\S+)', declaration.rule).groups()
    for end, text, side in zip((declaration.low, declaration.high), printed, (-1, 1)):
        kind = int if type(declaration.default) is int else float
        rounded = [] if kind is int else [f'{end:.{n}g}' for n in range(4, 17)]
        for number in map(kind, [text, *rounded]):
            assert declaration.low <= accept(number) <= declaration.high
            assert accept(number) == pytest.approx(end, rel=1e-3)
        with pytest.raises(ValueError, match='must be'):
            accept(end + side * (1 if kind is int else 1e-3 * (abs(end) or 1.0)))


def test_the_library_accepts_the_limits_that_it_prints():
    """And prints a value that it refuses so that it is seen to be beyond."""
    for limit in (math.pi, math.pi / 2.0, 2.0 * math.pi, 1.0 / 3.0):
        for printed in (f'{limit:g}', f'{limit:.4g}'):
            assert checks.finite('angle', float(printed), -limit, limit) <= limit
        with pytest.raises(ValueError, match='between -1 and 1, not 1.0000001'):
            checks.finite('share', 1.0000001, -1.0, 1.0)
    with pytest.raises(ValueError, match='at least 0, not -1e-09'):
        checks.finite('share', -1e-9, 0.0)


@pytest.mark.parametrize('limit, said', [(0.0123456, '0.0123'), (1.0 / 1500.0, '0.000666'),
                                         (0.25, '0.25'), (math.inf, 'inf')])
def test_a_limit_that_is_rounded_is_rounded_to_its_safe_side(limit, said):
    """What is told to be stable is."""
    assert checks.rounded_down(limit) == said and float(said) <= limit


def test_there_is_no_minus_zero_and_no_number_is_too_large_to_be_refused():
    """What has a sign must have a size."""
    assert math.copysign(1.0, NUMBER.accept(-0.0)) == 1.0
    for declaration in (NUMBER, Declaration('k', 3, 'count', '', 0, 9)):
        with pytest.raises(ValueError, match='must be a'):
            declaration.accept(10 ** 400)


@pytest.mark.parametrize('node', NODES)
def test_defaults_obey_their_own_rules(node):
    """Every default is a legal value, and no name stands twice."""
    names = [declaration.name for declaration in NODES[node]]
    assert len(set(names)) == len(names)
    for declaration in NODES[node]:
        assert declaration.accept(declaration.default) == declaration.default


def test_what_tune_chooses_can_be_set():
    """Every parameter in a tuned file is one of the nodes'."""
    assert set(CHOSEN) - {'rate'} <= {declaration.name for declaration in NODES['physics']}


@pytest.mark.parametrize('number', [0.1, 1.0, 1e-6, 1e9, 2e9, 1.5e-7, 5e-324, -1e6, 123456.0])
def test_limits_are_printed_as_ros_reads_numbers(number):
    """`ros2 param set` reads by YAML 1.1, to which 1e+09 is a text."""
    assert yaml.safe_load(as_typed(number)) == pytest.approx(number, rel=1e-5)


@pytest.mark.parametrize('value', [np.float32, np.ndarray, Declaration])
def test_an_invalid_value_may_be_a_class(value):
    with pytest.raises(ValueError, match='x must be a number from 0 to 1, not <class'):
        Declaration('x', 0.5, 'effect', '', 0.0, 1.0).accept(value)
