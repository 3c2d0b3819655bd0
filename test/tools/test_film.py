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
import weakref

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
        frame = picture.draw(wave(phase=number), None, Camera(480, 360),
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


@pytest.mark.parametrize('size', [(600, 2), (2000, 1), (1, 2000), (360, 480)])
def test_pictures_of_any_proportions_have_a_bounded_size(tmp_path, size):
    """A slim one was enlarged to the whole width, and so to more lines than a GIF can have."""
    frames = [(number / 30.0, np.full((*size, 3), 50 * number, np.uint8)) for number in range(4)]
    assert write_animation(frames, tmp_path / 'a.gif') == 2
    write_contact_sheet(frames, 4, tmp_path / 'a.png')
    for name, width, cells in (('a.gif', 480, 1), ('a.png', 320, 4)):
        with Image.open(tmp_path / name) as image:
            assert image.width <= cells * width and image.height <= 2 * width
            assert image.width == cells * width or image.height == 2 * width


@pytest.mark.parametrize('rate, kept, milliseconds', [
    (1000.0, 11, 220), (100.0, 100, 2000), (60.0, 100, 3330), (1e-3, 100, 65_535_000)])
def test_an_animation_lasts_at_any_rate(tmp_path, rate, kept, milliseconds):
    """No image stands for less than viewers can show, nor for longer than its file can say."""
    frames = ((n / rate, np.full((2, 2, 3), n, np.uint8)) for n in range(200))
    assert write_animation(frames, tmp_path / 'a.gif') == kept
    with Image.open(tmp_path / 'a.gif') as animation:
        durations = [image.info['duration'] for image in ImageSequence.Iterator(animation)]
    assert len(durations) == kept and sum(durations) == milliseconds and min(durations) >= 20


@pytest.mark.parametrize('rate', [30.0, 59.94])
def test_a_movie_has_every_frame_at_its_time_and_size(sunrise, tmp_path, rate):
    """Its colours are near, and odd sides grow by a pixel."""
    frames = [(7.0 + number / rate, rgb[:359, :479]) for number, (_, rgb) in enumerate(sunrise)]
    write_movie(frames, tmp_path / 'a.mp4')
    with av.open(str(tmp_path / 'a.mp4')) as movie:
        assert float(movie.streams.video[0].average_rate) == pytest.approx(rate, rel=1e-4)
        shown = [(float(picture.pts * picture.time_base), picture.to_ndarray(format='rgb24'))
                 for picture in movie.decode(video=0)]
    assert [time for time, _ in shown] == pytest.approx(
        [number / rate for number in range(len(frames))], abs=1e-4)
    for (_, rgb), (_, picture) in zip(frames, shown):
        assert picture.shape == (360, 480, 3)
        assert np.abs(picture[:359, :479].astype(int) - rgb).mean() < 3.0


def test_a_movie_says_how_its_colours_are_coded(tmp_path):
    """By BT.709 as its tags say, for a player that is told nothing guesses; worked out by hand."""
    rgb = np.full((64, 64, 3), (70, 40, 120), np.uint8)
    write_movie([(0.0, rgb)], tmp_path / 'a.mp4')
    with av.open(str(tmp_path / 'a.mp4')) as movie:
        codec = movie.streams.video[0].codec_context
        tags = codec.colorspace, codec.color_primaries, codec.color_trc, codec.color_range
        planes = next(movie.decode(video=0)).to_ndarray(format='yuv420p')
    assert tags == (1, 1, 1, 1)
    luma = rgb[0, 0] @ [0.2126, 0.7152, 0.0722]
    blue, red = (120.0 - luma) / 1.8556, (70.0 - luma) / 1.5748
    expected = 16.0 + 219.0 * luma / 255.0, *(128.0 + 224.0 * one / 255.0 for one in (blue, red))
    assert planes[[30, 70, 90], 30] == pytest.approx(expected, abs=1.0)


def test_a_movie_can_be_watched_while_it_loads(sunrise, tmp_path):
    """Its table of contents stands before its pictures."""
    write_movie(sunrise, tmp_path / 'a.mp4')
    content = (tmp_path / 'a.mp4').read_bytes()
    assert 0 < content.index(b'moov') < content.index(b'mdat')


@pytest.mark.parametrize('write', [
    write_movie, write_animation,
    lambda frames, path: write_contact_sheet(frames, 40, path)], ids=['mp4', 'gif', 'png'])
def test_a_film_is_never_in_memory_as_a_whole(tmp_path, write, request):
    """However long it is: of the frames that were handed over, few are still held."""
    alive, most = weakref.WeakSet(), [0]

    class Picture(np.ndarray):
        """An array that can be told from its equals."""

        __hash__ = object.__hash__

    def frames():
        for number in range(40):
            rgb = np.full((36, 48, 3), number, np.uint8).view(Picture)
            alive.add(rgb)
            most[0] = max(most[0], len(alive))
            yield number / 60.0, rgb
    write(frames(), tmp_path / f'a.{request.node.callspec.id}')
    assert most[0] <= 4


@pytest.mark.parametrize('sky', [(0, 0, 0), (255, 255, 255), (128, 128, 128), (25, 30, 60),
                                 (180, 240, 240)], ids=str)
def test_a_time_can_be_read_on_any_sky(sky, tmp_path):
    """Its figures are white, and black is around them."""
    frame = np.full((240, 320, 3), sky, np.uint8)
    write_contact_sheet([(0.0, frame), (1.0, frame)], 2, tmp_path / 'a.png')
    with Image.open(tmp_path / 'a.png') as sheet:
        label = np.asarray(sheet.convert('L')).astype(int)[:24, :80]
    assert np.sum(label > 240) > 20 and np.sum(label < 15) > 20
    # Wherever a figure stands, black is next to it.
    rows, columns = np.nonzero(label[1:-1, 1:-1] > 240) if sky != (255, 255, 255) else ((), ())
    for row, column in zip(rows, columns):
        assert label[row:row + 3, column:column + 3].min() < 128
