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
How fast clips are made, how well two workers share, what scheduling costs, what memory stays.

Clips of 640 x 480, 60 frames, with colour, depth, flow and its occlusion, normals and labels, into
.npz. One and two workers take turns, clip set by clip set. Written to out/bench-dataset.json.
"""
import argparse
import contextlib
import json
import os
from pathlib import Path
import shutil
import statistics
import tempfile
import time

from flag_sim.dataset import engine
from flag_sim.dataset.recipe import recipe_of
from flag_sim.dataset.store import Store
from flag_sim.parameters.arguments import given_path

RECIPE = """\
seed: 1
clips: 1000
frames: {frames}
channels: [{channels}]
parameters:
  wind.speed: {{uniform: [3.0, 14.0]}}
  physics.preroll: {preroll}
  renderer.width: {width}
  renderer.height: {height}
"""
IMAGES = 'colour, depth, normals, labels, backward_flow'


def job(folder, **recipe):
    """Return a Job with a recipe, in a folder of its own."""
    values = {'frames': 60, 'channels': IMAGES, 'width': 640, 'height': 480, 'preroll': 0.0}
    store = Store(Path(tempfile.mkdtemp(dir=folder)))
    store.making.mkdir()
    return engine.Job(RECIPE.format(**{**values, **recipe}), str(store.folder), '')


def seconds_of(rows):
    """Return how long it takes until all rows are there, and the frames in them."""
    begin = time.perf_counter()
    frames = sum(row['frames'] for row in rows)
    return time.perf_counter() - begin, frames


def measure_alone(folder, clips, **recipe):
    """Return the median frames a second of a clip in this process, and the bytes a frame."""
    own = job(folder, **recipe)
    rows = list(engine.alone(own, range(clips + 1)))[1:]  # the first one loads the kernels
    shutil.rmtree(own.folder)
    return {'frames/s': statistics.median(row['frames'] / row['seconds'] for row in rows),
            'bytes a frame': statistics.median(row['bytes'] / row['frames'] for row in rows)}


def measure_workers(folder, clips, rounds, **recipe):
    """Return the frames a second of one and of two workers, and what two are of twice one."""
    rates = {1: [], 2: []}
    with contextlib.ExitStack() as stack:  # the last to begin ends first, or Dask's logs are told
        clients = {workers: stack.enter_context(engine.cluster(None, workers))
                   for workers in rates}
        for number in range(rounds + 1):
            for workers, client in clients.items():
                own = job(folder, **recipe)
                seconds, frames = seconds_of(engine.on_cluster(client, own, range(clips)))
                shutil.rmtree(own.folder)
                if number:  # the first round loads the kernels
                    rates[workers].append(frames / seconds)
    one, two = statistics.median(rates[1]), statistics.median(rates[2])
    return {'one worker, frames/s': one, 'two workers, frames/s': two,
            'two of twice one': two / (2.0 * one)}


def measure_scheduling(clips):
    """Return what it takes to have so many clips that take no time made by two workers [s]."""
    with engine.cluster(None, 2) as client:
        list(engine.spread(client, abs, range(100), lambda number, reason: None))
        begin = time.perf_counter()
        made = sum(1 for _ in engine.spread(client, abs, range(clips),
                                            lambda number, reason: None))
        return {'clips': made, 'seconds': time.perf_counter() - begin}


def memory():
    """Return the memory of this process [MB]."""
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def measure_memory(folder, clips):
    """Return the memory of a process [MB] after each tenth of so many clips."""
    own = job(folder, frames=10, width=160, height=120,
              channels=f'{IMAGES}, forward_flow, vertices, wind, camera, self_intersecting')
    recipe, store, found = recipe_of(own.text), Store(own.folder), []
    for number in range(clips):
        engine.make(own, number)
        if (number + 1) % max(clips // 10, 1) == 0:
            found.append(memory())
            shutil.rmtree(store.folder / 'clips')
    shutil.rmtree(own.folder)
    return {'frames a clip': recipe.frames, 'MB': found}


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--quick', action='store_true', help='few and small clips')
    parser.add_argument('--clips', type=int, default=8, help='in each turn (8)')
    parser.add_argument('--rounds', type=int, default=5, help='turns of one and two workers (5)')
    parser.add_argument('--empty', type=int, default=10000, help='clips without work (10000)')
    parser.add_argument('--many', type=int, default=500, help='clips for the memory (500)')
    parser.add_argument('--folder', type=given_path, help='where clips are written (a temporary '
                        'one); its disk is measured too')
    parser.add_argument('--out', type=given_path, default=Path('out/bench-dataset.json'))
    options = parser.parse_args()
    small = {'frames': 3, 'width': 64, 'height': 48} if options.quick else {}
    clips, rounds, empty, many = ((1, 1, 20, 10) if options.quick else (
        options.clips, options.rounds, options.empty, options.many))
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        found = {'alone': measure_alone(folder, clips, **small),
                 'workers': measure_workers(folder, clips, rounds, **small),
                 'scheduling': measure_scheduling(empty),
                 'memory': measure_memory(folder, many)}
    work = found['scheduling']['clips'] * 60 / found['workers']['two workers, frames/s']
    found['scheduling']['part of the time of as many clips of 60 frames'] = (
        found['scheduling']['seconds'] / work)
    for what, figures in found.items():
        print(what, *(f'  {name}: {value:.4g}' if isinstance(value, float) else
                      f'  {name}: {value}' for name, value in figures.items()), sep='\n')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(found, indent=1))
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
