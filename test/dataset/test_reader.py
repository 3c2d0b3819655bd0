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

"""Reading a dataset, and that it carries what it should."""
import pickle

from flag_sim.dataset import Clips
from flag_sim.dataset.clip import make_clip
from flag_sim.dataset.manifest import rows_of, write
from flag_sim.dataset.recipe import recipe_of
from flag_sim.dataset.store import Store
import numpy as np
import pytest
from support.recipes import text

WINDS = """\
  wind.azimuth: {uniform: [-0.3, 0.3]}
  physics.preroll: 1.0
  physics.start_seed: {uniform: [0, 1000]}
splits: {train: 0.7, test: 0.3}
"""


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a dataset of 70 clips of a second without pictures."""
    store = Store(tmp_path_factory.mktemp('set'))
    recipe = recipe_of(text({'frames: 4': 'frames: 30',
                             '[vertices, wind]': '[vertices, velocities, wind]'}, more=WINDS))
    store.making.mkdir()
    for number in range(70):
        make_clip(recipe, number, store)
    write(store.manifest, rows_of(store, range(70)))
    return store.folder


def test_clips_are_arrays_by_number_and_split(folder):
    clips = Clips(folder)
    assert len(clips) == 70 and clips[-1].number == 69 and [c.number for c in clips[2:4]] == [2, 3]
    clip = clips[5]
    assert set(clip) == {'time', 'vertices', 'velocities', 'wind'} and len(clip) == 4
    assert clip['vertices'].shape == (30, 5, 7, 3) and clip['wind'].shape == (30, 3)
    assert np.allclose(clip['time'], np.arange(30) / 30.0)
    speed = clip.parameters['wind.speed']
    assert np.allclose(np.linalg.norm(clip['wind'], axis=1), speed)
    train, test = Clips(folder, 'train'), Clips(folder, split='test')
    assert len(train) + len(test) == 70 and {clip.split for clip in test} == {'test'}
    with pytest.raises(ValueError, match='one of test, train'):
        Clips(folder, 'dev')
    with pytest.raises(KeyError):
        clip['colour']
    with pytest.raises(IndexError):
        clips[70]


def test_they_go_to_other_processes(folder):
    clips = pickle.loads(pickle.dumps(Clips(folder)))
    assert np.array_equal(clips[3]['vertices'], Clips(folder)[3]['vertices'])


def test_without_a_manifest_it_says_so(tmp_path):
    with pytest.raises(FileNotFoundError, match='no manifest'):
        Clips(tmp_path)


def test_the_wind_can_be_learned(folder):
    """Least squares on 50 clips tells the wind's speed of 20 unseen ones: R2 above 0.8."""
    clips = list(Clips(folder))

    def features(clip):
        velocities, vertices = clip['velocities'], clip['vertices']
        lift = vertices[:, :, -1, 2].mean() - vertices[:, :, 0, 2].mean()
        swing = np.sqrt((velocities**2).mean())
        return [1.0, lift, lift**2, swing, swing**2]
    x = np.array([features(clip) for clip in clips])
    y = np.array([clip.parameters['wind.speed'] for clip in clips])
    weights = np.linalg.lstsq(x[:50], y[:50], rcond=None)[0]
    missed = ((x[50:] @ weights - y[50:])**2).sum() / ((y[50:] - y[:50].mean())**2).sum()
    assert 1.0 - missed > 0.8
