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

"""Clips: the same bytes as the nodes film, and a reason where one cannot be made."""
from concurrent.futures import ThreadPoolExecutor
import re

from flag_sim.cloth import Cloth, Diverged
from flag_sim.dataset import Clips
from flag_sim.dataset.__main__ import main
from flag_sim.dataset.channels import CHANNELS
from flag_sim.dataset.clip import make_clip, views
from flag_sim.dataset.recipe import read_recipe
from flag_sim.dataset.store import Store
from flag_sim.testing.film import play
import numpy as np
import pytest
from support.recipes import recipe, text
import yaml

MOVING = """\
  wind.gust.intensity: 0.2
  wind.gust.seed: {uniform: [0, 1000]}
  physics.preroll: 0.5
  physics.area_density: {log_uniform: [0.1, 0.4]}
  renderer.samples: 4
  renderer.flag.color: {uniform: [[20, 20, 20], [250, 250, 250]]}
  scene.pole.diameter: {choice: [0.08, 0.12]}
tracks:
  renderer.camera.azimuth:
    times: [0.0, {uniform: [0.1, 0.2]}]
    values: [-1.57, {uniform: [-1.4, -1.2]}]
  wind.azimuth: {times: [0.0, 0.1], values: {uniform: [-0.5, 0.5]}, laws: cubic}
  physics.gravity: {times: [0.0, 0.1], values: [9.81, 3.0]}
"""
TOPICS = {'camera/image_raw': 'colour', 'camera/depth/image_raw': 'depth',
          'camera/normals/image_raw': 'normals', 'camera/labels/image_raw': 'labels',
          'camera/texture_coordinates/image_raw': 'texture_coordinates',
          'camera/flow/image_raw': 'backward_flow', 'vertices': 'vertices'}


def six(wrench):
    """Return the numbers of a Wrench."""
    return [getattr(one, axis) for one in (wrench.force, wrench.torque) for axis in 'xyz']


@pytest.fixture
def made(tmp_path):
    """Return a function that makes one clip of a recipe and returns its row."""
    def make(recipe, number=0):
        store = Store(tmp_path / 'made')
        store.making.mkdir(parents=True, exist_ok=True)
        return make_clip(recipe, number, store)
    return make


def test_a_clip_is_what_the_nodes_film(tmp_path):
    """Every image and all vertices to the byte, with keys, gusts and a preroll; and the poses."""
    (tmp_path / 'mine.yaml').write_text(text(channels=CHANNELS, more=MOVING))
    assert main([str(tmp_path / 'mine.yaml'), '--output', str(tmp_path / 'set'), '--shard', '1/3'
                 ]) == 0
    found = read_recipe(tmp_path / 'mine.yaml')
    shot = tmp_path / 'shot.yaml'
    shot.write_text(yaml.safe_dump(found.draw(0).params_file(found.frames, found.rate)))
    topics = [*TOPICS, 'camera/pose', 'pole_load']
    filmed = list(play(tmp_path / 'film', found.frames, topics, shot))
    clip = Clips(tmp_path / 'set')[0]
    assert len(filmed) == found.frames and clip.number == 0
    for k, frame in enumerate(filmed):
        for topic, name in TOPICS.items():
            theirs = frame[topic][..., :3] if topic == 'vertices' else frame[topic]
            assert clip[name][k].tobytes() == theirs.tobytes(), (k, name)
        pose = clip['camera_pose'][k]
        position = frame['camera/pose'].pose.position
        assert np.allclose(-pose[:3, :3].T @ pose[:3, 3], [position.x, position.y, position.z])
        assert np.array_equal(clip['pole_load'][k], six(frame['pole_load'].wrench))
        assert abs(clip['time'][k] - frame['stamp']) < 1e-9
    assert np.isnan(clip['backward_flow'][0]).all() and np.isnan(clip['forward_flow'][-1]).all()
    assert np.nanmax(np.abs(clip['forward_flow'][0])) > 0.1


def test_forward_flow_is_the_next_backward_flow_seen_from_here(made):
    """Where a pixel's point is seen in both frames, one leads there and the other back."""
    found = recipe(channels=['labels', 'backward_flow', 'forward_flow'], more=MOVING)
    kept = [(view.frame.labels.copy(), view.frame.flow.copy(), view.forward.flow,
             view.forward.is_hidden) for view in views(found, found.draw(1))]
    (labels, _, forward, hidden), (_, back, _, _) = kept[1:3]
    rows, columns = np.nonzero((labels == 1) & ~hidden)
    v, u = np.rint(np.stack([rows, columns]) + forward[rows, columns, ::-1].T).astype(int)
    inside = (0 <= u) & (u < 64) & (0 <= v) & (v < 48)
    off = forward[rows, columns][inside] + back[v[inside], u[inside]]
    assert len(off) > 200 and np.nanmedian(np.abs(off)) < 0.05


@pytest.mark.parametrize('reason, channels, more', [
    ('does not see the flag', ['depth'], '  renderer.camera.target: [0.0, 0.0, 500.0]\n'),
    ('does not see the flag', ['backward_flow'], '  renderer.camera.near: 900.0\n'),
    ('more than max_gap', None, '  physics.max_gap: 0.01\n'),
    ('pole.diameter', None, '  scene.pole.diameter: 0.5\n  scene.pole.height: 0.4\n'),
    ('^air.added_mass above 0 needs', None,
     '  physics.solver: verlet\n  physics.air.added_mass: 0.5\n'),
    ('^frame 1: air.added_mass above 0 needs', None, '  physics.solver: verlet\n'
     'tracks: {physics.air.added_mass: {times: [0.0, 0.1], values: [0.0, 0.5]}}\n'),
    ('flag.width must be 0 or', None,
     'tracks: {physics.flag.width: {times: [0.0, 99.0], values: [0.0, 1.0]}}\n'),
])
def test_a_clip_that_cannot_be_made_says_why(made, reason, channels, more):
    row = made(recipe(channels=channels, more=more))
    assert row['status'] == 'failed' and re.search(reason, row['reason']), row['reason']
    assert row['file'] == '' and row['parameters']['physics.grid.rows'] == 5


def test_a_clip_that_diverges_says_where(made, monkeypatch):
    def advance(cloth, dt, wind, pose=None):
        raise Diverged('the cloth is beyond all bounds')
    monkeypatch.setattr(Cloth, 'advance', advance)
    row = made(recipe())
    assert (row['status'], row['reason']) == ('failed', 'frame 1: the cloth is beyond all bounds')


def test_threads_of_one_process_make_the_same_clips(tmp_path):
    """Also where a worker has more than the one thread that it should have."""
    found = recipe({'frames: 4': 'frames: 30'}, channels=['colour', 'depth', 'forward_flow'])
    store = Store(tmp_path / 'made')
    store.making.mkdir(parents=True)

    def make(number):
        return make_clip(found, number, store)['content']
    alone = [make(number) for number in range(4)]
    with ThreadPoolExecutor(2) as pool:
        assert list(pool.map(make, range(4))) == alone


def test_a_clip_without_images_is_not_drawn(made, monkeypatch):
    monkeypatch.setattr('flag_sim.dataset.clip._picture', None)
    row = made(recipe())
    assert row['status'] == 'whole' and row['seen_frames'] == row['frames'] == 4


def test_every_channel_is_described():
    for name, channel in CHANNELS.items():
        assert channel.what and channel.arrays, name
