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

"""What users type wrong is refused in words, at each class of the library that they touch."""
import copy
import dataclasses
import math

from flag_sim.animation.gusts import Gusts
from flag_sim.animation.timeline import Timeline
from flag_sim.animation.tracks import Track
from flag_sim.animation.wind_vector import Passage, wind_vector
from flag_sim.cloth import Air, Cloth, Material, Stepping
from flag_sim.cloth.energy import bending_energy, elastic_energy, kinetic_energy
from flag_sim.cloth.normals import node_normals
from flag_sim.cloth.self_intersection import is_self_intersecting
from flag_sim.cloth.strain import greatest_strain
from flag_sim.parameters import checks
import numpy as np
import pytest

TRACK = Track([0.0, 1.0], [0.0, 1.0])
LOOP = Timeline({'a': TRACK}, loop=True)


@pytest.fixture(scope='module')
def cloth():
    """Return a small cloth that nobody can change by mistake."""
    return Cloth(3, 4)


@pytest.mark.parametrize('name, said', [
    ('stiffness', "Cloth has no attribute 'stiffness': it is a field of material; set material = "
     'dataclasses.replace(material, stiffness=...)'),
    ('drag_coefficient', 'it is a field of air'), ('substeps', 'it is a field of stepping'),
    ('gravty', "no attribute 'gravty'; those that can be set are air, gravity, material, pole, "),
    ('wind', "no attribute 'wind'"), ('rows', "no attribute 'rows'"),
    ('positions', ''), ('mesh', ''), ('held', ''), ('hoist_top', ''), ('model', '')])
def test_a_cloth_takes_no_attribute_that_has_no_effect(cloth, name, said):
    """Those of its parts are named with their part, and those that are only read are refused."""
    with pytest.raises(AttributeError) as error:
        setattr(cloth, name, 500)
    assert said in str(error.value)
    if said:
        assert not hasattr(cloth, name)


def test_what_a_cloth_has_can_be_set_also_in_a_copy(cloth):
    """As the message says it."""
    other = copy.copy(cloth)
    other.material = dataclasses.replace(other.material, stiffness=500)
    assert (cloth.material.stiffness, other.material.stiffness) == (1000.0, 500.0)
    with pytest.raises(AttributeError):
        other.stiffness = 3.0


@pytest.mark.parametrize('thing, known', [
    (Material(), 'stiffness'), (Air(), 'density'), (Stepping(), 'substeps'),
    (Cloth(3, 4).advance(0.01), 'granted'), (Cloth(3, 4).mesh, 'rows'),
    (Cloth(3, 4).model, 'mass'), (TRACK, 'times'), (Timeline({'a': TRACK}), 'loop'),
    (Gusts(5.0, 0), 'length'), (Passage(float), 'start')], ids=lambda v: type(v).__name__)
def test_what_is_made_once_cannot_be_changed(thing, known):
    """Neither what it has, for its other parts follow from that, nor what it has not."""
    for name in (known, 'stifness'):
        with pytest.raises(AttributeError):
            setattr(thing, name, 2)


@pytest.mark.parametrize('arguments, said', [
    ({'rows': '21'}, "rows must be a whole number from 2 to 1001 [nodes], not '21'"),
    ({'rows': True}, 'rows must be a whole number from 2 to 1001 [nodes], not True'),
    ({'rows': [21]}, 'rows must be a whole number from 2 to 1001 [nodes], not [21]'),
    ({'columns': None}, 'columns must be a whole number from 2 to 1001 [nodes], not None'),
    ({'length': -1}, 'length must be between 0.001 and 10000, not -1'),
    ({'width': np.array([1.0])}, 'width must be a number, not array([1.])'),
    ({'pinned': 'no'}, "pinned must be True or False, not 'no'"),
    ({'pinned': 0}, 'pinned must be True or False, not 0'),
    ({'hoist_top': 5}, 'hoist_top must have shape (3,), not ()'),
    ({'hoist_top': (True, 0.0, 1.0)}, 'hoist_top must hold numbers'),
    ({'hoist_top': (10**400, 0, 0)}, 'hoist_top must hold numbers'),
    ({'material': 0}, 'material must be of class Material, not 0'),
    ({'material': Air()}, 'material must be of class Material'),
    ({'air': ''}, "air must be of class Air, not ''"),
    ({'stepping': False}, 'stepping must be of class Stepping, not False'),
    ({'gravity': True}, 'gravity must be a number from 0 to 1000 [m/s2], not True'),
    ({'gravity': 10**400}, 'gravity must be a number'),
    ({'gravity': 9.81 + 0j}, 'gravity must be a number'),
    ({'stretch_limit': 'no'}, "stretch_limit must be a number from 0 to 1.0e+06, not 'no'"),
    ({'pole': 0.05}, 'pole must have shape (3,), not ()'),
    ({'pole': (0.0, 0.0, -0.1)}, 'radius of the pole must be greater than 0, not -0.1'),
    ({'precision': 64}, 'precision must be one of float64, float32, not 64'),
    ({'solver': None}, 'solver must be one of'),
    ({'threads': -1}, 'threads must be a whole number from 0 to 64, not -1'),
    ({'threads': 1.5}, 'threads must be a whole number from 0 to 64, not 1.5'),
    ({'threads': True}, 'threads must be a whole number from 0 to 64, not True')], ids=str)
def test_a_cloth_is_not_made_of_what_it_cannot_be(arguments, said):
    """Each by the name of the argument, with the value."""
    with pytest.raises(ValueError) as error:
        Cloth(**arguments)
    assert str(error.value).startswith(said)


@pytest.mark.parametrize('change, said', [
    (lambda c: c.advance('0.1'), "dt must be a number, not '0.1'"),
    (lambda c: c.advance(True), 'dt must be a number, not True'),
    (lambda c: c.advance(np.array([0.1])), 'dt must be a number, not array([0.1])'),
    (lambda c: c.advance(0.1, 5.0), 'wind must have shape (3,), not ()'),
    (lambda c: c.advance(0.1, None), 'wind must hold numbers, not None'),
    (lambda c: c.advance(0.1, (True, False, False)), 'wind must hold numbers'),
    (lambda c: c.advance(0.1, (1.0, True, 0.0)), 'wind must hold numbers'),
    (lambda c: c.advance(0.1, [[1.0, 2.0, 3.0]]), 'wind must have shape (3,), not (1, 3)'),
    (lambda c: c.advance(0.1, [1.0, [2.0], 3.0]), 'wind must hold numbers'),
    (lambda c: c.advance(0.1, (1j, 0, 0)), 'wind must hold numbers'),
    (lambda c: c.place(None), 'positions must hold numbers, not None'),
    (lambda c: c.place(np.zeros((4, 3, 3))), 'positions must have shape (3, 4, 3)'),
    (lambda c: c.place(np.zeros((3, 4, 3), bool)), 'positions must hold numbers'),
    (lambda c: c.place(c.positions, 0.0), 'velocities must have shape (3, 4, 3), not ()'),
    (lambda c: c.regrid(1, 4), 'rows must be a whole number from 2 to 1001 [nodes], not 1'),
    (lambda c: c.regrid(3, 2.5), 'columns must be a whole number from 2 to 1001 [nodes], not 2.5'),
    (lambda c: c.hang((0, 0), 1.0, 1.0), 'hoist_top must have shape (3,), not (2,)'),
    (lambda c: c.hang((0, 0, 1), 1.0, '1'), "width must be a number, not '1'"),
    (lambda c: setattr(c, 'precision', np.zeros(3)), 'precision must be one of'),
    (lambda c: setattr(c, 'pole', True), 'pole must '),
    (lambda c: setattr(c, 'material', Material), 'material must be of class Material')])
def test_what_a_cloth_cannot_do_is_refused(cloth, change, said):
    """And it stays as it was."""
    before = cloth.positions
    with pytest.raises(ValueError) as error:
        change(cloth)
    assert str(error.value).startswith(said)
    assert np.array_equal(cloth.positions, before)


FIGURES = {
    'kinetic energy': lambda c, nodes: kinetic_energy(c.model, nodes),
    'elastic energy': lambda c, nodes: elastic_energy(c.model, nodes),
    'bending energy': lambda c, nodes: bending_energy(c.model, nodes),
    'greatest strain': lambda c, nodes: greatest_strain(c.mesh, nodes),
    'normals': lambda c, nodes: node_normals(nodes),
    'self-intersection': lambda c, nodes: is_self_intersecting(nodes)}


@pytest.mark.parametrize('figure', FIGURES.values(), ids=FIGURES)
def test_figures_about_nodes_take_them_in_any_form(cloth, figure):
    """Those that are no vectors of nodes are refused, and never read beyond their end."""
    nodes = np.rint(8.0 * cloth.positions)
    expected = figure(cloth, nodes)
    spread = np.zeros((6, 8, 6))
    spread[::2, ::2, ::2] = nodes
    for same in (nodes.tolist(), nodes.astype('>f4'), nodes.astype(np.uint8), nodes.astype('g'),
                 np.asfortranarray(nodes), spread[::2, ::2, ::2], nodes[::-1].copy()[::-1]):
        np.testing.assert_allclose(figure(cloth, same), expected, rtol=1e-12)
    for wrong in (None, 'abc', nodes + 0j, nodes > 0.0, [[1.0, 2.0], [3.0]], nodes[..., :2],
                  nodes[:1], nodes[0], np.zeros((3, 0, 3)), np.zeros(()), nodes.astype(str)):
        with pytest.raises(ValueError, match='^(positions|velocities) must '):
            figure(cloth, wrong)


@pytest.mark.parametrize('kind', [Material, Air, Stepping])
@pytest.mark.parametrize('value', [True, 'much', None, [1.0], math.nan, math.inf, -1.0])
def test_no_field_takes_what_is_no_quantity(kind, value):
    """Each by its own name, as it is typed."""
    for field in dataclasses.fields(kind):
        with pytest.raises(ValueError, match=f'^{field.name} must be '):
            kind(**{field.name: value})


@pytest.mark.parametrize('make, said', [
    (lambda: Timeline({'a': [0.0, 1.0]}), "track 'a' must be of class Track"),
    (lambda: Timeline({}, [(math.nan, 'bang')]), "time of the event 'bang' must be finite"),
    (lambda: Timeline({}, [('bang', 1.0)]), 'name of an event must be a text, not 1.0'),
    (lambda: Timeline({'a': TRACK}, loop='no'), "loop must be True or False, not 'no'"),
    (lambda: TRACK.at(math.nan), 'time must be finite, not nan'),
    (lambda: Timeline({'a': TRACK}).value('a', math.inf), 'time must be finite, not inf'),
    (lambda: TRACK.at('x'), "time must be a number, not 'x'"),
    (lambda: TRACK.at(10**400), 'time must be a number, not 1000'),
    (lambda: LOOP.at(None), 'time must be a number, not None'),
    (lambda: LOOP.at(math.inf), 'time must be finite, not inf'),
    (lambda: LOOP.at(1e308), 'time must be between -1e+12 and 1e+12, not 1e+308'),
    (lambda: LOOP.value('a', math.nan), 'time must be finite, not nan'),
    (lambda: LOOP.value('b', 0), "name must be that of a track, not 'b'"),
    (lambda: LOOP.value(['a'], 0), "name must be that of a track, not ['a']"),
    (lambda: Track([0.0, 1j], [0.0, 1.0]), 'times must be numbers, not 1j'),
    (lambda: Track([0.0], memoryview(np.zeros((1, 2)))), 'values must be a list, not <memory'),
    (lambda: LOOP.crossed('a', 1), "after must be a number, not 'a'"),
    (lambda: LOOP.crossed(0, math.nan), 'until must be finite, not nan'),
    (lambda: LOOP.crossed(0, 1e12), 'until must be at most 500000 rounds of the loop after 0 s'),
    (lambda: Timeline(None), 'tracks must be a dict of names and Tracks, not None'),
    (lambda: Timeline([1]), 'tracks must be a dict of names and Tracks, not [1]'),
    (lambda: Timeline({1: TRACK}, [(0, 'a')]), 'name of a track must be a text, not 1'),
    (lambda: Timeline({}, 5), 'events must be a list, not 5'),
    (lambda: Timeline({}, [(1,)]), 'each of events must be a time [s] and a name, not (1,)'),
    (lambda: Gusts(5.0, 0).at(1e308), 'distance must be between -1e+24 and 1e+24, not 1e+308'),
    (lambda: wind_vector(1e308, 0.0, 0.0), 'speed must be between -1e+12 and 1e+12, not 1e+308'),
    (lambda: wind_vector(1.0, 0.0, 0.0, (1e308, 0, 0)), 'gust must be finite and at most 1e+12'),
    (lambda: Passage(5), 'speed_at must be a function of the time, not 5'),
    (lambda: Passage(lambda _: 'x'), "speed_at(0) must be a number, not 'x'"),
    (lambda: Passage(lambda _: None), 'speed_at(0) must be a number, not None'),
    (lambda: Passage(lambda _: math.nan), 'speed_at(0) must be finite, not nan'),
    (lambda: Passage(float).at(1e9), 'time must be at most 604800, 604800 s after what is known'),
    (lambda: Gusts('long', 0), "length must be a number from 0.01 to 10000 [m], not 'long'"),
    (lambda: Gusts(math.nan, 0), 'length must be a number from 0.01 to 10000 [m], not nan'),
    (lambda: Gusts(5.0, -1), 'seed must be a whole number from 0 to 2147483647, not -1'),
    (lambda: Gusts(5.0, 0.5), 'seed must be a whole number from 0 to 2147483647, not 0.5'),
    (lambda: Gusts(5.0, 0).at(math.nan), 'distance must be finite, not nan'),
    (lambda: wind_vector('fast', 0.0, 0.0), "speed must be a number, not 'fast'"),
    (lambda: wind_vector(1.0, math.nan, 0.0), 'azimuth must be finite, not nan'),
    (lambda: wind_vector(1.0, 0.0, 0.0, (0.1, 0.2)), 'gust must have shape (3,), not (2,)'),
    (lambda: Passage(float, start='now'), "start must be a number, not 'now'"),
    (lambda: Passage(float, start=2.0).at(1.0), 'time must be at least 2, not 1')])
def test_no_animation_is_made_of_what_cannot_be_played(make, said):
    """By the words of who calls it, not by those of the nodes' parameters."""
    with pytest.raises(ValueError) as error:
        make()
    assert str(error.value).startswith(said) and len(str(error.value)) <= 300


@pytest.mark.parametrize('value, words', [
    ('ab', "'ab'"), (np.zeros(2), 'array([0., 0.])'), (10**5000, 'a value of class int')],
    ids=['text', 'array', 'digits'])
def test_a_short_value_is_shown_as_it_is(value, words):
    """Or by its class, where Python itself does not show it."""
    assert checks.shown(value) == words


@pytest.mark.parametrize('value', [np.zeros((9, 9, 3), complex), [0.5] * 999, 'a' * 999])
def test_a_long_value_is_shown_by_its_beginning(value):
    """On one line, whichever check refuses it."""
    for check in (lambda: checks.array('it', value, (3,)), lambda: checks.boolean('it', value),
                  lambda: checks.finite('it', value)):
        with pytest.raises(ValueError) as error:
            check()
        assert len(str(error.value)) <= 300 and '\n' not in str(error.value)


@pytest.mark.parametrize('dt', [3601, -1, 0.0])
def test_a_range_that_is_open_below_says_so(cloth, dt):
    """It has no end that a user could take."""
    with pytest.raises(ValueError, match=f'greater than 0 and at most 3600, not {dt:g}'):
        cloth.advance(dt)


@pytest.mark.parametrize('value', [3, 3.0, np.float32(3.0), np.int64(3), np.array(3.0)], ids=repr)
def test_any_kind_of_number_is_one(value):
    """Whole or not, of Python or of numpy."""
    assert checks.finite('n', value) == 3.0 and checks.whole('n', value, 0, 9) == 3


@pytest.mark.parametrize('arguments, said', [
    (('01', [1.0, 2.0]), "times must be a list, not '01'"),
    ((math.nan, [1.0]), 'times must be a list, not nan'),
    (([True], [1.0]), 'times must be numbers, not True'),
    (([b'1'], [1.0]), "times must be numbers, not b'1'"),
    (([0.0, 1.0], 'ab'), "values must be a list, not 'ab'"),
    (([0.0], None), 'values must be a list, not None'),
    (([0.0, 1.0], [1.0, 2.0], 1), 'laws must be a list, not 1')])
def test_keys_that_are_no_lists_are_refused(arguments, said):
    """By the rule and the value; a text is no list of its letters."""
    with pytest.raises(ValueError, match=said):
        Track(*arguments)
