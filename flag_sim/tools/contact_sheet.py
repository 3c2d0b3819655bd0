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
A sheet of random clips of a dataset: `python3 -m flag_sim.tools.contact_sheet DIR FILE`.

One frame of each clip; below, each channel of one of them, and how parameters are spread.
"""
import argparse
from collections.abc import Sequence
import random
import sys

from flag_sim.dataset import Clip, Clips
from flag_sim.parameters.arguments import given_path
from flag_sim.tools.channels import (
    coordinate_colours, depth_colours, flow_colours, LABEL_COLOURS, normal_colours)
from flag_sim.tools.small import small
import numpy as np
from PIL import Image, ImageDraw

COLUMNS = 6
SHOWN = 24
WIDTH = 192  # of a picture [pixels]
BAR, TEXT = (60, 110, 170), (20, 20, 20)
BINS = 24
LEAST_HEIGHT = 96  # of a histogram, however low the pictures are [pixels]
MOST_SPREAD = 12
"""How many parameters are shown."""
COLOURS = {
    'colour': lambda image: image, 'depth': depth_colours, 'normals': normal_colours,
    'labels': lambda image: LABEL_COLOURS[image], 'texture_coordinates': coordinate_colours,
    'backward_flow': flow_colours, 'forward_flow': flow_colours,
    'backward_occlusion': lambda image: _masked(image), 'forward_occlusion': lambda image:
    _masked(image)}
"""How an image of each channel is turned into colours."""


def _masked(image):
    """Return a mask as black on white."""
    return np.repeat(np.uint8(255 * ~image)[..., None], 3, axis=2)


def picture(clip: Clip, name: str, frame: int) -> Image.Image:
    """Return a frame of a clip's images in colours."""
    return small(COLOURS[name](clip[name][frame]), WIDTH)


def histogram(name: str, values: Sequence[float], height: int) -> Image.Image:
    """Return how values of a parameter are spread."""
    image = Image.new('RGB', (WIDTH, height), 'white')
    draw = ImageDraw.Draw(image)
    counts, edges = np.histogram(values, BINS)
    step, room = (WIDTH - 12) / BINS, height - 44
    for k, count in enumerate(counts):
        top = height - 20 - room * count / max(counts.max(), 1)
        draw.rectangle((6 + k * step, top, 5 + (k + 1) * step, height - 20), fill=BAR)
    draw.text((6, 4), name, fill=TEXT, font_size=12)
    draw.text((6, height - 16), f'{edges[0]:.3g}', fill=TEXT, font_size=11)
    draw.text((WIDTH - 6, height - 16), f'{edges[-1]:.3g}', fill=TEXT, font_size=11, anchor='ra')
    return image


def spread_of(clips: Clips) -> dict[str, list]:
    """Return {parameter: its values} of the numbers that differ from clip to clip."""
    found = {}
    for name in clips.table.column_names:
        values = clips.table.column(name).to_pylist()
        is_number = name.startswith(('wind.', 'physics.', 'renderer.')) and all(
            type(value) in (int, float) for value in values)
        if is_number and len(set(values)) > 2 and not name.endswith('seed'):
            found[name] = values
    return dict(list(found.items())[:MOST_SPREAD])


def sheet(clips: Clips, seed: int = 1) -> Image.Image:
    """Return the sheet of a dataset; raise ValueError for one without pictures."""
    chosen = sorted(random.Random(seed).sample(range(len(clips)), min(SHOWN, len(clips))))
    if not chosen or 'colour' not in clips[chosen[0]]:
        raise ValueError('a sheet needs clips with the channel colour')
    parts = []
    for number in chosen:
        middle = len(clips[number]['time']) // 2
        parts.append(_labelled(picture(clips[number], 'colour', middle),
                               f'clip {clips[number].number}'))
    first, middle = _largest(clips, chosen)
    rows = [parts, [_labelled(picture(first, name, middle), name) for name in COLOURS
                    if name in first and name != 'colour'],
            [histogram(name, values, max(parts[0].height, LEAST_HEIGHT))
             for name, values in spread_of(clips).items()]]
    return _tiled(rows)


def _largest(clips, chosen):
    """Return the clip whose flag is largest, with its frame in the middle."""
    def size(number):
        clip = clips[number]
        middle = len(clip['time']) // 2
        return np.count_nonzero(clip['labels'][middle] == 1) if 'labels' in clip else 0
    clip = clips[max(chosen, key=size)]
    return clip, len(clip['time']) // 2


def _labelled(image, text):
    ImageDraw.Draw(image).text((5, 4), text, fill='white', font_size=13, stroke_width=2,
                               stroke_fill='black')
    return image


def _tiled(groups):
    """Return pictures side by side, each group from a new row on."""
    height = max(part.height for group in groups for part in group)
    rows = [group[k:k + COLUMNS] for group in groups for k in range(0, len(group), COLUMNS)]
    image = Image.new('RGB', (COLUMNS * WIDTH, len(rows) * height), 'white')
    for row, parts in enumerate(rows):
        for column, part in enumerate(parts):
            image.paste(part, (column * WIDTH, row * height))
    return image


def main(args: Sequence[str] | None = None) -> int:
    """Write the sheet of a dataset; return the exit status."""
    parser = argparse.ArgumentParser(prog='contact_sheet', description=__doc__)
    parser.add_argument('dataset', type=given_path, help='the folder of a dataset')
    parser.add_argument('file', type=given_path, help='a PNG to be written')
    options = parser.parse_args(args)
    if options.file.suffix != '.png' or not options.file.absolute().parent.is_dir():
        parser.error(f'{options.file} must end in .png and be in a folder that exists')
    try:
        sheet(Clips(options.dataset)).save(options.file, optimize=True)
    except (OSError, ValueError, ImportError) as error:
        print(f'contact_sheet: {error}', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
