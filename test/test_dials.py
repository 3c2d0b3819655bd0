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

"""Dials: what is accepted, what is refused, and that all places agree on them."""
import array
import inspect

from flag_sim.cloth import Cloth
from flag_sim.cloth.material import Air, LAWS, Material
from flag_sim.cloth.mesh import PRECISIONS
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.cloth.stability import Stepping
from flag_sim.dials.catalogue import NODES
from flag_sim.dials.dial import Dial
from flag_sim.dials.settings import air_of, CLOTH, look_of, material_of, stepping_of
from flag_sim.drawing.camera import Camera
from flag_sim.drawing.shading import Light
from flag_sim.drawing.shapes import Scene
from flag_sim.drawing.style import Materials, SAMPLES, Style
from flag_sim.study.search import CHOSEN
import pytest

NUMBER = Dial('n', 1.0, 'a number', 'm', 0.0, 2.0)
COLOR = Dial('c', [1.0, 2.0, 3.0], 'a colour', '', 0.0, 255.0, length=3)


@pytest.mark.parametrize('dial, value, expected', [
    (NUMBER, 2, 2.0),
    (COLOR, [1, 2, 3.5], [1.0, 2.0, 3.5]),
    (Dial('k', 3, 'count', '', 0, 9), 9, 9),
    (Dial('b', False, 'switch'), True, True),
    (Dial('w', 'a', 'word', choices=('a', 'b')), 'b', 'b'),
    (Dial('s', 1, 'some', choices=(1, 4)), 4, 4),
    (Dial('l', [], 'names', item=str), ['x', 'y'], ['x', 'y']),
])
def test_good_values_come_back_in_the_dials_type(dial, value, expected):
    """A whole number is good for a number; everything else is kept."""
    accepted = dial.accept(value)
    assert accepted == expected
    assert type(accepted) is type(dial.default)


@pytest.mark.parametrize('dial, value', [
    (NUMBER, 2.1), (NUMBER, -0.1), (NUMBER, float('nan')), (NUMBER, float('inf')),
    (NUMBER, 'one'), (NUMBER, True), (NUMBER, None), (NUMBER, [1.0]),
    (COLOR, [1.0, 2.0]), (COLOR, [1.0, 2.0, 256.0]), (COLOR, 'red'), (COLOR, 4),
    (Dial('k', 3, 'count', '', 0, 9), 2.5), (Dial('k', 3, 'count', '', 0, 9), 10),
    (Dial('s', 1, 'some', choices=(1, 4)), 2), (Dial('s', 1, 'some', choices=(1, 4)), True),
    (Dial('s', 1, 'some', choices=(1, 4)), 4.0), (Dial('s', 1, 'some', choices=(1, 4)), '4'),
    (Dial('b', False, 'switch'), 1), (Dial('w', 'a', 'word', choices=('a', 'b')), 'c'),
    (NUMBER, array.array('d', [1.0])), (COLOR, array.array('d', [1.0])),
    (Dial('l', [], 'names', item=str), [1]), (Dial('l', [], 'names', item=str), 'x'),
])
def test_bad_values_are_refused_with_the_rule_and_the_value(dial, value):
    """The message holds the name, the rule and what was given."""
    with pytest.raises(ValueError) as refusal:
        dial.accept(value)
    given = value.tolist() if isinstance(value, array.array) else value
    for part in (dial.name, dial.rule, f'not {given!r}'):
        assert part in str(refusal.value)


def test_a_range_of_whole_numbers_is_told_in_whole_numbers():
    """As `ros2 param describe` shows it, and a refusal: to the last one that is allowed."""
    frames = next(dial for dial in NODES['wind'] if dial.name == 'frames')
    assert frames.rule == 'a whole number from 0 to 2147483647 [frames]'


def test_a_list_is_told_as_a_list():
    """Of any length, in the plural; of a fixed one, with it."""
    assert Dial('l', [], 'names', item=str).rule == 'a list of texts'
    assert Dial('t', [], 'times', 's', 0.0, 9.0).rule == 'a list of numbers from 0 to 9 [s]'
    assert COLOR.rule == 'a list of 3 values, each a number from 0 to 255'


@pytest.mark.parametrize('node', NODES)
def test_defaults_obey_their_own_rules(node):
    """Every default is a legal value, and no name stands twice."""
    names = [dial.name for dial in NODES[node]]
    assert len(set(names)) == len(names)
    for dial in NODES[node]:
        assert dial.accept(dial.default) == dial.default


def test_every_solver_law_precision_and_number_of_samples_can_be_chosen():
    """The choices of the node are those of the library."""
    physics = {dial.name: dial for dial in NODES['physics']}
    assert set(physics['solver'].choices) == set(SOLVERS)
    assert set(physics['air.law'].choices) == set(LAWS)
    assert physics['precision'].choices == PRECISIONS
    renderer = {dial.name: dial for dial in NODES['renderer']}
    assert renderer['samples'].choices == SAMPLES


def test_defaults_are_those_of_the_library():
    """The nodes and the classes below them start from the same values."""
    physics = {dial.name: dial.default for dial in NODES['physics']}
    assert material_of(physics) == Material()
    assert air_of(physics) == Air()
    assert stepping_of(physics) == Stepping()
    cloth = inspect.signature(Cloth).parameters
    for dial, argument in CLOTH.items():
        assert cloth[argument].default == physics[dial], dial
    renderer = {dial.name: dial.default for dial in NODES['renderer']}
    assert look_of(renderer) == (Camera(), Light(), Materials(), Scene(), Style())


def test_what_tune_chooses_can_be_set():
    """Every dial in a tuned file is one of the nodes'."""
    assert set(CHOSEN) - {'rate'} <= {dial.name for dial in NODES['physics']}
