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
How fast the cloth moves, beside other programs that move the same one.

Each program has a process of its own, pinned to one and the same processor, and they take turns;
medians count. Before that each takes the first tenth of a second of the motion, which must agree
with ours: what does not move the same cloth is not compared. Prints a table with the figures
that were aimed at, and writes out/bench-cloth.json.
"""
import argparse
import contextlib
import datetime
from importlib import metadata
import json
import os
from pathlib import Path
import platform
from typing import NamedTuple

for library in ('OMP', 'OPENBLAS', 'MKL'):
    os.environ[library + '_NUM_THREADS'] = '1'  # of the peers; read when they start

from flag_sim.parameters.arguments import given_path  # noqa: E402
from floating_point import FLOPS, peak  # noqa: E402

import numpy as np  # noqa: E402

from peers_cloth.case import Case  # noqa: E402
from turns import Missing, Program  # noqa: E402

PLAIN, BENT, LARGE = Case(), Case(has_bending=True), Case(81, 121)
CASES = {PLAIN: '61x41', BENT: '61x41, bending', LARGE: '121x81'}
FIRST_STEPS = 1000
BATCH = 0.1  # how long a turn is about [s]
# Peers with our equations agree to the rounding of theirs. Membranes of triangles strain a little
# differently, and Newton's brakes turning: 4.1 mm and 9 % were seen. What must be caught is more:
# without wind 50 mm and 87 %, without springs 14 mm and 42 %, without shear 9 mm and 37 %, with
# half the drag 20 mm and 35 %. (Without damping 0.03 mm: too early to be told.)
EDGE_TOLERANCE = 0.005  # of the free edge's mean place [m]
ENERGY_TOLERANCE = 0.15  # of the kinetic energy, relative


class Entrant(NamedTuple):
    """A program for a case. module: of peers_cloth. options: (name, value), for its Peer."""

    name: str
    case: Case = PLAIN
    module: str = 'ours'
    options: tuple = ()
    is_alone: bool = True  # on one processor

    def start(self, processors):
        """Start its process, on the first of the processors or on all."""
        return Program(f'peers_cloth.{self.module}', {'case': self.case, **dict(self.options)},
                       {min(processors)} if self.is_alone else processors)


class Row(NamedTuple):
    """One comparison. target: how many times faster than the peer it is to be, or None."""

    label: str
    ours: Entrant
    peer: Entrant
    target: float = None


OURS, OURS_BENT = Entrant('flag_sim'), Entrant('flag_sim', BENT)
ONE = Entrant('flag_sim, 1 thread', LARGE, options=(('threads', 1),))
TWO = Entrant('flag_sim, 2 threads', LARGE, options=(('threads', 2),), is_alone=False)
AUTOMATIC = Entrant('flag_sim, threads 0', LARGE, options=(('threads', 0),), is_alone=False)
REFERENCES = OURS, OURS_BENT, ONE  # what the others' motion is compared with
SINGLE = Entrant('flag_sim float32', options=(('precision', 'float32'),))
TRIANGLES = (('membrane', 'triangles'),)
SPRINGS = (('membrane', 'springs'),)
ROWS = (
    Row(CASES[PLAIN], OURS, Entrant('numpy slices', PLAIN, 'numpy_slices'), 25.0),
    Row(CASES[PLAIN], OURS, Entrant('Taichi', PLAIN, 'taichi_cpu'), 12.0),
    Row(CASES[PLAIN], OURS, Entrant('Newton, triangles', PLAIN, 'newton_cpu', TRIANGLES), 18.0),
    Row(CASES[PLAIN], OURS, Entrant('Newton, springs', PLAIN, 'newton_cpu', SPRINGS), 18.0),
    Row(CASES[PLAIN], OURS, Entrant('MuJoCo flex', PLAIN, 'mujoco_flex'), 45.0),
    Row(CASES[BENT], OURS_BENT, Entrant('numpy slices', BENT, 'numpy_slices'), 25.0),
    Row(CASES[BENT], OURS_BENT, Entrant('Taichi', BENT, 'taichi_cpu'), 12.0),
    Row(CASES[BENT], OURS_BENT, Entrant('Newton, triangles', BENT, 'newton_cpu', TRIANGLES), 18.0),
    Row(CASES[BENT], OURS_BENT, Entrant('MuJoCo flex', BENT, 'mujoco_flex'), 45.0),
    Row('61x41, float32', SINGLE, OURS, 1.7),
    Row('121x81, 2 threads', TWO, ONE, 1.8),
    Row('121x81, threads 0', AUTOMATIC, ONE, 0.95),
)


class Truth(NamedTuple):
    """How far a program is from ours after FIRST_STEPS."""

    farthest: float  # of all nodes [m]
    edge: float      # the free edge's mean place [m]
    energy: float    # the kinetic energy, over ours

    @classmethod
    def of(cls, state, reference):
        """Compare two pairs of positions and velocities (rows, columns, 3)."""
        (x, v), (x_ours, v_ours) = state, reference
        return cls(float(np.linalg.norm(x - x_ours, axis=-1).max()),
                   float(np.linalg.norm((x - x_ours)[:, -1].mean(axis=0))),
                   float(np.sum(v**2) / np.sum(v_ours**2)))

    def check(self):
        """Raise Missing unless the same cloth was moved."""
        if not (self.edge <= EDGE_TOLERANCE and abs(self.energy - 1.0) <= ENERGY_TOLERANCE):
            raise Missing(f'does not move the same cloth: free edge {1e3 * self.edge:.1f} mm off, '
                          f'kinetic energy {100.0 * self.energy:.0f} %')


def processor_name():
    """Return what the processor calls itself, where Linux tells."""
    lines = Path('/proc/cpuinfo').read_text().splitlines()
    return next((line.split(':', 1)[1].strip() for line in lines
                 if line.startswith('model name')), 'unknown')


def versions():
    """Return the versions of what is measured, by package."""
    found = {}
    for package in ('numba', 'numpy', 'taichi', 'newton', 'warp-lang', 'mujoco'):
        with contextlib.suppress(metadata.PackageNotFoundError):
            found[package] = metadata.version(package)
    return found


def batch(seconds):
    """Return how many steps to take in a turn, where FIRST_STEPS took some seconds: 20, 40..."""
    return 20 * max(1, round(BATCH * FIRST_STEPS / seconds / 20))


def prepare(entrants, processors, stack):
    """
    Start every entrant and compare its first motion with ours.

    Return for each its Program, its Truth and the steps of a turn; and for each missing one why.
    """
    ready, missing, references, absent = {}, {}, {}, {}
    for entrant in entrants:
        try:
            if entrant.module in absent:
                raise absent[entrant.module]
            program = stack.enter_context(entrant.start(processors))
            program.run(20)  # compiles
            steps = batch(program.run(FIRST_STEPS - 20))
            state = program.state()
            if entrant in REFERENCES:
                references[entrant.case] = state
            elif entrant.case not in references:
                raise Missing('there is nothing of ours to compare it with')
            truth = Truth.of(state, references[entrant.case])
            truth.check()
            ready[entrant] = program, truth, steps
        except Missing as reason:
            missing[entrant] = str(reason)
            if str(reason).startswith('ModuleNotFoundError'):  # for its other cases too
                absent[entrant.module] = reason
    return ready, missing


def take_turns(ready, rounds):
    """Return the times of all turns by entrant [ns per node and step]."""
    times = {entrant: [] for entrant in ready}
    for _ in range(rounds):
        for entrant, (program, _, steps) in ready.items():
            times[entrant].append(1e9 * program.run(steps) / (steps * entrant.case.nodes))
    return {entrant: np.array(some) for entrant, some in times.items()}


def compare(row, ready, times):
    """Return a row of the table as a dictionary."""
    ours, peer = times[row.ours], times[row.peer]
    ratio = float(np.median(peer) / np.median(ours))
    # Of turns in the same round: what else ran on the machine struck both.
    low, high = np.percentile(peer / ours, (10, 90))
    other = row.ours if row.peer.module == 'ours' else row.peer
    program, truth, _ = ready[other]
    return {'peer': row.peer.name, 'case': row.label, 'ours_ns': float(np.median(ours)),
            'peer_ns': float(np.median(peer)), 'ratio': ratio,
            'ratio_spread': [float(low), float(high)], 'target': row.target,
            'reached': None if row.target is None else ratio >= row.target,
            'peer_precision': ready[row.peer][0].precision,
            'free_edge_off_mm': 1e3 * truth.edge, 'kinetic_energy_ratio': truth.energy}


def show(rows, missing):
    """Print the table."""
    print(f'{"case":20}{"peer":22}{"its reals":10}{"ours ns":>8}{"peer ns":>8}{"ratio":>7}'
          f'{"10..90 %":>14}  {"edge off":>8}{"energy":>8}  target')
    for row in rows:
        low, high = row['ratio_spread']
        verdict = '' if row['target'] is None else \
            f'{row["target"]:g} {"reached" if row["reached"] else "MISSED"}'
        print(f'{row["case"]:20}{row["peer"]:22}{row["peer_precision"]:10}{row["ours_ns"]:8.1f}'
              f'{row["peer_ns"]:8.1f}{row["ratio"]:7.2f}{f"{low:.2f}..{high:.2f}":>14}  '
              f'{row["free_edge_off_mm"]:5.2f} mm{100.0 * row["kinetic_energy_ratio"]:6.1f} %'
              f'  {verdict}')
    for entrant, reason in missing.items():
        print(f'not measured: {entrant.name}, {CASES[entrant.case]} ({reason})')


def peak_shares(times):
    """Print and return the peaks of a processor [flop/s], and the shares of them that we use."""
    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(processors)})
    result = {}
    for entrant, dtype in ((OURS, 'float64'), (SINGLE, 'float32')):
        rate = peak(dtype)
        result[dtype] = {'peak_flops': rate, 'share': None}
        if entrant in times:
            share = result[dtype]['share'] = \
                FLOPS / (1e-9 * float(np.median(times[entrant]))) / rate
            print(f'{dtype}: {FLOPS} operations per node and step are {100.0 * share:.0f} % of '
                  f'the {1e-9 * rate:.0f} Gflop/s that one processor was seen to reach')
    os.sched_setaffinity(0, processors)
    return result


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--rounds', type=int, default=20)
    parser.add_argument('--out', type=given_path, default=Path('out/bench-cloth.json'))
    options = parser.parse_args()
    processors = os.sched_getaffinity(0)
    machine = f'{platform.machine()}, {len(processors)} processors, {processor_name()}'
    entrants = dict.fromkeys((*REFERENCES, *(one for row in ROWS for one in (row.ours, row.peer))))
    with contextlib.ExitStack() as stack:
        ready, missing = prepare(entrants, processors, stack)
        times = take_turns(ready, options.rounds)
        rows = [compare(row, ready, times) for row in ROWS
                if row.ours in times and row.peer in times]
    print('Nanoseconds per node and step: springs, damping, wind, step; in steps of '
          f'{1e6 * PLAIN.dt:g} us\non one processor but where threads are named ({machine})')
    show(rows, missing)
    print(', '.join(f'{package} {version}' for package, version in versions().items()))
    shares = peak_shares(times)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps({
        'rows': rows, 'peak': shares, 'flops_per_node_and_step': FLOPS, 'machine': machine,
        'versions': versions(),
        'date': datetime.datetime.now(datetime.timezone.utc).isoformat(timespec='seconds'),
        'missing': {f'{entrant.name}, {CASES[entrant.case]}': reason
                    for entrant, reason in missing.items()}}, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
