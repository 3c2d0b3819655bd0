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
import zlib

from flag_sim.dataset import deflated as deflate
from flag_sim.dataset.npz import NpzWriter
import numpy as np
import pytest


def unpacked(image):
    """Return what zlib makes of a deflated image."""
    return zlib.decompress(bytes(deflate.deflated(image)) + deflate.END, -15)


@pytest.mark.parametrize('shape, kind', [
    ((48, 64, 3), np.uint8), ((48, 64), np.float32), ((33, 17, 2), np.float32),
    ((33, 17, 3), np.float32), ((33, 17), np.uint8), ((33, 17, 3), np.uint8), ((40, 50), np.bool_),
    ((300, 300, 3), np.float32), ((1, 1), np.uint8), ((2, 200, 4), np.float64)])
def test_an_image_is_deflated_without_loss(shape, kind):
    """Of backgrounds and boxes of noise anywhere; what is nan stays that nan."""
    random = np.random.default_rng(1)
    for case in range(20):
        image = np.zeros(shape, kind)
        image[...] = np.nan if case % 3 == 0 and kind == np.float32 else case % 2
        for _ in range(case % 4):
            top, left = random.integers(0, shape[0]), random.integers(0, shape[1])
            box = image[top:top + random.integers(1, shape[0] + 1),
                        left:left + random.integers(1, shape[1] + 1)]
            box[...] = random.integers(0, 2 if kind == np.bool_ else 255, box.shape)
        assert unpacked(image) == image.tobytes()


def test_background_takes_little():
    image = np.full((480, 640, 3), np.nan, np.float32)
    assert len(deflate.deflated(image)) < image.nbytes / 100
    image[100:200, 100:200] = 1.0
    assert len(deflate.deflated(image)) < 1.1 * 100 * 100 * 12 + image.nbytes / 100


@pytest.mark.parametrize('distance', range(1, 33))
def test_every_run_of_every_pixel_is_read_by_zlib(distance):
    """Each length of a match with its extra bits, at each distance of a pixel."""
    pixel = np.arange(1, distance + 1, dtype=np.uint8)
    for count in (1, 2, 5, 70, 71, 255, 256, 257, 258, 259, 260, 261, 517, 1000):
        image = np.tile(pixel, (1, count)).reshape(1, count, distance)
        assert unpacked(image) == image.tobytes()
    codes, sizes = deflate._match_codes(distance)
    assert len({(int(code), int(size)) for code, size in zip(codes[3:], sizes[3:])}) == 256


def test_numpy_and_zip_read_what_is_written(tmp_path, monkeypatch):
    """Also of arrays that did not stay in memory; the digest is that of the file."""
    monkeypatch.setattr('flag_sim.dataset.npz.IN_MEMORY', 1000)
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
    assert said == {'bytes': len(data), 'sha256': hashlib.sha256(data).hexdigest()}
    with np.load(path) as file:
        assert set(file) == set(frames[0])
        for name in frames[0]:
            stacked = np.stack([frame[name] for frame in frames])
            assert file[name].dtype == stacked.dtype and np.array_equal(file[name], stacked)
    assert zipfile.ZipFile(io.BytesIO(data)).testzip() is None
    assert [item.name for item in tmp_path.iterdir()] == ['a.npz']


def test_frames_of_another_shape_are_refused(tmp_path):
    with NpzWriter(tmp_path / 'a.npz', 2) as writer:
        writer.append({'a': np.zeros((2, 3))})
        with pytest.raises(ValueError, match='among'):
            writer.append({'a': np.zeros((2, 4))})
