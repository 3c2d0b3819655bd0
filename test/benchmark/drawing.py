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
How fast a frame is drawn, beside other programs that draw the same one.

Whole frames of 1280 x 720 on one processor, from new vertices to the RGB bytes in hand; the
programs take turns, and medians count. Prints a table and writes out/bench-drawing.json.
"""
import argparse
import json
import os
from pathlib import Path
import platform
import statistics
import time

os.environ['LP_NUM_THREADS'] = '0'  # llvmpipe draws in the calling thread; read at its start

from flag_sim.drawing import Camera, Light, Picture, Style  # noqa: E402
from flag_sim.drawing.bands import BAND, clear, new_buffers, RenderSettings  # noqa: E402
from flag_sim.drawing.framebuffer import Framebuffer, write_rgb  # noqa: E402
from flag_sim.drawing.pixels import Region  # noqa: E402
from flag_sim.drawing.rasterizer import RasterizerState, Target  # noqa: E402
from flag_sim.drawing.scanline import draw_span  # noqa: E402
from flag_sim.parameters.arguments import given_path  # noqa: E402

import numpy as np  # noqa: E402

from peers_drawing import assemble, PEERS, Shot  # noqa: E402

CAMERA = Camera(1280, 720)
CASES = {'61x41': (41, 61), '241x161': (161, 241)}
# The source's own measurement (sec. 4.1): ticks by number of threads, on an Intel Core i5.
# What is asked of each case: how many times faster than the peer.
TARGETS = {
    '61x41': {'llvmpipe': 2.5, 'Panda3D tinydisplay': 1.4, 'C++ -O3': 3.5,
              'OpenCV triangleRasterize': 8.0},
    '241x161': {'llvmpipe': 3.5, 'Panda3D tinydisplay': 1.6, 'C++ -O3': 1.6,
                'OpenCV triangleRasterize': 3.0}}
MOST_FOR_4_SAMPLES = 5.0  # times the cost of one
LEAST_FOR_2_THREADS = 1.8  # times faster than one
# The source's table 4.1.
SOURCE_TICKS = {1: 43_127_480, 2: 35_178_242, 3: 28_537_882, 4: 24_954_742, 5: 20_954_733}


def frames(rows, columns, count=8):
    """Make flags in the wind with their normals: list of pairs (rows, columns, 3)."""
    s, z = np.meshgrid(np.linspace(0.0, 2.25, columns), np.linspace(9.0, 7.5, rows))
    made = []
    for phase in np.linspace(0.0, 2.0 * np.pi, count, endpoint=False):
        y = 0.3 * s + 0.15 * s * np.sin(5.0 * s + z - phase)
        flag = np.stack([0.05 + s, y, z - 0.1 * s], axis=-1)
        made.append((flag, np.cross(np.gradient(flag, axis=1), np.gradient(flag, axis=0))))
    return made


def take_turns(contenders, flags, rounds):
    """Let every contender draw every flag in turn; return the median of each [ms]."""
    times = {name: [] for name in contenders}
    for number in range(rounds + 2):
        flag = flags[number % len(flags)]
        for name, draw in contenders.items():
            begin = time.perf_counter()
            draw(*flag)
            if number >= 2:  # the first ones compile and allocate
                times[name].append(1e3 * (time.perf_counter() - begin))
    return {name: statistics.median(some) for name, some in times.items()}


def ours(threads=1, **style):
    """Return a draw() of this package's own."""
    picture, style = Picture(threads), Style(**style)
    return lambda points, normals: picture.draw(points, normals, CAMERA, style=style)


class Staged(Picture):
    """A picture that notes how long drawing takes [ms], once vertices and order are known."""

    def __init__(self, threads):
        super().__init__(threads)
        self.drawing = []

    def _rasterize(self, *frame):
        begin = time.perf_counter()
        super()._rasterize(*frame)
        self.drawing.append(1e3 * (time.perf_counter() - begin))


def by_threads(flags, rounds):
    """
    Return the medians of a whole frame and of its stage of drawing [ms], by number of threads.

    Numbers take turns after 20 frames each: a film is drawn by the same threads all along.
    """
    pictures = {count: Staged(count) for count in (*SOURCE_TICKS, 0)}
    frames = {count: [] for count in pictures}
    stages = {count: [] for count in pictures}
    for turn in range(max(rounds // 20, 1) + 1):
        for count, picture in pictures.items():
            picture.drawing.clear()
            for number in range(20):
                begin = time.perf_counter()
                picture.draw(*flags[number % len(flags)], CAMERA)
                if turn > 0 and number >= 2:  # the first turn compiles and chooses
                    frames[count].append(1e3 * (time.perf_counter() - begin))
                    stages[count].append(picture.drawing[-1])
    return {count: (statistics.median(frames[count]), statistics.median(stages[count]))
            for count in pictures}


def floor(flag, normals):
    """Return a draw() that only clears, writes as many pixels in one span, and converts."""
    drawn = np.isfinite(Picture().draw(flag, normals, CAMERA, channels=['depth']).depth)
    columns = drawn.any(axis=0)
    first, last = int(np.argmax(columns)), CAMERA.width - int(np.argmax(columns[::-1]))
    images = Framebuffer(CAMERA.width, CAMERA.height, 1, 0).images([])
    buffers = new_buffers(CAMERA.width, 0, False, 0)
    state = RasterizerState(np.int32(0), np.int32(0), np.float32(np.inf), False, False)
    settings = RenderSettings(state, np.zeros((1, 2), np.int32), np.uint32(0), np.float32(0.0),
                              CAMERA.width, CAMERA.height, False)
    target = Target(buffers.colour, buffers.depth, buffers.primitive_ids, buffers.primitives, 0,
                    BAND, CAMERA.width, buffers.stride)
    # Reversed Z, red, green, blue: at the first pixel, a column on, a row on, least and most.
    planes = np.array([[0.1, 1e-9, 0.0, 0.0, 1.0], [200.0, 1e-6, 0.0, 0.0, 255.0],
                       [40.0, 1e-6, 0.0, 0.0, 255.0], [40.0, 1e-6, 0.0, 0.0, 255.0]])
    bands = [(top, np.uint64(drawn[top:top + BAND].sum()))
             for top in range(0, CAMERA.height, BAND) if drawn[top:top + BAND].any()]

    def draw(points, normals):
        for top, count in bands:
            region = Region(top, 0, min(BAND, CAMERA.height - top), first, last, buffers.stride)
            clear(buffers, settings, region)
            draw_span(np.uint64(0), count, planes, (0.0, 0.0), state, 0, target, None)
            write_rgb(buffers.colour, region, CAMERA.width, images.rgb, images.rgb_words)

    return draw


def against_peers(rounds):
    """Compare on one processor: the rows, what is missing, and further times of our own."""
    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(processors)})
    rows, missing, own = [], {}, {}
    for case, grid in CASES.items():
        flags = frames(*grid)
        scene = assemble(*flags[0], CAMERA)
        contenders = {'ours': ours(), 'ours, 4 samples': ours(samples=4),
                      'ours, 8 samples': ours(samples=8),
                      'ours, painter': ours(hidden_surface='painter'),
                      'floor': floor(*flags[0])}
        for peer in PEERS:
            try:
                contenders[peer.name] = peer(Shot(CAMERA, Light(), *scene)).draw
            except Exception as error:  # whatever hinders a peer is named, not hidden
                missing[peer.name] = f'{type(error).__name__}: {error}'
        times = take_turns(contenders, flags, rounds)
        own[case] = {name: times[name] for name in list(contenders)[:5]}
        rows += [{'peer': peer.name, 'case': case, 'ours_ms': times['ours'],
                  'peer_ms': times[peer.name], 'ratio': times[peer.name] / times['ours']}
                 for peer in PEERS if peer.name in times]
    os.sched_setaffinity(0, processors)
    return rows, missing, own


def verdict(is_reached):
    """Return whether a target is reached."""
    return 'reached' if is_reached else 'MISSED'


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--rounds', type=int, default=60)
    parser.add_argument('--out', type=given_path, default=Path('out/bench-drawing.json'))
    options = parser.parse_args()
    rows, missing, own = against_peers(options.rounds)
    machine = f'{platform.machine()}, {len(os.sched_getaffinity(0))} processors'
    print(f'Whole frames, {CAMERA.width} x {CAMERA.height}, one processor ({machine}), medians')
    print(f'{"case":10}{"peer":26}{"ours ms":>9}{"peer ms":>9}{"ratio":>7}{"asked":>7}')
    for row in rows:
        row['asked'] = TARGETS[row['case']][row['peer']]
        print(f'{row["case"]:10}{row["peer"]:26}{row["ours_ms"]:9.2f}{row["peer_ms"]:9.2f}'
              f'{row["ratio"]:7.2f}{row["asked"]:7.1f} {verdict(row["ratio"] >= row["asked"])}')
    for name, reason in missing.items():
        print(f'not measured: {name} ({reason})')
    for case, times in own.items():
        print(f'{case}: ' + ', '.join(f'{name} {ms:.2f} ms' for name, ms in times.items()))
        cost = times['ours, 4 samples'] / times['ours']
        print(f'{case}: 4 samples cost {cost:.2f} times one, asked at most {MOST_FOR_4_SAMPLES} '
              f'{verdict(cost <= MOST_FOR_4_SAMPLES)}')
        print(f'{case}: a frame is {times["ours"] - times["floor"]:.2f} ms above the floor '
              '(clear, convert, fragments alone)')

    threads = []
    for case, grid in CASES.items():
        times = by_threads(frames(*grid), options.rounds)
        print(f'{"case":10}{"threads":>8}{"source ticks":>14}{"faster":>8}{"frame ms":>10}'
              f'{"faster":>8}{"drawing ms":>12}{"faster":>8}')
        for count, (frame, stage) in times.items():
            ticks = SOURCE_TICKS.get(count)
            source = f'{ticks:14,}{SOURCE_TICKS[1] / ticks:8.2f}' if ticks else f'{"":22}'
            print(f'{case:10}{count or "chosen":>8}{source}{frame:10.2f}'
                  f'{times[1][0] / frame:8.2f}{stage:12.2f}{times[1][1] / stage:8.2f}')
            threads.append({'case': case, 'threads': count, 'source_ticks': ticks,
                            'ours_ms': frame, 'drawing_ms': stage})
        gain = times[1][1] / times[2][1]
        print(f'{case}: two threads do the stage of drawing, from known vertices to bytes, '
              f'{gain:.2f} times faster, asked {LEAST_FOR_2_THREADS} '
              f'{verdict(gain >= LEAST_FOR_2_THREADS)}')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps({
        'rows': rows, 'missing': missing, 'ours': own, 'machine': machine,
        'threads': threads}, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
