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

"""
From a bag to pictures: a movie, an animated GIF and a contact sheet.

All take the frames one by one, as images_of yields them: a shot of 1280 x 720 pixels in memory
would be 166 MB for each second.
"""
from collections.abc import Iterable, Iterator
import fractions
import itertools
import math
from pathlib import Path

from flag_sim.tools.small import small
import numpy as np
from PIL import Image, ImageDraw
from rosbags.highlevel import AnyReader

IMAGES = '/camera/image_raw'
SHEET_COLUMNS, SHEET_ROWS = 4, 3
GIF_WIDTH = 480  # pixels
GIF_STEP = 2  # every second frame: viewers show no more than 50 images a second
GIF_SHORTEST = 2  # hundredths of a second that an image stands: viewers take 1 and 0 for 10
GIF_LONGEST = 0xFFFF  # hundredths of a second: as many as its file can say
MOVIE_CLOCK = 90_000  # ticks a second, of which all usual rates are parts
MOVIE_LOSS = '18'  # x264's constant rate factor: hardly to be told from the picture
BT709 = 1  # matrix, primaries and transfer of ITU-R BT.709, as H.273 numbers them
STUDIO_RANGE = 1  # luma from 16 to 235, in FFmpeg's numbers
GIF_COLORS = 256  # of each image: as many as a GIF can have


def images_of(bag: str | Path, topic: str = IMAGES) -> Iterator[tuple[float, np.ndarray]]:
    """Yield (stamp [s], (height, width, 3) uint8) for every rgb8 image of a bag, in order."""
    with AnyReader([Path(bag)]) as reader:
        connections = [c for c in reader.connections if c.topic == topic]
        for connection, _, data in reader.messages(connections):
            message = reader.deserialize(data, connection.msgtype)
            stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
            yield stamp, np.asarray(message.data).reshape(message.height, message.width, 3)


def count_images(bag: str | Path, topic: str = IMAGES) -> int:
    """Return how many messages of a topic a bag holds."""
    with AnyReader([Path(bag)]) as reader:
        return sum(c.msgcount for c in reader.connections if c.topic == topic)


def _thinned(frames):
    """Yield every second of frames (stamp [s], rgb), but none too soon after another."""
    last = -math.inf
    for stamp, rgb in itertools.islice(frames, 0, None, GIF_STEP):
        moment = round(100 * stamp)
        if moment - last >= GIF_SHORTEST:
            last = moment
            yield stamp, rgb


def quantized(image: Image.Image) -> Image.Image:
    """
    Return an RGB image with a palette of its own, of GIF_COLORS.

    Maximum coverage keeps the farthest colour near, where median cut gives most of the palette to
    what is frequent and is up to 80 levels off elsewhere. Each entry then becomes the mean of its
    pixels, so a large area of one colour, such as the sky, keeps just that one.
    """
    chosen = image.quantize(GIF_COLORS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    entries = np.asarray(chosen).ravel()
    count = np.maximum(np.bincount(entries, minlength=256), 1)
    sums = [np.bincount(entries, channel.ravel(), 256)
            for channel in np.moveaxis(np.asarray(image), 2, 0)]
    chosen.putpalette(np.rint(np.stack(sums, axis=1) / count[:, None]).astype(np.uint8).tobytes())
    return chosen


def write_animation(frames: Iterable[tuple[float, np.ndarray]], path: str | Path) -> int:
    """
    Write a GIF that plays `frames` (stamp [s], rgb) at their own speed, again and again.

    It has every second frame, 50 a second at most, made small to GIF_WIDTH; each stands for
    GIF_LONGEST at most. Return how many frames it has.
    """
    kept = [(stamp, quantized(small(rgb, GIF_WIDTH))) for stamp, rgb in _thinned(frames)]
    stamps = [stamp for stamp, _ in kept]
    stamps.append(2 * stamps[-1] - stamps[-2] if len(kept) > 1 else stamps[-1] + 1.0)
    # A GIF counts in hundredths: round the moments, not the durations, and no time is lost.
    moments = [round(100 * stamp) for stamp in stamps]
    durations = [10 * min(after - before, GIF_LONGEST)
                 for before, after in zip(moments, moments[1:])]
    kept[0][1].save(path, save_all=True, append_images=[image for _, image in kept[1:]],
                    duration=durations, loop=0, optimize=False)
    return len(kept)


def write_movie(frames: Iterable[tuple[float, np.ndarray]], path: str | Path) -> None:
    """
    Write an MP4 (H.264) of `frames` (stamp [s], rgb), each at its own time and size.

    Its colours are at half the size and need even sides: an odd one is continued by a pixel. The
    rate that it names is that of the first two frames. Raises ImportError where PyAV is not
    installed.
    """
    import av
    frames = iter(frames)
    first = list(itertools.islice(frames, 2))
    height, width = first[0][1].shape[:2]
    rate = _rate(*(stamp for stamp, _ in first))
    # What tells a player where all is stands before the pictures: it begins while it loads.
    with av.open(str(path), 'w', options={'movflags': 'faststart'}) as movie:
        stream = movie.add_stream('libx264', rate=rate, options={'crf': MOVIE_LOSS})
        stream.width, stream.height = width + width % 2, height + height % 2
        stream.pix_fmt = 'yuv420p'  # what every player shows
        codec = stream.codec_context
        codec.time_base = fractions.Fraction(1, MOVIE_CLOCK)
        # Unless it is told, a player guesses the matrix, by the size, and shows other colours.
        codec.colorspace = codec.color_primaries = codec.color_trc = BT709
        codec.color_range = STUDIO_RANGE
        for stamp, rgb in itertools.chain(first, frames):
            whole = np.pad(rgb, ((0, height % 2), (0, width % 2), (0, 0)), 'edge')
            picture = av.VideoFrame.from_ndarray(whole, format='rgb24').reformat(
                format=stream.pix_fmt, dst_colorspace='ITU709')
            picture.pts = round((stamp - first[0][0]) * MOVIE_CLOCK)
            picture.time_base = codec.time_base
            movie.mux(stream.encode(picture))
        movie.mux(stream.encode(None))


def _rate(first, second=None):
    """Return how many frames are in a second, where two follow each other at these stamps [s]."""
    if second is None:
        return fractions.Fraction(1)
    return fractions.Fraction(1.0 / (second - first)).limit_denominator(1001)  # as 60000 / 1001


def write_contact_sheet(frames: Iterable[tuple[float, np.ndarray]], count: int, path: str | Path,
                        width: int = 320) -> None:
    """Write a PNG of images evenly spread over `count` frames (stamp [s], rgb), with times."""
    shown = min(SHEET_COLUMNS * SHEET_ROWS, count)
    chosen = {round(i) for i in np.linspace(0, count - 1, shown)}
    images = [(stamp, small(rgb, width))
              for index, (stamp, rgb) in enumerate(frames) if index in chosen]
    rows = -(-shown // SHEET_COLUMNS)
    height = max(image.height for _, image in images)
    sheet = Image.new('RGB', (SHEET_COLUMNS * width, rows * height), 'white')
    for i, (stamp, image) in enumerate(images):
        # White in a black outline can be read on any background.
        ImageDraw.Draw(image).text((6, 4), f't = {stamp:.2f} s', fill='white', font_size=13,
                                   stroke_width=1, stroke_fill='black')
        sheet.paste(image, (i % SHEET_COLUMNS * width, i // SHEET_COLUMNS * height))
    sheet.save(path, optimize=True)
