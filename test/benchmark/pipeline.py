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
How fast the whole pipeline films, and where each node's time goes.

Plays a shot at the defaults, 640 x 480 in lockstep through wind, physics, renderer and recorder,
then feeds each of them alone with what was recorded, several times; listens to the beat of a shot
in real time; and counts the frames that are lost in real time. Prints medians and writes them to
out/bench.json.
"""
import argparse
import contextlib
import json
import os
from pathlib import Path
import platform
import statistics
import tempfile
import time
from typing import NamedTuple

from flag_sim.parameters.arguments import given_path
from flag_sim.tools.graph import Graph

from probe import answer_wind, feed, Probe, recorded_frames, sending_jitter

NODES = ('wind', 'physics', 'renderer', 'recorder')
BEAT = 60.0  # of the shot in real time [Hz]
REAL_TIME = ((60, 640, 480), (120, 640, 480), (60, 1280, 720))  # [Hz], [pixels]
SHARE_AIM = 0.9  # of what the slowest node alone allows
JITTER_AIM = 1.0, 5.0  # [ms], at the median and the 99th percentile


class Amount(NamedTuple):
    """How much is measured."""

    frames: int = 600    # of a shot
    runs: int = 3
    pause: float = 5.0   # how long idle nodes are watched [s]
    fed: int = 300       # frames that a node is fed with alone
    beats: int = 600     # frames of the shot in real time
    real_time: tuple = REAL_TIME


# Shows that all of it runs; its figures mean nothing.
QUICK = Amount(20, 1, 0.2, 10, 90, REAL_TIME[:1])


def memory(process):
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f'/proc/{process.pid}/statm').read_text().split()[1])
    return pages * os.sysconf('SC_PAGE_SIZE') / 1e6


def processor_time(process):
    """Return the processor time that a process has used [s]."""
    fields = Path(f'/proc/{process.pid}/stat').read_text().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def start(graph, node, *arguments):
    """Start a node; return the seconds until it is ready."""
    begin = time.perf_counter()
    graph.start(node, *arguments)
    graph.wait_ready(node)
    return time.perf_counter() - begin


def run(frames, pause, folder):
    """Film one shot into folder / 'bag', after an idle pause [s]; return what was measured."""
    with Graph(folder / 'log') as graph:
        ready = {node: start(graph, node) for node in ('physics', 'renderer')}
        ready['recorder'] = start(graph, 'recorder', '-p', f'path:={folder / "bag"}')
        ready['wind'] = start(
            graph, 'wind', '-p', 'pace:=lockstep', '-p', f'frames:={frames}', '-p',
            'wait_for:=[renderer, recorder]', '-p', 'paused:=true')
        idle = {node: processor_time(graph.processes[node]) for node in NODES}
        time.sleep(pause)
        idle = {node: (processor_time(graph.processes[node]) - idle[node]) / pause
                for node in NODES}
        graph.end('wind')
        start(graph, 'wind', '-p', 'pace:=lockstep', '-p', f'frames:={frames}', '-p',
              'wait_for:=[renderer, recorder]')
        before = {node: processor_time(graph.processes[node]) for node in NODES}
        resident, used = {}, {}
        while graph.processes['wind'].poll() is None:
            for node, process in graph.processes.items():
                with contextlib.suppress(OSError, ValueError, IndexError):  # it ends just now
                    if found := memory(process):  # of one that has just ended: 0
                        resident[node], used[node] = found, processor_time(process)
            time.sleep(0.05)
        for node in NODES[1:]:
            graph.end(node)
        told = {node: figures(graph, node) for node in NODES}
    return {'frames_per_second': frames / told['recorder']['seconds'],
            'nodes': {node: {
                'wait': told[node]['wait'], 'work': told[node]['work'],
                'publish': told[node]['publish'], 'resident_mb': resident[node],
                'processor_ms': 1e3 * (used[node] - before[node]) / frames,
                'ready_s': ready[node], 'paused_percent': 100.0 * idle[node]}
                for node in NODES}}


def figures(graph, node):
    """Return what a node that has ended told of its time; end the benchmark if it told nothing."""
    told = graph.told(node)
    if 'X_FLAG_SIM_SECONDS' not in told:
        raise SystemExit(f'{node} served nothing:\n{graph.log(node)}')
    return {name: float(told[f'X_FLAG_SIM_{name.upper()}'])
            for name in ('seconds', 'wait', 'work', 'publish')}


def alone(node, fed, folder):
    """Return the frames a second that a node serves with nobody else at work but the probe."""
    with Graph(folder / f'alone-{node}') as graph, Probe(graph.domain) as probe:
        if node == 'wind':
            start(graph, node, '-p', 'pace:=lockstep', '-p', 'wait_for:=[renderer]')
            return answer_wind(probe, fed)
        start(graph, node, *(('-p', f'path:={folder / "copy"}') if node == 'recorder' else ()))
        return feed(probe, node, recorded_frames(folder / 'bag', fed))


def beat(beats, folder):
    """Return the wind's jitter [ms] in real time, at the median and the 99th percentile."""
    with Graph(folder / 'beat') as graph, Probe(graph.domain) as probe:
        for node in ('physics', 'renderer'):
            start(graph, node)
        start(graph, 'wind', '-p', f'rate:={BEAT}')
        return sending_jitter(probe, BEAT, beats)


def recorded_in_real_time(rate, width, height, beats, folder):
    """Return how many of so many frames at a rate [Hz] come to be recorded."""
    with Graph(folder / f'real-{rate}-{height}') as graph:
        start(graph, 'physics')
        start(graph, 'renderer', '-p', f'width:={width}', '-p', f'height:={height}')
        start(graph, 'recorder', '-p', f'path:={folder / f"real-{rate}-{height}" / "bag"}')
        start(graph, 'wind', '-p', f'rate:={rate:.1f}', '-p', f'frames:={beats}', '-p',
              'wait_for:=[renderer, recorder]')
        graph.wait('wind', 60.0 + 2.0 * beats / rate)
        graph.end('recorder')
        return int(graph.told('recorder')['X_FLAG_SIM_FRAMES'])


def measure(amount):
    """Film a shot, then feed its nodes alone; return what was measured."""
    with tempfile.TemporaryDirectory(prefix='flag_sim-bench-') as folder:
        result = run(amount.frames, amount.pause, Path(folder))
        for node in NODES:
            result['nodes'][node]['alone_frames_per_second'] = alone(
                node, amount.fed, Path(folder))
    return result


def median_of(runs):
    """Return the runs' structure with every number replaced by the median."""
    if isinstance(runs[0], dict):
        return {key: median_of([one[key] for one in runs]) for key in runs[0]}
    return round(statistics.median(runs), 2)


def verdict(is_reached):
    """Return the word for an aim that is reached, or not."""
    return 'reached' if is_reached else 'MISSED'


def told_of_real_time(recorded, amount):
    """Print and return how many frames were recorded in each case of real time."""
    told = []
    for (rate, width, height), number in zip(amount.real_time, recorded):
        print(f'real time, {rate} Hz at {width} x {height}: {number} of {amount.beats} frames '
              f'recorded ({verdict(number == amount.beats)})')
        told.append({'rate': rate, 'width': width, 'height': height, 'recorded': number})
    return told


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--quick', action='store_true', help='little of everything')
    parser.add_argument('--out', type=given_path, default=Path('out/bench.json'))
    options = parser.parse_args()
    amount = QUICK if options.quick else Amount()
    with tempfile.TemporaryDirectory(prefix='flag_sim-bench-') as folder:
        # It also compiles the kernels where they are not cached yet.
        jitter = beat(amount.beats, Path(folder))
        real = [recorded_in_real_time(*case, amount.beats, Path(folder))
                for case in amount.real_time]
    runs = [measure(amount) for _ in range(amount.runs)]
    result = median_of(runs)
    result['spread_frames_per_second'] = [round(one['frames_per_second'], 1) for one in runs]
    result['machine'] = f'{platform.machine()}, {os.cpu_count()} processors'
    result['jitter_ms'] = dict(zip(('median', 'percentile_99'), jitter))
    rates = ', '.join(f'{rate:.0f}' for rate in result['spread_frames_per_second'])
    print(f'{result["frames_per_second"]:.0f} frames/s recorded at 640 x 480 ({amount.frames} '
          f'frames, runs: {rates}; {result["machine"]})')
    print(f'{"":10}{"wait %":>8}{"work %":>8}{"publish %":>10}{"cpu ms":>8}{"MB":>6}'
          f'{"ready s":>9}{"paused %":>10}{"alone":>7}')
    for node, row in result['nodes'].items():
        print(f'{node:10}{row["wait"]:8.1f}{row["work"]:8.1f}{row["publish"]:10.1f}'
              f'{row["processor_ms"]:8.2f}{row["resident_mb"]:6.0f}{row["ready_s"]:9.2f}'
              f'{row["paused_percent"]:10.1f}{row["alone_frames_per_second"]:7.0f}')
    alone_rates = {node: row['alone_frames_per_second'] for node, row in result['nodes'].items()}
    slowest = min(alone_rates, key=alone_rates.get)
    result['share_of_slowest'] = result['frames_per_second'] / alone_rates[slowest]
    print(f'{100.0 * result["share_of_slowest"]:.0f} % of what the slowest node alone, '
          f'{slowest}, allows; aimed at: {100.0 * SHARE_AIM:.0f} % '
          f'({verdict(result["share_of_slowest"] >= SHARE_AIM)})')
    needed = sum(row['processor_ms'] for row in result['nodes'].values())
    print(f'all nodes together take {needed:.1f} ms of processor time a frame: {os.cpu_count()} '
          f'processors allow {1e3 * os.cpu_count() / needed:.0f} frames/s at most')
    is_even = all(here < aim for here, aim in zip(jitter, JITTER_AIM))
    print(f'real time, {BEAT:g} Hz: frames leave {jitter[0]:.2f} ms off the beat at the median '
          f'and {jitter[1]:.2f} ms at the 99th percentile; aimed at: {JITTER_AIM[0]:g} and '
          f'{JITTER_AIM[1]:g} ms ({verdict(is_even)})')
    result['real_time'] = told_of_real_time(real, amount)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(result, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
