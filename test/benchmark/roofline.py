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
What the processor allows a step of the default method, and how near to that it is.

The loops of a step are compiled, and what they do for a vector of nodes is counted in their
machine code: loads, stores, sums and products, divisions, roots. How fast this processor does each
of these, where nothing else is to be done, is measured by small loops. The slowest of them bounds
a loop, if all others are done meanwhile: that time is printed beside the one it takes. Prints a
table, and writes out/bench-roofline.json.
"""
import argparse
import json
import math
from pathlib import Path
import platform
import re
import time

from flag_sim.cloth.aerodynamics import set_face_forces, Wind
from flag_sim.cloth.drag import QUADRATIC
from flag_sim.cloth.forces import Forcing, Work
from flag_sim.cloth.material import Material
from flag_sim.cloth.mesh import Mesh
from flag_sim.cloth.model import Model
from flag_sim.cloth.solvers.symplectic import _move, StepFactors
from flag_sim.cloth.springs import damped_tensions
from flag_sim.cloth.state import State
from flag_sim.jit.kernels import shared_kernel, wide_kernel
from flag_sim.parameters.arguments import given_path
from floating_point import CHAIN, LANES, multiply_add
import numba
from numba.core.compiler_lock import global_compiler_lock
import numpy as np

ROWS, COLUMNS = 41, 61
ARITHMETIC = re.compile(r'v(f?n?m?(add|sub|mul)\w*|min|max|and|or|xor|cmp)\w*p[sd]$')
KINDS = {
    'divisions': re.compile(r'vdivp[sd]$'), 'roots': re.compile(r'vsqrtp[sd]$'),
    'conversions': re.compile(r'vcvt'), 'arithmetic': ARITHMETIC}
SMALL, MIDDLE = 256, 8192  # numbers of each of the arrays: in the nearest cache, in the next one


def machine_code(function, arguments):
    """Return what a kernel is compiled to, as other kernels call it."""
    options = {name: value for name, value in function.targetoptions.items() if name != 'nopython'}
    anew = numba.njit(function.py_func, pipeline_class=function._compiler.pipeline_class,
                      **{**options, 'no_cpython_wrapper': True})
    compiled = anew._compiler.compile(tuple(map(numba.typeof, arguments)), None)
    with global_compiler_lock:
        compiled.library.finalize()
    return compiled.library.get_asm_str()


def hottest_loop(code):
    """Return the instructions of the loop without branches that computes most in vectors."""
    found, label, block = [], None, []
    for line in code.splitlines():
        if mark := re.match(r'(\.LBB\w+):', line):
            label, block = mark[1], []
        elif re.match(r'\s+[a-z]', line):
            block.append(line.split('#')[0].strip())
            if label and re.match(rf'j\w+\s+{re.escape(label)}$', block[-1]):
                found.append(block)
    return max(found, key=lambda loop: sum('mm' in line for line in loop))


def count(code, stores):
    """Return what the hottest loop does for a node. stores: how many numbers that writes."""
    totals = dict.fromkeys(('loads', 'stores', *KINDS), 0)
    widest = max({'x': 128, 'y': 256, 'z': 512}[one] for one in re.findall(r'%([xyz])mm', code))
    for line in hottest_loop(code):
        name, _, operands = line.partition('\t')
        if 'mm' not in operands:
            continue
        if operands.rstrip().endswith(')'):
            totals['stores'] += 1
        elif '(' in operands:
            totals['loads'] += 1
        for kind, pattern in KINDS.items():
            totals[kind] += bool(pattern.match(name))
    vectors = totals['stores'] / stores  # how many vectors of nodes a round of the loop is for
    return {kind: number / vectors for kind, number in totals.items()}, widest // 64


@wide_kernel(cache=False)
def _add_eight(out, a, b, c, d, e, f, g, h, times):
    for _ in range(times):
        for i in range(out.size):
            out[i] = ((a[i] + b[i]) + (c[i] + d[i])) + ((e[i] + f[i]) + (g[i] + h[i]))


@wide_kernel(cache=False)
def _store_four(a, b, c, d, value, times):
    for n in range(times):
        for i in range(a.size):
            a[i] = b[i] = c[i] = d[i] = value


@wide_kernel(cache=False)
def _divide(out, a, b, times):
    for _ in range(times):
        for i in range(out.size):
            out[i] = a[i] / b[i]


@wide_kernel(cache=False)
def _root(out, a, times):
    for _ in range(times):
        for i in range(out.size):
            out[i] = math.sqrt(a[i])


def best(work, per, seconds):
    """Return the least time of work() over a number [ns], of many short turns."""
    work()
    least, end = math.inf, time.perf_counter() + seconds
    while time.perf_counter() < end:
        begin = time.perf_counter()
        work()
        least = min(least, time.perf_counter() - begin)
    return 1e9 * least / per


def limits(lanes, seconds):
    """Return how long a vector of each kind takes this processor [ns]."""
    found = {}
    for name, size in (('loads', SMALL), ('loads, next cache', MIDDLE)):
        arrays = [np.ones(size) for _ in range(9)]
        times = max(1, 20 * MIDDLE // size)
        found[name] = best(lambda: _add_eight(*arrays, times), 8 * times * size / lanes, seconds)
    arrays = [np.ones(SMALL) for _ in range(4)]
    vectors = 400 * SMALL / lanes
    found['stores'] = best(lambda: _store_four(*arrays, 1.0, 400), 4 * vectors, seconds)
    for name, dtype in (('float64', np.float64), ('float32', np.float32)):
        ones = [np.ones(SMALL, dtype) for _ in range(3)]
        found[f'divisions, {name}'] = best(lambda: _divide(*ones, 400), vectors, seconds)
        found[f'roots, {name}'] = best(lambda: _root(*ones[:2], 400), vectors, seconds)
    a, b = np.ones(LANES), np.ones(LANES)
    found['arithmetic'] = best(lambda: multiply_add(a, b, 0.5, 100),
                               100 * CHAIN * LANES / lanes, seconds)
    return found


@shared_kernel(cache=False)
def _quadratic(nodes, wind, dt, weights, faces, band):
    """Do as set_face_forces, but for one law of drag alone: the loop has no branches then."""
    one = Wind(wind.velocity, wind.drag, wind.drag_rate, QUADRATIC, 1, wind.spin)
    set_face_forces(nodes, one, dt, weights, faces, band)


@shared_kernel(cache=False)
def _springs(nodes, weights, springs, tensions, band, times):
    for _ in range(times):
        damped_tensions(nodes, weights, springs, tensions, band)


@shared_kernel(cache=False)
def _faces(nodes, wind, dt, weights, faces, band, times):
    for _ in range(times):
        set_face_forces(nodes, wind, dt, weights, faces, band)


@shared_kernel(cache=False)
def _sums(nodes, nodes_out, tensions, faces, sheet, factors, band, times):
    for _ in range(times):
        _move(nodes, nodes_out, tensions, None, faces, sheet, factors, band)


def loops():
    """Return for each loop its name, kernel, arguments, repetition, numbers written and read."""
    mesh = Mesh(ROWS, COLUMNS, 2.25, 1.5)
    model, state, spare, work = Model(mesh, Material()), State(mesh), State(mesh), Work.of(mesh)
    state.place(mesh.rest((0.0, 0.0, 9.0)))
    coefficients = model.coefficients(Forcing((6.0, 2.0, 0.0)), 1)
    band, dt, weights = mesh.band(), mesh.number(1e-6), mesh.weights
    factors = StepFactors(dt, mesh.number(1.0), coefficients.gravity)
    nodes, out = state.nodes, spare.nodes
    # Numbers of a node: position, velocity, shares of springs, tensions; faces; masses.
    return (
        ('tensions', damped_tensions,
         (nodes, weights, coefficients.springs, work.tensions, band), _springs, 4, 6 + 3),
        ('faces', _quadratic,
         (nodes, coefficients.wind, dt, weights, work.faces, band), _faces, 6, 6 + 1),
        ('sums and motion', _move,
         (nodes, out, work.tensions, None, work.faces, model.sheet, factors, band), _sums,
         6, 6 + 4 + 6 + 2))


def bounds(counts, read, found):
    """Return how long a vector of nodes takes at least [ns], by each limit."""
    # What a loop reads anew comes from the next cache, and it reads much again from the nearest.
    return {
        'loads': max(counts['loads'] - read, 0) * found['loads']
        + read * found['loads, next cache'],
        'stores': counts['stores'] * found['stores'],
        'arithmetic': (counts['arithmetic'] + counts['conversions']) * found['arithmetic'],
        'divisions and roots': counts['divisions, ns'] + counts['roots, ns']}


def measure(seconds):
    """Return a row for each loop, the limits, and the numbers in a vector."""
    rows, found, lanes = [], None, 1
    nodes = ROWS * COLUMNS
    for name, kernel, arguments, again, stores, read in loops():
        code = machine_code(kernel, arguments)
        counts, lanes = count(code, stores)
        found = found or limits(lanes, seconds)
        loop = ' '.join(hottest_loop(code))
        for kind, letters in (('divisions', 'vdivp'), ('roots', 'vsqrtp')):
            precision = 'float32' if f'{letters}s' in loop else 'float64'
            counts[f'{kind}, ns'] = counts[kind] * found[f'{kind}, {precision}']
        if again is _sums:  # the third argument is for bending, and not used here
            arguments = (*arguments[:3], *arguments[4:])
        times = 40
        taken = best(lambda: again(*arguments, times), times * nodes / lanes, seconds)
        rows.append({'loop': name, 'per vector': counts, 'bounds': bounds(counts, read, found),
                     'taken': taken})
    return rows, found, lanes


def show(rows, found, lanes):
    """Print the tables."""
    print(f'A vector holds {lanes} numbers. This processor takes, in ns for each vector:')
    print(', '.join(f'{name} {value:.2f}' for name, value in found.items()))
    print(f'\n{"loop":17}' + ''.join(f'{kind:>12}' for kind in ('loads', 'stores', *KINDS))
          + '   for a vector of nodes')
    for row in rows:
        print(f'{row["loop"]:17}' + ''.join(f'{row["per vector"][kind]:12.1f}'
                                            for kind in ('loads', 'stores', *KINDS)))
    kinds = list(rows[0]['bounds'])
    print(f'\n{"loop":17}' + ''.join(f'{kind:>21}' for kind in (*kinds, 'at least', 'taken'))
          + '   ns a node')
    total = {'at least': 0.0, 'taken': 0.0}
    for row in rows:
        least = max(row['bounds'].values())
        figures = [*row['bounds'].values(), least, row['taken']]
        print(f'{row["loop"]:17}' + ''.join(f'{one / lanes:21.2f}' for one in figures)
              + f'   {100.0 * least / row["taken"]:.0f} %')
        total['at least'] += least / lanes
        total['taken'] += row['taken'] / lanes
    print(f'{"a step":17}' + ' ' * 21 * len(kinds)
          + ''.join(f'{one:21.2f}' for one in total.values())
          + f'   {100.0 * total["at least"] / total["taken"]:.0f} %')
    return total


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=1.0, help='for each measurement')
    parser.add_argument('--out', type=given_path, default=Path('out/bench-roofline.json'))
    options = parser.parse_args()
    if platform.machine() in ('x86_64', 'AMD64'):
        rows, found, lanes = measure(options.seconds)
        result = {'rows': rows, 'limits [ns a vector]': found, 'numbers in a vector': lanes,
                  'a step [ns a node]': show(rows, found, lanes)}
    else:
        result = {'missing': 'the instructions of this processor are not known here'}
        print(f'not measured: {result["missing"]}')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(result, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
