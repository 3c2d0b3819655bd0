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
import json
import pickle

from flag_sim.dataset import Clips
from flag_sim.dataset.clip import make_clip
from flag_sim.dataset.manifest import rows_of, write
from flag_sim.dataset.recipe import recipe_of
from flag_sim.dataset.store import Store
import numpy as np
import pyarrow
import pyarrow.parquet
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
    with pytest.raises(KeyError, match='clip 5 has no array .*colour.*; it has time, vertices'):
        clip['colour']
    with pytest.raises(KeyError, match='no parameter .*wind.sped.*; near it are wind.speed'):
        clip.parameters['wind.sped']
    with pytest.raises(KeyError, match=r"keys of tracks are in clip.row\['wind.keys'\]"):
        clip.parameters['wind.keys']
    assert clip.get('colour') is None and clip.parameters.get('wind.keys') is None
    assert json.loads(json.dumps(clip.parameters)) == clip.parameters
    with pytest.raises(IndexError):
        clips[70]


def test_they_go_to_other_processes(folder):
    clips = pickle.loads(pickle.dumps(Clips(folder)))
    assert np.array_equal(clips[3]['vertices'], Clips(folder)[3]['vertices'])


def test_without_a_manifest_it_says_so(tmp_path):
    with pytest.raises(FileNotFoundError, match='no manifest'):
        Clips(tmp_path)


@pytest.fixture
def small(tmp_path):
    """Return the Store of two clips with a manifest."""
    store = Store(tmp_path / 'small')
    store.making.mkdir(parents=True)
    for number in range(2):
        make_clip(recipe_of(text()), number, store)
    write(store.manifest, rows_of(store, range(2)))
    return store


def spoiled(path):
    path.write_bytes(path.read_bytes()[:-40])


def foreign(path):
    pyarrow.parquet.write_table(pyarrow.table({'number': [1, 2]}), path)


def other(path):
    table = pyarrow.parquet.read_table(path).append_column('mine', pyarrow.array([1, 2]))
    pyarrow.parquet.write_table(table, path)


@pytest.mark.parametrize('name, spoil, words', [
    ('manifest.parquet', spoiled, 'command that made the clips writes it again'),
    ('manifest-000003-of-000100.parquet', spoiled, 'with --shard 3/100 writes it again'),
    ('manifest-000003-of-000100.parquet', foreign, 'no column split'),
    ('manifest-mine.parquet', foreign, 'remove it: no run has written it'),
    ('manifest-mine.parquet', other, 'other columns than'),
])
def test_a_manifest_that_cannot_be_read_is_named(small, name, spoil, words):
    path = small.folder / name
    path.write_bytes(small.manifest.read_bytes())
    spoil(path)
    with pytest.raises(ValueError, match='manifest') as error:
        Clips(small.folder)
    assert str(path) in str(error.value) and words in str(error.value)
    path.unlink()
    assert len(list(small.folder.glob('manifest*.parquet'))) == (name != 'manifest.parquet')


def test_of_two_rows_of_a_clip_the_whole_one_counts(small):
    """A shard's run failed with it once, and another run has made it since."""
    rows = [{**row, 'status': 'failed', 'file': ''} for row in rows_of(small, range(2))]
    write(Store(small.folder, '-000001-of-000002').manifest, rows)
    clips = Clips(small.folder)
    assert len(clips) == 2 and not clips.failed and clips[1]['wind'].shape == (4, 3)


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
