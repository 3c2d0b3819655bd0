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

"""Parameters declared beside the fields that they set."""
import dataclasses

from flag_sim.declarations.nodes import NODES
from flag_sim.parameters.declaration import Declaration
from flag_sim.parameters.declared import Declared, declared, Group
import numpy as np
import pytest


@dataclasses.dataclass(frozen=True)
class Lamp(Declared):
    """A record of every type of field, and one that is no parameter."""

    power: float = declared(60.0, 'power of the {thing}', 'W', 0.0, 100.0)
    bulbs: int = declared(1, 'bulbs', '', 1, 9)
    socket: str = declared('E27', 'thread', choices=('E14', 'E27'))
    lit: bool = declared(True, 'on or off', name='switch')
    place: tuple = declared((0.0, 1.0), 'where it hangs', 'm', -5.0, 5.0)
    note: str = ''


LAMPS = Group(Lamp(power=40.0), 'lamp.', thing='lamp')


def test_a_group_names_its_parameters_and_takes_the_records_values_for_defaults():
    """A field's own name stands before the prefix; a tuple is a list of its length."""
    assert [(one.name, one.default) for one in LAMPS] == [
        ('lamp.power', 40.0), ('lamp.bulbs', 1), ('lamp.socket', 'E27'), ('switch', True),
        ('lamp.place', [0.0, 1.0])]
    assert LAMPS.pick('power') == (
        Declaration('lamp.power', 40.0, 'power of the lamp', 'W', 0.0, 100.0),)
    assert (*LAMPS.pick('power'), *LAMPS.without('power')) == tuple(LAMPS)
    assert [one.name for one in Group(Lamp(), exclude=('place', 'lit'), thing='lamp')] == [
        'power', 'bulbs', 'socket']


def test_a_group_makes_its_record_of_values_among_others():
    values = {one.name: one.default for one in LAMPS}
    assert LAMPS.make({**values, 'lamp.bulbs': 3, 'other': 1}) == Lamp(power=40.0, bulbs=3)
    with pytest.raises(ValueError, match=r"^lamp\.socket must be one of E14, E27, not 'E40'$"):
        LAMPS.make({**values, 'lamp.socket': 'E40'})


@pytest.mark.parametrize('field, value, kept', [
    ('power', 3, 3.0), ('power', np.float32(0.5), 0.5), ('power', np.array(7), 7.0),
    ('bulbs', 2.0, 2), ('bulbs', np.int64(9), 9), ('lit', np.bool_(False), False),
    ('place', [1, 2], (1.0, 2.0)), ('place', np.array([1, -5]), (1.0, -5.0))], ids=repr)
def test_any_kind_of_number_is_kept_in_the_fields_type(field, value, kept):
    """Of Python or of numpy; parameters of ROS are of one type each, and stay stricter."""
    got = getattr(Lamp(**{field: value}), field)
    assert got == kept and type(got) is type(kept)
    assert all(type(one) is float for one in Lamp(**{field: value}).place)


@pytest.mark.parametrize('field, value, rule', [
    ('power', 101, 'a number from 0 to 100 [W]'), ('power', True, 'a number from 0 to 100 [W]'),
    ('power', [1.0], 'a number from 0 to 100 [W]'), ('bulbs', 1.5, 'a whole number from 1 to 9'),
    ('bulbs', 0, 'a whole number from 1 to 9'), ('lit', 1, 'a boolean'),
    ('socket', None, 'one of E14, E27'),
    ('place', (1.0,), 'a list of 2 values, each a number from -5 to 5 [m]'),
    ('place', (1.0, 6.0), 'a list of 2 values, each a number from -5 to 5 [m]')], ids=repr)
def test_a_record_refuses_what_its_declarations_refuse(field, value, rule):
    """By the field's name or, for a single value, by another."""
    with pytest.raises(ValueError) as error:
        Lamp(**{field: value})
    assert str(error.value).startswith(f'{field} must be {rule}, not ')
    with pytest.raises(ValueError, match='^my lamp must be '):
        Lamp.accepted(field, value, 'my lamp')


def records(base=Declared):
    """Return the package's classes of declared fields."""
    found = [kind for kind in base.__subclasses__() if kind.__module__.startswith('flag_sim.')]
    return found + [one for kind in found for one in records(kind)]


def test_every_declared_field_is_a_parameter_of_a_node():
    """What is declared beside a field is collected."""
    effects = {one.effect for node in NODES for one in NODES[node]}
    kinds = records()
    assert len(kinds) >= 9
    for kind in kinds:
        for thing in ('flag', 'pole'):
            missing = {one.name for one in Group(kind(), thing=thing) if one.effect not in effects}
            assert missing <= {'transmission'}, kind
