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

"""The shot that `make demo` films is one to show; the others stay as plain as they promise."""
from flag_sim.dataset.recipe import Drawn
from flag_sim.dataset.shot import Shot
from flag_sim.declarations.nodes import defaults, named
from flag_sim.parameters.config import config_path
from flag_sim.tools import demo, view
from flag_sim.viewer.shot_files import read_sections, values_for
import numpy as np
import pytest

LOOKS = ('shadows', 'ground.visible', 'sky.gradient', 'flag.image')
COARSE = {'physics.grid.columns': 16, 'physics.grid.rows': 11, 'physics.damping': 0.025}
"""A quicker cloth, of the same sheet."""


def given(name, node):
    """Return what a params file of config/ says of a node: {parameter: value}."""
    values = values_for(read_sections(config_path(f'{name}.yaml')), f'/{node}')
    keys = {one: value for one, value in values.items() if one.startswith('keys.')}
    return {**keys, **{one: named(node)[one].accept(value) for one, value in values.items()
                       if one in named(node)}}


def test_it_is_large_smooth_and_has_all_looks():
    """By its own file, so that the nodes film the same when they are started by hand."""
    wind, renderer = given(demo.SHOT, 'wind'), given(demo.SHOT, 'renderer')
    assert (renderer['width'], renderer['height'], renderer['samples']) == (1280, 720, 4)
    assert all(renderer[look] for look in LOOKS)
    assert wind['rate'] == 60.0 and wind['frames'] == given(demo.SHOT, 'recorder')['frames']
    assert wind['pace'] == 'lockstep' and wind['wait_for'] == ['renderer', 'recorder']
    ends = [times[-1] for name, times in wind.items() if name.endswith('.times')]
    assert max(ends) == wind['frames'] / wind['rate']


@pytest.mark.parametrize('name', [
    'seed', 'preview', 'balanced', 'accurate', 'calm', 'storm', 'sunrise', view.SHOT])
def test_the_others_are_plain(name):
    """The course project had no such looks; presets, and what is shown live, are quick to draw."""
    renderer = {**defaults('renderer'), **given(name, 'renderer')}
    assert not any(renderer[look] for look in LOOKS)


def seen(camera, points):
    """Return where points (n, 3) [m] are in the image: columns and rows as shares of its sides."""
    x, y, z = camera.pose[:3, :3] @ points.T + camera.pose[:3, 3:]
    assert np.all(z > camera.near)
    pixels = camera.focal * np.array([x, y]) / z + np.array(camera.centre)[:, None]
    return (pixels + 0.5) / np.array([[camera.width], [camera.height]])


def test_neither_the_flag_nor_its_shadow_leaves_the_picture():
    """Nor do sky and quay: the flag flies between them, from the first frame to the last."""
    wind = given(demo.SHOT, 'wind')
    keys = {name: value for name, value in wind.items() if name.startswith('keys.')}
    chosen = {f'{node}.{name}': value for node in ('wind', 'physics', 'renderer')
              for name, value in given(demo.SHOT, node).items()
              if name not in keys and name != 'tracks'}
    drawn = Drawn(0, '', {**chosen, **COARSE}, keys)
    for moment in Shot(drawn, wind['frames'], wind['rate']):
        if moment.index % 5:
            continue
        flag, camera = moment.positions.reshape(-1, 3), moment.look.camera
        quay = drawn.values['renderer']['pole.position'][2]
        sun = np.array(moment.look.light.direction)
        shadow = flag - (flag[:, 2:] - quay) / sun[2] * sun
        for points in (flag, shadow):
            inside = seen(camera, points)
            assert inside.min() > 0.02 and inside.max() < 0.98
        horizon = seen(camera, camera.position + np.array([[0.0, 1e6, 0.0]]))[1, 0]
        assert 0.4 < horizon < 0.67
