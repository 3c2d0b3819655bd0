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

"""Recipes: what is drawn, and what is refused before the first clip, with its line."""
import math

from flag_sim.dataset.draws import Stream
from flag_sim.dataset.laws import read_law
from flag_sim.dataset.marked_yaml import MarkedError, parse
from flag_sim.dataset.recipe import read_recipe, recipe_of
from flag_sim.dataset.targets import declarations
from flag_sim.declarations.nodes import NODES
from flag_sim.parameters.config import config_path
import numpy as np
import pytest
from support.recipes import recipe, SMALL, text


FIRST, SECOND = 0.06615966689518793, 0.3667019860452668
"""What a stream began with when it was first made."""


def test_a_number_is_the_same_for_ever():
    """Whatever numpy's distributions become: their bits alone count."""
    stream = Stream(7, 731, 'wind.speed')
    assert [stream.unit(), stream.unit()] == [FIRST, SECOND]
    assert Stream(7, 731, 'wind.speed').unit() == FIRST
    assert len({Stream(*place).unit() for place in (
        (7, 731, 'wind.speed'), (8, 731, 'wind.speed'), (7, 732, 'wind.speed'),
        (7, 731, 'wind.azimuth'))}) == 4


def test_a_clip_is_the_same_in_any_order_and_beside_other_parameters():
    first, more = recipe(), recipe(more='  wind.azimuth: {uniform: [-1.0, 1.0]}\n')
    backwards = [first.draw(number).chosen['wind.speed'] for number in (2, 1, 0)]
    assert backwards[::-1] == [more.draw(number).chosen['wind.speed'] for number in range(3)]
    assert len(set(backwards)) == 3


def drawn(law, name, count=4000):
    """Return so many values of a parameter that a law draws."""
    found = read_law(parse(law, 'law'), declarations()[name], name)
    return np.array([found.draw(Stream(1, clip, name)) for clip in range(count)])


def test_laws_are_spread_as_they_say():
    """Means and shares within four standard errors; no value beyond an end."""
    uniform = drawn('{uniform: [2.0, 4.0]}', 'wind.speed')
    assert 2.0 <= uniform.min() and uniform.max() <= 4.0
    assert abs(uniform.mean() - 3.0) < 4.0 * 2.0 / math.sqrt(12 * 4000)
    logs = np.log(drawn('{log_uniform: [0.01, 1.0]}', 'physics.area_density'))
    assert abs(logs.mean() - math.log(0.1)) < 4.0 * math.log(100.0) / math.sqrt(12 * 4000)
    heights = np.sin(drawn('{sphere: [-1.5707, 1.5707]}', 'renderer.sun.elevation'))
    assert abs(heights.mean()) < 4.0 * 2.0 / math.sqrt(12 * 4000)
    assert abs((heights**2).mean() - 1.0 / 3.0) < 0.02
    whole = drawn('{uniform: [3, 5]}', 'physics.grid.rows')
    assert set(whole) == {3, 4, 5} and abs((whole == 4).mean() - 1.0 / 3.0) < 0.03
    words = drawn('{choice: [xpbd, rk4]}', 'physics.solver')
    assert set(words) == {'xpbd', 'rk4'} and abs((words == 'rk4').mean() - 0.5) < 0.04
    colours = drawn('{uniform: [[0, 0, 9], [50, 0, 10]]}', 'renderer.flag.color')
    assert colours.shape == (4000, 3) and np.ptp(colours[:, 1]) == 0.0
    assert abs(np.corrcoef(colours[:, 0], colours[:, 2])[0, 1]) < 0.07


def test_large_seeds_are_not_rounded():
    """A float has no number between these."""
    seeds = [2**53, 2**53 + 1, 2**63 - 1]
    assert [recipe({'seed: 7': f'seed: {seed}'}).seed for seed in seeds] == seeds


def test_what_stands_twice_in_a_choice_is_drawn_twice_as_often():
    words = drawn('{choice: [xpbd, rk4, xpbd]}', 'physics.solver')
    assert (words == 'xpbd').mean() == pytest.approx(2.0 / 3.0, abs=0.04)


def test_splits_are_of_the_share_and_stay_when_there_are_more_clips():
    three = recipe(more='splits: {train: 0.5, validation: 0.2, test: 0.3}\n')
    names = [three.draw(number).split for number in range(2000)]
    for name, share in (('train', 0.5), ('validation', 0.2), ('test', 0.3)):
        assert abs(names.count(name) / 2000 - share) < 0.05


def test_a_range_of_a_parameter_is_held_out():
    held = recipe(more='splits: {by: wind.speed, test: [12.0, 14.0], train: [3.0, 12.0]}\n')
    for number in range(200):
        one = held.draw(number)
        assert one.split == ('test' if one.chosen['wind.speed'] >= 12.0 else 'train')


def test_every_parameter_that_changes_a_clip_can_be_set():
    """And those that only say how nodes send, or how fast they work, cannot."""
    known = declarations()
    for node in ('physics', 'renderer'):
        for declaration in NODES[node]:
            if declaration.name not in ('threads', 'compressed.format',
                                        'compressed.jpeg_quality'):
                assert {f'{node}.{declaration.name}', f'scene.{declaration.name}'} & set(known)
    assert {'wind.speed', 'wind.gust.seed', 'wind.loop'} < set(known)
    assert not {'wind.pace', 'wind.window', 'physics.threads', 'wind.save_to'} & set(known)


def test_the_ready_recipe_is_right():
    found = read_recipe(config_path('flag_wind.yaml'))
    assert (found.clips, found.frames) == (1000, 400)


@pytest.mark.parametrize('line, words, changes', [
    (1, 'seed must be', {'seed: 7': 'seed: -1'}),
    (1, 'seed must be', {'seed: 7': 'seed: 1.5'}),
    (1, 'seed must be a number', {'seed: 7': 'seed: [1]'}),
    (1, 'not 99999999999999999999999999999', {'seed: 7': 'seed: 99999999999999999999999999999'}),
    (1, "'1.0e9' (YAML", {'seed: 7': 'seed: 1.0e9'}),
    (4, 'with a point and a sign', {'frames: 4': 'frames: 4\nrate: 1.0e9'}),
    (4, 'tag:yaml.org,2002:python/tuple is not taken',
     {'[vertices, wind]': '!!python/tuple [vertices, wind]'}),
    (6, 'python/object:os.system is not taken',
     {'{uniform: [3.0, 14.0]}': '!!python/object:os.system {uniform: [3.0, 14.0]}'}),
    (6, 'tag', {'{uniform: [3.0, 14.0]}': '!!python/name:os.system 3.0'}),
    (1, 'no entry', {'seed: 7': 'sed: 7'}),
    (2, 'clips must be', {'clips: 3': 'clips: 0'}),
    (2, 'clips must be', {'clips: 3': 'clips: 99999999999999999999'}),
    (3, 'frames must be', {'frames: 4': 'frames: many'}),
    (3, 'stands there twice', {'frames: 4': 'seed: 4'}),
    (4, 'channels', {'[vertices, wind]': '[vertices, smell]'}),
    (4, 'twice', {'[vertices, wind]': '[vertices, vertices]'}),
    (4, 'at least one', {'[vertices, wind]': '[]'}),
    (4, 'must be a list', {'[vertices, wind]': 'wind'}),
    (6, 'has no parameter', {'wind.speed': 'wind.sped'}),
    (6, 'is named node.parameter', {'wind.speed': 'speed'}),
    (6, 'the recipe has rate', {'wind.speed': 'wind.rate'}),
    (6, 'cannot be set', {'wind.speed': 'wind.pace'}),
    (6, 'name it scene.', {'wind.speed': 'physics.pole.height'}),
    (6, 'from 0 to 200', {'[3.0, 14.0]': '[3.0, 1000.0]'}),
    (6, 'from 0 to 200', {'[3.0, 14.0]': '[-3.0, 14.0]'}),
    (6, 'two ends', {'[3.0, 14.0]': '[3.0]'}),
    (6, 'must be below', {'[3.0, 14.0]': '[14.0, 3.0]'}),
    (6, 'must be below', {'[3.0, 14.0]': '[3.0, 3.0]'}),
    (6, 'must be a list', {'[3.0, 14.0]': '3.0'}),
    (6, 'number', {'[3.0, 14.0]': '[a, b]'}),
    (6, 'with a point and a sign', {'[3.0, 14.0]': '[1e0, 1e1]'}),
    (6, 'above 0', {'{uniform: [3.0, 14.0]}': '{log_uniform: [0.0, 14.0]}'}),
    (6, 'for an elevation', {'{uniform: [3.0, 14.0]}': '{sphere: [0.0, 1.0]}'}),
    (6, 'from 1 to', {'{uniform: [3.0, 14.0]}': '{choice: []}'}),
    (6, 'one of choice, uniform', {'{uniform: [3.0, 14.0]}': '{normal: [3.0, 14.0]}'}),
    (6, 'one of choice, uniform', {'{uniform: [3.0, 14.0]}': '{}'}),
    (6, 'number', {'{uniform: [3.0, 14.0]}': '.nan'}),
    (6, 'number', {'{uniform: [3.0, 14.0]}': 'true'}),
    (7, 'whole number', {'columns: 7': 'columns: 7.5'}),
    (7, 'whole number', {'columns: 7': 'columns: {uniform: [2.5, 7.5]}'}),
    (7, 'for numbers', {'grid.columns: 7': 'solver: {uniform: [rk4, xpbd]}'}),
    (7, 'alias', {'columns: 7': 'columns: &a 7', 'rows: 5': 'rows: *a'}),
    (5, 'entries', {SMALL[SMALL.index('parameters:'):]: 'parameters: [1, 2]\n'}),
])
def test_a_bad_recipe_is_refused_with_its_line(line, words, changes):
    if 'alias' in words:
        line = 8
    with pytest.raises(MarkedError) as error:
        recipe_of(text(changes), 'mine.yaml')
    assert str(error.value).startswith(f'mine.yaml:{line}: ') and words in str(error.value)


@pytest.mark.parametrize('words, more', [
    ('1 together, not 0.9', 'splits: {train: 0.5, test: 0.4}'),
    ('1 together, not 0.9999999', 'splits: {a: 0.3333333, b: 0.3333333, c: 0.3333333}'),
    ('test must begin at 12.0000001, where train ends, not at 12.0000002',
     'splits: {by: wind.speed, train: [3, 12.0000001], test: [12.0000002, 14]}'),
    ('must end at 14, where wind.speed ends, not at 13.9999999',
     'splits: {by: wind.speed, train: [3, 13.9999999]}'),
    ('between 0 and 1', 'splits: {train: 1.5, test: -0.5}'),
    ('from 1 to 100 splits', 'splits: {by: wind.speed}'),
    ('draws from a range', 'splits: {by: wind.azimuth, train: [0, 1]}'),
    ('draws from a range', 'splits: {by: physics.grid.rows, train: [0, 1]}'),
    ('test must begin at 12', 'splits: {by: wind.speed, train: [3, 12], test: [13, 14]}'),
    ('test must begin at 12', 'splits: {by: wind.speed, train: [3, 12], test: [11, 14]}'),
    ('train must begin at 3', 'splits: {by: wind.speed, train: [2, 14]}'),
    ('must end at 14', 'splits: {by: wind.speed, train: [3, 13]}'),
    ('must be a range', 'splits: {by: wind.speed, train: [14, 3]}'),
    ('it names files too', 'splits: {../../evil: 1.0}'),
    ('it names files too', 'splits: {train: 0.5, ..: 0.5}'),
    ('it names files too', 'splits: {"": 1.0}'),
    ('it names files too', 'splits: {"a/b": 1.0}'),
    ('it names files too', 'splits: {by: wind.speed, .hidden: [3, 14]}'),
    ('it names files too', f'splits: {{{"long" * 20}: 1.0}}'),
    ('cannot be keyed', 'tracks: {wind.gust.seed: {times: [0], values: [0]}}'),
    ('of one size', 'tracks: {renderer.width: {times: [0], values: [64]}}'),
    ('both in parameters', 'tracks: {wind.speed: {times: [0], values: [3.0]}}'),
    ('needs values', 'tracks: {wind.azimuth: {times: [0]}}'),
    ("no 'colour'", 'tracks: {wind.azimuth: {times: [0], values: [0], colour: 1}}'),
    ('as many values', 'tracks: {wind.azimuth: {times: [0, 1], values: [0.0]}}'),
    ('from 1 to', 'tracks: {wind.azimuth: {times: [], values: []}}'),
    ('must come after', 'tracks: {wind.azimuth: {times: [{uniform: [0, 2]}, 1], '
     'values: [0, 0]}}'),
    ('is not one of', 'tracks: {wind.azimuth: {times: [0], values: [0], laws: bouncy}}'),
    ('no direction', 'tracks: {wind.elevation: {times: [0], values: [0], turns: true}}'),
    ('True or False', 'tracks: {wind.azimuth: {times: [0], values: [0], turns: 1}}'),
    ('-6.28319 to 6.28319', 'tracks: {wind.azimuth: {times: [0], values: [400.0]}}'),
])
def test_bad_splits_and_tracks_are_refused(words, more):
    with pytest.raises(MarkedError, match=r'^mine.yaml:9: ') as error:
        recipe_of(text(more=f'{more}\n'), 'mine.yaml')
    assert words in str(error.value)


@pytest.mark.parametrize('content', [
    '', '# nothing', '[1, 2]', 'text', 'a: [', 'a: b: c', '\t', '1: 2', '? [1]\n: 2',
    '!!python/x y', '[' * 5000, 'a: ' + '[' * 40 + ']' * 40, 'seed: 7',
    'seed: 7\nclips: 1\nframes: 1',
    '\0', 'seed: !!int x', '- ' * 3000])
def test_what_is_no_recipe_is_refused(content):
    with pytest.raises(MarkedError):
        recipe_of(content, 'mine.yaml')


def test_files_that_cannot_be_read_are_refused(tmp_path):
    (tmp_path / 'binary').write_bytes(bytes(range(256)))
    with open(tmp_path / 'large', 'wb') as file:
        file.truncate(1 << 21)
    for name in ('none', '.', 'binary', 'large'):
        with pytest.raises(MarkedError, match='cannot be read'):
            read_recipe(tmp_path / name)
