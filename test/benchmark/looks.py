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
What looks and channels cost: frames with each of them beside the plain one, on one thread.

1280 x 720, 61 x 41 nodes; all take turns of a few frames, processor time of the thread, medians.
Prints a table and writes out/bench-looks.json.
"""
import argparse
import json
from pathlib import Path
import statistics
import time

from drawing import frames
from flag_sim.drawing import (
    Camera, Dimensions, flag_scene, LastFrame, Light, Materials, Picture, Style, Texture)
from flag_sim.parameters.arguments import given_path
from flag_sim.parameters.config import config_path
import numpy as np
from PIL import Image

CAMERA = Camera(1280, 720)
FLAGS = frames(41, 61)
FIVE = ('depth', 'normals', 'labels', 'texture_coordinates', 'flow')
TURN = 5
"""Frames that are measured in a turn, after one that is not: the others have used the caches."""
ASKED = {'a picture': 1.4, 'shadows': 1.8, 'five channels': 2.5}
"""At most, times the plain frame."""


def with_image(pixels):
    """Return the materials of a flag with a picture (rows, columns, 3)."""
    return Materials(flag_image=Texture(np.asarray(pixels, np.uint8)))


def photo():
    """Return a picture (512, 768, 3) that has one colour nowhere."""
    waves = np.sin(np.mgrid[:512, :768].sum(axis=0)[..., None] / np.array([9.0, 13.0, 17.0]))
    return 127.0 + 100.0 * waves + np.random.default_rng(3).integers(0, 20, (512, 768, 3))


def cases():
    """Return {what a frame has: its materials, style, dimensions and channels}."""
    plain = Materials(), Style(), Dimensions(), ()
    flag = with_image(Image.open(config_path('cross.png')).convert('RGB'))
    ground, shadows = Dimensions(ground_visible=True), Style(shadows=True)
    return {
        'plain': plain, 'a picture': (flag, *plain[1:]),
        'a photo': (with_image(photo()), *plain[1:]),
        'shadows': (plain[0], shadows, *plain[2:]), 'both': (flag, shadows, *plain[2:]),
        'ground': (*plain[:2], ground, ()),
        'sky': (plain[0], Style(sky_gradient=True), *plain[2:]),
        'all looks': (flag, Style(shadows=True, sky_gradient=True), ground, ()),
        **{name: (*plain[:3], (name,)) for name in FIVE}, 'five channels': (*plain[:3], FIVE)}


def drawer(materials, style, dimensions, channels):
    """Return draw(n), which draws frame n of a flag in the wind."""
    picture = Picture(1)

    def draw(n):
        positions, normals = FLAGS[n % len(FLAGS)]
        before = LastFrame(FLAGS[(n - 1) % len(FLAGS)][0], CAMERA, dimensions)
        objects = flag_scene(positions, normals, CAMERA, materials, dimensions, before)
        picture.draw_scene(objects, CAMERA, Light(), style, channels, CAMERA)
    return draw


def measured(rounds):
    """Return {what a frame has: milliseconds of processor time}."""
    drawers = {name: drawer(*case) for name, case in cases().items()}
    times = {name: [] for name in drawers}
    for turn in range(rounds + 1):
        for name, draw in drawers.items():
            for n in range(TURN + 1):
                begin = time.thread_time()
                draw(n)
                if turn and n:  # the first turn compiles
                    times[name].append(1e3 * (time.thread_time() - begin))
    return {name: statistics.median(some) for name, some in times.items()}


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--rounds', type=int, default=40)
    parser.add_argument('--out', type=given_path, default=Path('out/bench-looks.json'))
    options = parser.parse_args()
    times = measured(options.rounds)
    print('Frames of 1280 x 720 with 61 x 41 nodes, one thread, medians')
    for name, spent in times.items():
        ratio = spent / times['plain']
        verdict = '' if name not in ASKED else (
            f'  asked at most {ASKED[name]} {"reached" if ratio <= ASKED[name] else "MISSED"}')
        print(f'{name:22}{spent:8.2f} ms{ratio:7.2f} times the plain one{verdict}')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(times, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
