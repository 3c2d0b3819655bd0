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
How time and memory of a frame grow with the nodes of the cloth and the pixels of the picture.

Each size in a process of its own, with one thread: medians, and by how much the process grew.
The exponent is that of the power of the size that fits the times best, by least squares of the
logarithms: 1 where twice the size takes twice the time. Written to out/bench-growth.json. What a
frame takes whatever its size weighs on small ones, so the exponent of the largest is told too.
"""
import argparse
import json
import os
from pathlib import Path
import statistics
import subprocess
import sys
import time

from flag_sim.cloth import Cloth, Stepping
from flag_sim.drawing import Camera, Picture
from flag_sim.parameters.arguments import given_path
import numpy as np

GRIDS = ((31, 21), (61, 41), (121, 81), (241, 161), (481, 321), (1001, 1001))
SIZES = ((320, 240), (640, 480), (1280, 720), (1920, 1080), (3840, 2160), (7680, 4320))
STEPS = 32  # of the cloth a frame, whatever the grid
STEP = 1e-6  # stable on all of the grids [s]
WIND = (6.0, 2.0, 0.5)
LARGEST = 3
FLAG, PICTURE = (61, 41), (1280, 720)  # where the other one grows


def mover(columns, rows):
    """Return what moves a cloth of so many nodes by a frame."""
    cloth = Cloth(rows, columns, pole=(0.0, 0.0, 0.05), threads=1,
                  stepping=Stepping(substeps=STEPS))
    return lambda: cloth.advance(STEPS * STEP, WIND)


def drawer(columns, rows, width, height):
    """Return what draws a frame of a flag in the wind."""
    s, z = np.meshgrid(np.linspace(0.0, 2.25, columns), np.linspace(9.0, 7.5, rows))
    flag = np.stack([s, 0.15 * np.sin(6.0 * s) * s, z], axis=-1)
    normals = np.cross(np.gradient(flag, axis=0), np.gradient(flag, axis=1))
    picture, camera = Picture(1), Camera(width, height)
    return lambda: picture.draw(flag, normals, camera=camera)


KINDS = {
    'cloth, nodes': (lambda size: mover(*size), GRIDS),
    'picture, nodes': (lambda size: drawer(*size, *PICTURE), GRIDS),
    'picture, pixels': (lambda size: drawer(*FLAG, *size), SIZES)}


def memory():
    """Return the memory of this process [MB]."""
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def measure(kind, size, seconds):
    """Return the median of a frame [ms] in so many seconds, and the memory that it took [MB]."""
    make, sizes = KINDS[kind]
    make(sizes[0])()  # the kernels, which need memory too
    before = memory()
    work = make(size)
    work()
    grown = memory() - before
    times, end = [], time.perf_counter() + seconds
    while len(times) < 3 or time.perf_counter() < end:
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return 1e3 * statistics.median(times), grown


def measure_apart(kind, size, seconds):
    """Do that in another process."""
    done = subprocess.run(
        [sys.executable, __file__, '--only', json.dumps([kind, size, seconds])], check=True,
        stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def exponent(counts, times):
    """Return the p for which times are nearest to a multiple of counts^p."""
    return float(np.polyfit(np.log(counts), np.log(times), 1)[0])


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--quick', action='store_true', help='small sizes, a few frames of each')
    parser.add_argument('--only', help='a measurement in this process, as JSON')
    parser.add_argument('--out', type=given_path, default=Path('out/bench-growth.json'))
    options = parser.parse_args()
    if options.only:
        print(json.dumps(measure(*json.loads(options.only))))
        return
    results = {}
    for kind, (_, sizes) in KINDS.items():
        sizes = sizes[:2] if options.quick else sizes
        rows = [measure(kind, size, 0.0) if options.quick else measure_apart(kind, size, 2.0)
                for size in sizes]
        counts, times = [columns * lines for columns, lines in sizes], [row[0] for row in rows]
        results[kind] = {'sizes': sizes, 'ms': times, 'MB': [row[1] for row in rows],
                         'exponent': exponent(counts, times),
                         'exponent of the largest': exponent(counts[-LARGEST:], times[-LARGEST:])}
        print(f'{kind}: exponent {results[kind]["exponent"]:.2f}, of the {LARGEST} largest '
              f'{results[kind]["exponent of the largest"]:.2f}')
        for (columns, lines), count, (spent, grown) in zip(sizes, counts, rows):
            print(f'{columns:8} x{lines:5}{spent:10.3f} ms{1e6 * spent / count:8.2f} ns each'
                  f'{grown:9.1f} MB')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(results, indent=2) + '\n')
    print(f'a frame of the cloth is {STEPS} steps; written to {options.out}')


if __name__ == '__main__':
    main()
