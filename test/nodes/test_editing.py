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

"""An animation that is edited while it plays: what is taken, what is refused, what goes on."""
import math

from flag_sim.declarations.wind import WIND
from flag_sim.ros.frame_message import read_parameters
import numpy as np
import pytest
from std_msgs.msg import Empty
from support.forked import Graph
from support.watch import eventually, Watcher
import yaml

# So long that no machine is so slow that the track is over before the tests are.
SPEED = {'keys.wind.speed.times': [0.0, 1e5], 'keys.wind.speed.values': [5.0, 105.0],
         'keys.wind.speed.laws': ['linear', 'step']}
STEPS = 61  # of two seconds at 30 Hz


class Played:
    """A wind that plays a track of its speed, its client, and what it has sent."""

    def __init__(self, graph, watcher):
        self.graph = graph
        self.watcher = watcher
        self._messages = watcher.listen('parameters')
        given = [part for name, value in SPEED.items()
                 for part in ('-p', f'{name}:=[{", ".join(map(str, value))}]')]
        graph.start('wind', '-p', 'tracks:=[wind.speed]', '-p', 'wait_for:=[]', '-p',
                    'azimuth:=0.0', *given)
        self.client = watcher.parameters_of('wind')

    def next_frames(self, count=3):
        """Return [(time [s], wind, keyed values)] of the next frames."""
        del self._messages[:]
        eventually(lambda: len(self._messages) >= count, self.watcher)
        frames = [read_parameters(message) for message in self._messages]
        return [(frame.stamp / 1e9, wind, keyed) for frame, wind, keyed in frames]

    def assert_goes_on(self):
        """Assert that the track plays as it was given at the start."""
        for time, wind, keyed in self.next_frames():
            assert keyed == {'wind.speed': pytest.approx(5.0 + 1e-3 * time, abs=1e-9)}
            assert wind[0] == pytest.approx(5.0 + 1e-3 * time, abs=1e-9)


@pytest.fixture(scope='module')
def played(tmp_path_factory, module_domain):
    """Return one Played for all tests, none of which may change what it plays."""
    log = tmp_path_factory.mktemp('log')
    with Graph(log, module_domain) as graph, Watcher(module_domain) as watcher:
        yield Played(graph, watcher)


@pytest.mark.parametrize('name, value, said', [
    ('keys.wind.speed.times', [100.0, 0.0], 'times must increase strictly; 0.0 follows 100.0'),
    ('keys.wind.speed.times', [1.0, 1.0], 'times must increase strictly; 1.0 follows 1.0'),
    ('keys.wind.speed.times', [0.0, float('nan')], 'times must be finite, not nan'),
    ('keys.wind.speed.times', [0.0, 1.0, 2.0], 'length, not times of 3, values of 2, laws of 2'),
    ('keys.wind.speed.times', [], 'at least one key; times is empty'),
    ('keys.wind.speed.times', 1.0, 'keys.wind.speed.times must be a list, not 1.0'),
    ('keys.wind.speed.values', [5.0, 300.0], 'from 0 to 200 [m/s], not 300.0'),
    ('keys.wind.speed.values', [5.0, float('nan')], 'not nan'),
    ('keys.wind.speed.values', ['slow', 'fast'], "not 'slow'"),
    ('keys.wind.speed.laws', ['bezier', 'step'], "law 'bezier' is not one of step, linear"),
    ('keys.sun.speed.times', [0.0], "track 'sun.speed' must begin with one of wind, physics"),
    ('keys.physics.colour.times', [0.0], "/physics has no parameter 'colour'"),
    ('tracks', ['wind.speed', 'moon.phase'], "track 'moon.phase' must begin with one of"),
    ('tracks', ['wind.speed', 'physics.colour'], "/physics has no parameter 'colour'"),
    ('tracks', ['wind.speed', 'renderer.threads'], 'this parameter cannot be keyed'),
    ('tracks', ['wind.speed', 'wind.rate'], 'this parameter cannot be keyed'),
    ('tracks', ['wind.speed', 'physics.gravity'], 'needs keys.physics.gravity.times'),
    ('tracks', ['wind.speed', 'wind.speed'], 'tracks must name each track once'),
    ('events.names', ['a'], 'of one length, not 1 and 0'),
    ('rate', -30.0, 'from 0.01 to 1000 [Hz], not -30.0'),
    ('rate', float('inf'), 'not inf'),
    ('frames', -1, 'not -1'),
    ('pace', 'lockstep', 'pace lockstep needs at least one node in wait_for'),
    ('save_to', '/nowhere/shot.yaml', 'save_to: while the node runs it must be a .yaml file in /'),
    ('save_to', '/proc/shot.yaml', 'start the node with it'),
    ('wait_for', ['renderer', 'physics'], 'or your own; physics sends none'),
    ('wait_for', ['/renderer'], "without their namespace, not '/renderer'"),
    ('publish_clock', True, 'publish_clock is fixed at the start of the node'),
])
def test_what_cannot_be_played_is_refused_and_the_animation_goes_on(played, name, value, said):
    """The reason names the rule and the value; nothing of it is kept."""
    result = played.watcher.put(played.client, name, value)
    assert not result.successful and said in result.reason
    played.assert_goes_on()
    assert {key: list(played.watcher.get(played.client, key)) for key in SPEED} == SPEED


def test_nan_and_infinite_numbers_are_refused(played):
    """Each parameter of the wind that is a number refuses NaN and infinity."""
    for declaration in WIND:
        if type(declaration.default) in (int, float):
            for value in (math.nan, math.inf, -math.inf):
                result = played.watcher.put(played.client, declaration.name, value)
                assert not result.successful and f'not {value}' in result.reason
    played.assert_goes_on()


@pytest.mark.parametrize('way', ['load', 'put_atomically'])
def test_a_group_with_a_fault_changes_nothing(played, way):
    """Of times, values and laws that are given at once, none counts if one is wrong."""
    results = getattr(played.watcher, way)(played.client, {
        'keys.wind.speed.times': [0.0, 1.0, 2.0], 'keys.wind.speed.values': [1.0, 2.0, -3.0],
        'keys.wind.speed.laws': ['step', 'step', 'step']})
    for result in results if way == 'load' else [results]:
        assert not result.successful and 'not -3.0' in result.reason
    played.assert_goes_on()
    assert {key: list(played.watcher.get(played.client, key)) for key in SPEED} == SPEED


@pytest.mark.parametrize('way', ['load', 'put_atomically'])
def test_tracks_are_set_replaced_and_removed_while_they_play(tmp_path, domain, way):
    """Lists of other lengths count at once, and a removed track leaves the parameter's value."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        played = Played(graph, watcher)
        put = getattr(watcher, way)

        def plays(keyed, wind):
            _, present, values = played.next_frames(1)[-1]
            return values == keyed and present[0] == wind
        put(played.client, {  # in an order in which no list fits the others before the last one
            'tracks': ['wind.speed', 'physics.gravity'], 'keys.physics.gravity.times': [0.0, 1e-3],
            'keys.physics.gravity.values': [0.0, 1.5], 'keys.wind.speed.times': [0.0, 1e-3, 2e-3],
            'keys.wind.speed.values': [1.0, 2.0, 7.0], 'keys.wind.speed.laws': ['cubic'] * 3})
        eventually(lambda: plays({'wind.speed': 7.0, 'physics.gravity': 1.5}, 7.0), watcher)
        assert watcher.put(played.client, 'tracks', ['physics.gravity']).successful
        eventually(lambda: plays({'physics.gravity': 1.5}, 6.0), watcher)
        assert watcher.put(played.client, 'tracks', []).successful
        eventually(lambda: plays({}, 6.0), watcher)
        assert watcher.put(played.client, 'tracks', ['wind.speed']).successful
        eventually(lambda: plays({'wind.speed': 7.0}, 7.0), watcher)


def frames_of(graph, name, *arguments):
    """Return what a wind sends in two seconds of single steps: {stamp [ns]: (wind, keyed)}."""
    with Watcher(graph.domain) as watcher:
        heard, step = watcher.listen('parameters'), watcher.publisher('step')
        graph.start('wind', *arguments, '-p', 'paused:=true', '-p', 'wait_for:=[]', name=name)
        watcher.parameters_of('wind', step)
        for count in range(1, STEPS + 1):  # one after the other, so that none is lost in a queue
            step.publish(Empty())
            eventually(lambda: len(heard) == count, watcher)
    graph.end(name)
    read = [read_parameters(message) for message in heard]
    return {frame.stamp: (wind.tolist(), keyed) for frame, wind, keyed in read}


def test_a_dumped_animation_plays_identically(tmp_path, domain):
    """What `ros2 param dump` writes is the animation: bit for bit the same frames."""
    shot = {**SPEED, 'tracks': ['wind.speed', 'renderer.flag.color', 'renderer.shading'],
            'keys.wind.speed.laws': ['cubic', 'step'], 'gust.intensity': 0.2, 'gust.seed': 5,
            'keys.renderer.flag.color.times': [0.1, 1.1], 'events.names': ['a'],
            'keys.renderer.flag.color.values': [0.0, 0.1, 0.2, 200.0, 100.0, 50.0],
            'keys.renderer.shading.times': [0.0, 0.5], 'events.times': [0.3],
            'keys.renderer.shading.values': ['flat', 'gouraud'], 'loop': True}
    (tmp_path / 'shot.yaml').write_text(yaml.safe_dump({'/wind': {'ros__parameters': shot}}))
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('wind', '--params-file', str(tmp_path / 'shot.yaml'), '-p', 'paused:=true')
        values = watcher.get_all(watcher.parameters_of('wind'))
        graph.end('wind')
        plain = {name: value.tolist() if hasattr(value, 'tolist') else value
                 for name, value in values.items()}
        (tmp_path / 'dump.yaml').write_text(yaml.safe_dump({'/wind': {'ros__parameters': plain}}))
        first, again = (
            frames_of(graph, name, '--params-file', str(tmp_path / f'{name}.yaml'))
            for name in ('shot', 'dump'))
    assert list(first) == [round(n * 1e9 / 30.0) for n in range(STEPS)]
    assert first == again
    assert len({str(frame) for frame in first.values()}) == STEPS
    assert np.ptp([wind[2] for wind, _ in first.values()]) > 0.1  # there are gusts
