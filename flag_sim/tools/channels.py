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
A sheet of all that the camera knows of one frame: `python3 -m flag_sim.tools.channels FILE`.

Also an example of how each channel is turned into colours that people can look at.
"""
import argparse
from collections.abc import Sequence
import colorsys
import sys

from flag_sim.cloth import Cloth
from flag_sim.drawing import Camera, flag_scene, Frame, LastFrame, Picture, Style
from flag_sim.parameters.arguments import given_path
import numpy as np
from PIL import Image, ImageDraw

CAMERA = Camera(640, 400, target=(1.0, 0.0, 8.0), distance=5.0, azimuth=-1.3)
RATE = 30.0  # frames a second
FRAMES = 100
WHITE = 255
LABEL_COLOURS = np.array([[255, 255, 255], [205, 35, 40], [60, 60, 70], [150, 145, 135]], np.uint8)
SHEET_COLUMNS = 3


def blowing() -> Frame:
    """Return a frame of a flag in the wind, with all channels."""
    cloth, picture, last = Cloth(pole=(0.0, 0.0, 0.05)), Picture(), None
    for _ in range(FRAMES):
        last = LastFrame(cloth.positions.copy(), CAMERA)
        cloth.advance(1.0 / RATE, wind=(8.0, 3.0, 0.0))
    objects = flag_scene(cloth.positions, cloth.normals(), CAMERA, last=last)
    return picture.draw_scene(
        objects, CAMERA, style=Style(samples=8),
        channels=['depth', 'normals', 'labels', 'texture_coordinates', 'flow'],
        camera_before=last.camera)


def depth_colours(depth: np.ndarray) -> np.ndarray:
    """Return nearer as darker, and nothing as white: (height, width, 3) uint8."""
    seen = np.isfinite(depth)
    near, far = depth[seen].min(), depth[seen].max()
    level = 40.0 + 170.0 * (np.where(seen, depth, far) - near) / (far - near)
    return np.repeat(np.uint8(np.where(seen, level, WHITE))[..., None], 3, axis=2)


def normal_colours(normals: np.ndarray) -> np.ndarray:
    """Return x, y and z from -1 to 1 as red, green and blue from 0 to 255."""
    seen = np.any(normals != 0.0, axis=2, keepdims=True)
    # Towards the camera is -z, which most people know as light blue.
    shown = 127.5 * (1.0 + normals * [1.0, -1.0, -1.0])
    return np.uint8(np.where(seen, shown, WHITE))


def coordinate_colours(coordinates: np.ndarray) -> np.ndarray:
    """Return u as red and v as green, with a line at each tenth."""
    seen = np.isfinite(coordinates).all(axis=2, keepdims=True)
    known = np.where(seen, coordinates, 0.0)
    shown = np.concatenate([255.0 * known, np.full(seen.shape, 90.0)], axis=2)
    line = (np.abs(10.0 * known - np.rint(10.0 * known)) < 0.06).any(axis=2, keepdims=True)
    return np.uint8(np.where(seen, np.where(line, 0.5 * shown, shown), WHITE))


def flow_colours(flow: np.ndarray) -> np.ndarray:
    """Return the direction as hue and the length as strength, as Baker et al. (2011) do."""
    seen = np.isfinite(flow).all(axis=2)
    length = np.where(seen, np.hypot(*np.moveaxis(flow, 2, 0)), 0.0)
    wheel = np.array([colorsys.hsv_to_rgb(hue / 256, 1.0, 1.0) for hue in range(256)])
    turn = np.arctan2(flow[..., 1], flow[..., 0]) / (2.0 * np.pi) % 1.0
    hue = wheel[np.int64(np.where(seen, turn, 0.0) * 255.0)]
    strength = np.minimum(length / max(np.quantile(length[seen], 0.98), 1e-6), 1.0)[..., None]
    return np.uint8(np.where(seen[..., None], 255.0 * (1.0 - strength * (1.0 - hue)), WHITE))


def sheet(frame: Frame) -> Image.Image:
    """Return a picture of the channels of a frame, side by side."""
    parts = {
        'image_raw': frame.colour, 'depth (dark is near)': depth_colours(frame.depth),
        'normals': normal_colours(frame.normals), 'labels': LABEL_COLOURS[frame.labels],
        'texture_coordinates': coordinate_colours(frame.texture_coordinates),
        'flow (hue: direction)': flow_colours(frame.flow)}
    height, width = frame.labels.shape
    rows = -(-len(parts) // SHEET_COLUMNS)
    image = Image.new('RGB', (SHEET_COLUMNS * width, rows * height), 'white')
    for k, (name, rgb) in enumerate(parts.items()):
        part = Image.fromarray(rgb)
        ImageDraw.Draw(part).text((10, 8), name, fill='white', font_size=26, stroke_width=2,
                                  stroke_fill='black')
        image.paste(part, (k % SHEET_COLUMNS * width, k // SHEET_COLUMNS * height))
    return image.resize((image.width // 2, image.height // 2), Image.Resampling.LANCZOS)


def main(args: Sequence[str] | None = None) -> int:
    """Write the sheet into the file that is named; return the exit status."""
    parser = argparse.ArgumentParser(prog='channels', description=__doc__)
    parser.add_argument('file', type=given_path, help='a PNG to be written')
    file = parser.parse_args(args).file
    if file.suffix != '.png' or not file.absolute().parent.is_dir():
        parser.error(f'{file} must end in .png and be in a folder that exists')
    sheet(blowing()).save(file, optimize=True)
    return 0


if __name__ == '__main__':
    sys.exit(main())
