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

"""Clips as .npz files: every reader's, the same bytes, and no more than a frame in memory."""
import hashlib
import io
import zipfile

from flag_sim.dataset.npz import NpzWriter
import numpy as np
import pytest


def test_numpy_and_zip_read_what_is_written(tmp_path, monkeypatch):
    """Also of arrays that did not stay in memory; the digest is that of the file."""
    monkeypatch.setattr('flag_sim.dataset.pieces.IN_MEMORY', 1000)
    monkeypatch.setattr('flag_sim.dataset.pieces._idle', [])
    random, path = np.random.default_rng(2), tmp_path / 'a.npz'
    frames = [{'colour': random.integers(0, 255, (32, 24, 3), np.uint8),
               'depth': np.full((32, 24), np.inf, np.float32), 'time': np.float64(k) * np.ones(()),
               'vertices': random.normal(size=(4, 5, 3)).astype(np.float32),
               'is_odd': np.asarray(k % 2 == 1)} for k in range(5)]
    with NpzWriter(path, 5) as writer:
        for frame in frames:
            writer.append(frame)
        said = writer.finish()
    data = path.read_bytes()
    assert said['bytes'] == len(data) < sum(
        np.asarray(part).nbytes for frame in frames for part in frame.values())
    assert said['sha256'] == hashlib.sha256(data).hexdigest()
    with np.load(path) as file:
        assert set(file) == set(frames[0])
        for name in frames[0]:
            stacked = np.stack([frame[name] for frame in frames])
            assert file[name].dtype == stacked.dtype and np.array_equal(file[name], stacked)
    assert zipfile.ZipFile(io.BytesIO(data)).testzip() is None
    assert [item.name for item in tmp_path.iterdir()] == ['a.npz']


def test_content_is_of_the_arrays_however_they_are_compressed(tmp_path, monkeypatch):
    """Other values, names or numbers of frames are other content."""
    def content(name='a', value=1.0, frames=2, level=1):
        monkeypatch.setattr('flag_sim.dataset.npz.LEVEL', level)
        with NpzWriter(tmp_path / 'a.npz', frames) as writer:
            for _ in range(frames):
                writer.append({name: np.full((50, 60), value)})
            return writer.finish()
    one, other = content(), content(level=3)
    assert one['content'] == other['content'] and one['sha256'] != other['sha256']
    assert len({one['content'], content(name='b')['content'], content(value=2.0)['content'],
                content(frames=3)['content']}) == 4


def test_frames_of_another_shape_are_refused(tmp_path):
    with NpzWriter(tmp_path / 'a.npz', 2) as writer:
        writer.append({'a': np.zeros((2, 3))})
        with pytest.raises(ValueError, match='among'):
            writer.append({'a': np.zeros((2, 4))})


def test_writers_at_once_have_memory_of_their_own_and_give_it_back(tmp_path, monkeypatch):
    idle = []
    monkeypatch.setattr('flag_sim.dataset.pieces._idle', idle)
    random = np.random.default_rng(3)
    arrays = [random.normal(size=(3, 40, 50)) for _ in range(2)]
    for _ in range(2):
        with (NpzWriter(tmp_path / '0.npz', 3) as one, NpzWriter(tmp_path / '1.npz', 3) as other):
            for frames in zip(*arrays):
                one.append({'a': frames[0]})
                other.append({'a': frames[1]})
            one.finish()
            other.finish()
        for k, array in enumerate(arrays):
            with np.load(tmp_path / f'{k}.npz') as file:
                assert np.array_equal(file['a'], array)
        assert len(idle) == 2
