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

"""Which parameters tracks animate, and that a pole cannot be moved in one node alone."""
from flag_sim.animation.keys import read_timeline, values_at
from flag_sim.declarations.keyable import TARGETS
from flag_sim.declarations.nodes import defaults, own_values
from flag_sim.declarations.pole_match import PATIENCE, PoleMatch
import numpy as np
import pytest


@pytest.mark.parametrize('node', ['physics', 'renderer'])
@pytest.mark.parametrize('name', ['pole.position', 'pole.yaw', 'pole.tilt'])
def test_where_the_pole_is_is_keyed_for_both_nodes(node, name):
    track = f'{node}.{name}'
    with pytest.raises(ValueError, match=f"'{track}' is keyed as 'scene.{name}'"):
        TARGETS[track]
    assert TARGETS.track_of(node, name) == f'scene.{name}' in TARGETS
    assert TARGETS.track_of(node, 'pole.height') == f'{node}.pole.height' in TARGETS


def test_a_track_of_the_scene_reaches_both_nodes_and_the_own_one_wins():
    wind = {**defaults('wind'), 'tracks': ['scene.pole.position', 'scene.pole.height',
                                           'renderer.pole.height', 'physics.gravity'],
            'keys.scene.pole.position.times': [0.0, 1.0],
            'keys.scene.pole.position.values': [0.0, 0.0, 0.0, 4.0, 2.0, 0.0],
            'keys.scene.pole.height.times': [0.0], 'keys.scene.pole.height.values': [5.0],
            'keys.renderer.pole.height.times': [0.0], 'keys.renderer.pole.height.values': [6.0],
            'keys.physics.gravity.times': [0.0], 'keys.physics.gravity.values': [1.0]}
    keyed = values_at(read_timeline(wind, TARGETS), 0.5, TARGETS)
    place = {'pole.position': [2.0, 1.0, 0.0]}
    assert own_values('physics', keyed) == {**place, 'pole.height': 5.0, 'gravity': 1.0}
    assert own_values('renderer', keyed) == {**place, 'pole.height': 6.0}


def test_a_yaw_is_a_direction_and_a_tilt_is_none():
    assert TARGETS['scene.pole.yaw'].is_angle and not TARGETS['scene.pole.tilt'].is_angle


def test_a_flag_that_hangs_beside_the_pole_for_a_while_is_told_once():
    """Parameters of two nodes are set in turn; and who hides the pole may hang it anywhere."""
    values = {**defaults('renderer'), 'pole.yaw': 0.5}
    match = PoleMatch()
    there = np.zeros((2, 2, 3)) + [0.05 * np.cos(0.5), 0.05 * np.sin(0.5), 8.9]

    def told(vertices, count, values=values):
        return [entry for _ in range(count) for entry in match.update(vertices, values)]

    assert told(there, 20) == []
    assert told(there + [0.5, 0.0, 0.0], PATIENCE - 1) == []
    assert told(there, 1) == []
    (entry,) = told(there + [0.5, 0.0, 0.0], 3 * PATIENCE)
    assert 'must be the same in physics and in the renderer' in entry.text
    assert '(0.544 0.024 8.900) m' in entry.text and '(0.044 0.024 8.900) m' in entry.text
    assert told(there + 1.0, 2 * PATIENCE, {**values, 'pole.visible': False}) == []
