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

"""The film of a shot: colours that are near, and times that can be read."""
import av
from flag_sim.drawing import Camera, Light, Picture, Style
from flag_sim.tools.film import write_animation, write_contact_sheet, write_movie
import numpy as np
from PIL import Image, ImageSequence
import pytest
from support.flags import wave

NIGHT, DAY = (25.0, 30.0, 60.0), (180.0, 240.0, 240.0)


@pytest.fixture(scope='module')
def sunrise():
    """Return [(stamp [s], rgb)]: a waving flag, while night becomes day."""
    picture, frames = Picture(), []
    for number, part in enumerate(np.linspace(0.0, 1.0, 12)):
        sky = tuple((1.0 - part) * np.array(NIGHT) + part * np.array(DAY))
        frame = picture.draw(wave(phase=number), None, Camera(400, 300),
                             Light(intensity=part, ambient=0.1 + 0.25 * part),
                             style=Style(sky, samples=4))
        frames.append((number / 30.0, frame.colour.copy()))
    return frames


def test_an_animation_shows_the_colours_of_every_frame(sunrise, tmp_path):
    """The sky is exact in each, and nothing is far off; it lasts as long as the shot."""
    path = tmp_path / 'a.gif'
    write_animation(sunrise, path)
    with Image.open(path) as animation:
        shown = [(image.info['duration'], np.asarray(image.convert('RGB')).astype(int))
                 for image in ImageSequence.Iterator(animation)]
    kept = sunrise[::2]
    assert len(shown) == len(kept)
    for (_, rgb), (_, image) in zip(kept, shown):
        error = np.abs(image - rgb)
        assert np.all(error[5, 5] == 0)
        assert error.max() <= 16 and error.mean() < 0.5
    assert sum(duration for duration, _ in shown) == 400


@pytest.mark.parametrize('rate', [30.0, 59.94])
def test_a_movie_has_every_frame_at_its_time_and_size(sunrise, tmp_path, rate):
    """Its colours are near, and odd sides grow by a pixel."""
    frames = [(7.0 + number / rate, rgb[:299, :399]) for number, (_, rgb) in enumerate(sunrise)]
    write_movie(frames, tmp_path / 'a.mp4')
    with av.open(str(tmp_path / 'a.mp4')) as movie:
        shown = [(float(picture.pts * picture.time_base), picture.to_ndarray(format='rgb24'))
                 for picture in movie.decode(video=0)]
    assert [time for time, _ in shown] == pytest.approx(
        [number / rate for number in range(len(frames))], abs=1e-4)
    for (_, rgb), (_, picture) in zip(frames, shown):
        assert picture.shape == (300, 400, 3)
        assert np.abs(picture[:299, :399].astype(int) - rgb).mean() < 3.0


@pytest.mark.parametrize('sky', [(0, 0, 0), (255, 255, 255), (128, 128, 128), (25, 30, 60),
                                 (180, 240, 240)], ids=str)
def test_a_time_can_be_read_on_any_sky(sky, tmp_path):
    """Its figures are white, and black is around them."""
    frame = np.full((240, 320, 3), sky, np.uint8)
    write_contact_sheet([(0.0, frame), (1.0, frame)], tmp_path / 'a.png')
    with Image.open(tmp_path / 'a.png') as sheet:
        label = np.asarray(sheet.convert('L')).astype(int)[:24, :80]
    assert np.sum(label > 240) > 20 and np.sum(label < 15) > 20
    # Wherever a figure stands, black is next to it.
    rows, columns = np.nonzero(label[1:-1, 1:-1] > 240) if sky != (255, 255, 255) else ((), ())
    for row, column in zip(rows, columns):
        assert label[row:row + 3, column:column + 3].min() < 128
