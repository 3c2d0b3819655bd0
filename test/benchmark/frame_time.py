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
Where the processor time of a frame goes: in each node, and on what.

Plays a shot at the defaults, 640 x 480 in lockstep into a bag, through nodes of which the calls
are timed, several times, and prints medians. The nodes are those of PYTHONPATH: to compare two
commits, run it for one and the other in turn, and take ratios.
"""
import argparse
import atexit
import functools
import json
import os
from pathlib import Path
import runpy
import statistics
import sys
import tempfile
import time

from flag_sim.parameters.arguments import given_path
from flag_sim.tools.graph import Graph
from rclpy import serialization
from rclpy.node import Node
from rclpy.publisher import Publisher

NODES = ('wind', 'physics', 'renderer', 'recorder')
KINDS = ('work', 'publishing', 'reading', 'executor', 'DDS threads', 'all')


class Clock:
    """The processor time [s] that a node's main thread spends on each kind, and all threads."""

    def __init__(self):
        self._spent = {'callbacks': 0.0, 'publishing': 0.0, 'reading': 0.0}
        self._is_inside = set()
        self._begin = self._end = None

    def _now(self):
        return {**self._spent, 'main': time.thread_time(), 'process': time.process_time()}

    def timed(self, kind, function, is_frame=False):
        """Return a function whose time counts; is_frame: from its first call to its last."""
        @functools.wraps(function)
        def call(*arguments, **options):
            if kind in self._is_inside:
                return function(*arguments, **options)
            self._is_inside.add(kind)
            begin = time.thread_time()
            try:
                return function(*arguments, **options)
            finally:
                self._is_inside.discard(kind)
                self._spent[kind] += time.thread_time() - begin
                if is_frame:
                    self._end = self._now()
                    self._begin = self._begin or self._end
        return call

    def write(self, path):
        """Write {kind: time} between the first frame and the last [s]."""
        if self._begin is None:
            return
        spent = {name: self._end[name] - self._begin[name] for name in self._begin}
        path.write_text(json.dumps(dict(zip(KINDS, (
            spent['callbacks'] - spent['publishing'] - spent['reading'], spent['publishing'],
            spent['reading'], spent['main'] - spent['callbacks'],
            spent['process'] - spent['main'], spent['process'])))))


def run_node(module, arguments):
    """Run a node in this process, timed from outside, by what it calls of rclpy."""
    clock = Clock()
    atexit.register(clock.write, Path(os.environ['FRAME_TIMES']) / module.rpartition('.')[2])
    Publisher.publish = clock.timed('publishing', Publisher.publish)
    serialization.deserialize_message = clock.timed(
        'reading', serialization.deserialize_message)
    subscribe, start_timer = Node.create_subscription, Node.create_timer

    def create_subscription(self, kind, topic, callback, *others, **options):
        return subscribe(self, kind, topic, clock.timed(
            'callbacks', callback, topic in ('parameters', 'frame_done')), *others, **options)

    def create_timer(self, period, callback, *others, **options):
        return start_timer(self, period, clock.timed('callbacks', callback), *others, **options)
    Node.create_subscription, Node.create_timer = create_subscription, create_timer
    sys.argv[1:] = arguments
    runpy.run_module(module, run_name='__main__', alter_sys=True)


def measure(frames, folder):
    """Film a shot; return {node: {kind: ms of the processor a frame}}."""
    class TimedGraph(Graph):
        """Nodes that are run by this program."""

        def prefix(self, name):
            return [sys.executable, __file__, 'node']
    os.environ['FRAME_TIMES'] = str(folder)
    with TimedGraph(folder / 'log') as graph:
        for node, *given in (
                ('physics',), ('renderer',), ('recorder', '-p', f'path:={folder / "bag"}'),
                ('wind', '-p', 'pace:=lockstep', '-p', f'frames:={frames}', '-p',
                 'wait_for:=[renderer, recorder]')):
            graph.start(node, *given)
            graph.wait_ready(node)
        if graph.wait('wind', 300.0) != 0:
            raise SystemExit(graph.log('wind'))
    return {node: {kind: 1e3 * seconds / frames for kind, seconds in json.loads(
        (folder / node).read_text()).items()} for node in NODES}


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--frames', type=int, default=600)
    parser.add_argument('--runs', type=int, default=3)
    parser.add_argument('--out', type=given_path, default=Path('out/bench-frame-time.json'))
    options = parser.parse_args()
    runs = []
    for _ in range(options.runs):
        with tempfile.TemporaryDirectory(prefix='flag_sim-bench-') as folder:
            runs.append(measure(options.frames, Path(folder)))
    print('ms of the processor a frame'.ljust(28) + ''.join(f'{kind:>13}' for kind in KINDS))
    medians = {node: [statistics.median(run[node][kind] for run in runs) for kind in KINDS]
               for node in NODES}
    medians['all'] = [sum(column) for column in zip(*medians.values())]
    for node, row in medians.items():
        print(node.ljust(28) + ''.join(f'{number:13.2f}' for number in row))
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(
        {node: dict(zip(KINDS, row)) for node, row in medians.items()}, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    if sys.argv[1:2] == ['node']:  # as prefix() has it: node python -m module arguments
        run_node(sys.argv[4], sys.argv[5:])
    else:
        main()
