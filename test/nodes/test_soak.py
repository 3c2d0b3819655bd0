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

"""The whole graph for hours: no frame lost, no memory and no latency that grows, nothing left."""
import json
import os
from pathlib import Path
import signal
import statistics
import time

from flag_sim.protocol.cdr import serialized_stamp
from flag_sim.ros.topics import subscribe
from flag_sim.tools.graph import Graph
import numpy as np
import pytest
from support.gauges import (
    BUSY, Growth, growth, left_behind, Machine, memory, processor_time, segments)
from support.soak import SOAK, SOAK_MINUTES
from support.watch import eventually, Watcher

RATE = 60.0        # [Hz]
WARM = 60.0        # after which memory shall not grow [s]
SAMPLE = 1.0       # between two looks at memory [s]
GROWTH = 1.0       # allowed of each node's own memory [MB an hour]
LOST = 0.001       # allowed of the frames in real time, on an idle machine
SLOWER = 1.5       # allowed of the last fifth's latency, by the first fifth's
KEPT = 1000        # frames of which the sending is remembered until their image comes
REPORT = Path('out/soak.json')
SHOT = ('-p', f'rate:={RATE}', '-p', 'paused:=true', '-p', 'loop:=true',
        '-p', 'gust.intensity:=0.3', '-p', 'tracks:=[physics.stiffness, renderer.sun.azimuth]',
        '-p', 'keys.physics.stiffness.times:=[0.0, 5.0]',
        '-p', 'keys.physics.stiffness.values:=[500.0, 2000.0]',
        '-p', 'keys.renderer.sun.azimuth.times:=[0.0, 7.0]',
        '-p', 'keys.renderer.sun.azimuth.values:=[0.2, 1.2]')


class Ear:
    """Hears a graph's frames, as a user's own node does, and how old they are."""

    def __init__(self, watcher):
        self.sent = {}        # when parameters left, by stamp [ns]
        self.latest = -1      # stamp of the frame that was sent last [ns]
        self.latencies = []   # from parameters to image, in their order [s]
        subscribe(watcher.node, 'parameters', self._hear_parameters, raw=True)
        subscribe(watcher.node, 'camera/image_raw', self._hear_image, raw=True)

    def _hear_parameters(self, data, info):
        stamp = serialized_stamp(data)
        self.latest = max(self.latest, stamp)
        self.sent.setdefault(stamp, info['source_timestamp'])
        if len(self.sent) > KEPT:
            del self.sent[next(iter(self.sent))]

    def _hear_image(self, data, info):
        sent = self.sent.pop(serialized_stamp(data), None)
        if sent is not None:
            self.latencies.append((info['received_timestamp'] - sent) * 1e-9)


def soaked(graph, watcher, ear, seconds):
    """Let a graph film for so many seconds; return what was measured of nodes and machine."""
    pids = {name: process.pid for name, process in graph.processes.items()}
    ours = [*pids.values(), os.getpid()]
    began, machine = time.monotonic(), Machine()
    used = sum(map(processor_time, ours))
    times, samples, found = [], {name: [] for name in pids}, set()
    while time.monotonic() < began + seconds:
        if not times or time.monotonic() - began - times[-1] >= SAMPLE:
            times.append(time.monotonic() - began)
            for name, pid in pids.items():
                samples[name].append(memory(pid))
        watcher.spin(0.01)
        assert not graph.failed(), graph.failed()
    found = segments(ours[:-1])
    shares = machine.shares(sum(map(processor_time, ours)) - used)
    # A short trial has no minute to leave out.
    first = sum(at < min(WARM, 0.4 * seconds) for at in times)
    nodes = {name: {kind: {'last_mb': ones[-1][kind], 'growth_mb_an_hour': growth(
        times[first:], [one[kind] for one in ones[first:]])} for kind in ('own', 'shared')}
        for name, ones in samples.items()}
    fifth = max(len(ear.latencies) // 5, 1)
    return {'nodes': nodes, 'machine': shares, 'segments': found, 'latency_ms': [
        1e3 * statistics.median(part) for part in (ear.latencies[:fifth], ear.latencies[-fifth:])]}


def settle(watcher, ear, wind):
    """Pause the wind and wait until no more frames come; return how many were due."""
    assert watcher.put(wind, 'paused', True).successful
    heard, quiet = len(ear.latencies), time.monotonic()
    while time.monotonic() < quiet + 3.0:
        watcher.spin()
        if len(ear.latencies) > heard:
            heard, quiet = len(ear.latencies), time.monotonic()
    return round(ear.latest * 1e-9 * RATE) + 1


def ended(graph):
    """End all nodes; return {name: exit status}, None of one that has not ended."""
    for process in graph.processes.values():
        process.send_signal(signal.SIGINT)
    return {name: graph.wait(name, 90.0) for name in graph.processes}


@pytest.mark.skipif(not SOAK, reason='make soak runs it')
@pytest.mark.parametrize('pace, with_recorder', [
    ('realtime', True), ('lockstep', True), ('realtime', False), ('lockstep', False)])
def test_days(tmp_path, domain, pace, with_recorder, capfd):
    """The recorder's bag has no images, which would be 400 GB."""
    consumers = ['renderer', *['recorder'] * with_recorder]
    seconds = 60.0 * (SOAK_MINUTES if with_recorder else min(SOAK_MINUTES, 5.0))
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        ear = Ear(watcher)
        for node in ('physics', 'renderer'):
            graph.start(node)
        if with_recorder:
            graph.start('recorder', '-p', f'path:={tmp_path / "bag"}',
                        '-p', 'topics:=[parameters, camera/camera_info]')
        graph.start('wind', *SHOT, '-p', f'pace:={pace}', '-p',
                    f'wait_for:=[{", ".join(consumers)}]')
        for node in graph.processes:
            graph.wait_ready(node)
        subscribe(watcher.node, 'state', lambda _: None)
        wind = watcher.parameters_of('wind')
        eventually(lambda: watcher.node.count_publishers('frame_done') == len(consumers), watcher)
        assert watcher.put(wind, 'paused', False).successful
        result = soaked(graph, watcher, ear, seconds)
        due = settle(watcher, ear, wind)
        statuses = ended(graph)
        assert not any(statuses.values()), statuses
        served = {node: int(graph.told(node)['X_FLAG_SIM_FRAMES']) for node in graph.processes}
        logs = {node: len(graph.log(node)) for node in graph.processes}
    result['left_in_shm'] = sorted(left_behind(result.pop('segments')))
    result.update(
        pace=pace, seconds=seconds, frames=due, served=served, heard=len(ear.latencies),
        log_bytes=logs, lost={node: 1.0 - served[node] / due for node in served})
    with capfd.disabled():
        show(result)
    keep(result)
    judge(result)


def is_busy(result):
    """Return whether others had so much of the machine that real time says nothing."""
    return result['machine']['stolen'] + result['machine']['others'] > BUSY


def show(result):
    """Print a table of what was measured."""
    busy = ', which is busy: real time is not judged' * is_busy(result)
    shares = ', '.join(f'{name} {share:.1%}' for name, share in result['machine'].items())
    print(f'\n{result["pace"]}, {result["seconds"]:.0f} s, {result["frames"]} frames; of the '
          f'machine: {shares}{busy}')
    print(f'{"":10}{"lost %":>8}{"log kB":>8}{"own MB":>8}{"MB/hour":>16}'
          f'{"":>11}{"shared MB":>10}{"MB/hour":>16}')
    for node, memories in result['nodes'].items():
        own, shared = memories['own'], memories['shared']
        print(f'{node:10}{100.0 * result["lost"][node]:8.3f}{result["log_bytes"][node] / 1e3:8.1f}'
              f'{own["last_mb"]:8.1f}{in_words(own):>16}'
              f'{own["growth_mb_an_hour"].judged(GROWTH):>11}{shared["last_mb"]:10.1f}'
              f'{in_words(shared):>16}')
    print('latency, medians of the first and the last fifth: {:.1f} and {:.1f} ms; heard by the '
          'test: {} of them; left in /dev/shm: {}'.format(
              *result['latency_ms'], result['heard'], result['left_in_shm'] or 'nothing'))


def in_words(memories):
    """Return a growth with its standard error."""
    return '{:.2f} +- {:.2f}'.format(*memories['growth_mb_an_hour'])


def keep(result):
    """Write what was measured beside what is there."""
    REPORT.parent.mkdir(exist_ok=True)
    kept = json.loads(REPORT.read_text()) if REPORT.exists() else []
    REPORT.write_text(json.dumps([*kept, {**result, 'at': time.time()}], indent=2) + '\n')


def judge(result):
    """Raise AssertionError for frames lost, for what grows, and for what is left."""
    for node, memories in result['nodes'].items():
        # A short form cannot show that nothing grows, and a heap's last pages come late: there
        # the table says 'over', but only what has grown by an hour's allowance is a fault.
        slope = memories['own']['growth_mb_an_hour']
        grown = slope.an_hour * result['seconds'] / 3600.0
        assert slope.judged(GROWTH) != 'over' or grown < GROWTH, f'{node} grows: {slope}'
    # Ports are shared with whoever comes next, and stay.
    assert not [name for name in result['left_in_shm'] if 'port' not in name]
    if result['pace'] == 'lockstep':
        assert not any(result['lost'].values())
    elif not is_busy(result):
        assert max(result['lost'].values()) <= LOST
        first, last = result['latency_ms']
        assert last <= SLOWER * first


def test_a_growth_is_that_of_a_line_with_its_error():
    """By numpy's fit, of blocks with one sample each; a line without noise has no error."""
    times = list(np.arange(30) * 10.0)
    assert growth(times, [5.0 + 2.0 * time for time in times]) == pytest.approx((7200.0, 0.0))
    noisy = np.random.default_rng(1).normal(size=30)
    (slope, _), covariance = np.polyfit(times, noisy, 1, cov=True)
    assert growth(times, list(noisy)) == pytest.approx(
        (3600.0 * slope, 3600.0 * np.sqrt(covariance[0, 0])))


@pytest.mark.parametrize('slope, error, verdict', [
    (0.2, 0.1, 'under'), (1.5, 0.1, 'over'), (0.9, 0.1, 'undecided'), (5.0, 4.0, 'undecided')])
def test_a_growth_is_judged_with_its_error(slope, error, verdict):
    """Where the error reaches beyond the bound, nothing is said."""
    assert Growth(slope, error).judged(1.0) == verdict


def test_the_segments_of_this_process_are_found(tmp_path, domain):
    """Those of a process that lives are not left behind, and none that is gone is."""
    with Watcher(domain):
        mine = segments([os.getpid()])
        assert any(len(name) == len('fastdds_') + 16 for name in mine)
        assert not left_behind(mine)
    assert not left_behind({name for name in mine if 'port' not in name})
