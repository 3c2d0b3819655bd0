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
What compiling kernels takes: each kernel's seconds of processor time, most first.

Drawing and each method are compiled in a process of their own without kept machine code, as by
physics and the renderer at their first start. A kernel's seconds are without those of the kernels
that it calls; 'part' is what callers copy, 'code' what Python calls. Written to
out/bench-compiling.json.
"""
import argparse
from collections import Counter
import json
import os
from pathlib import Path
import subprocess
import sys
import tempfile
import time

from flag_sim.declarations.nodes import defaults
from flag_sim.parameters.arguments import given_path

LONGEST = 12
"""Kernels in each table; the others are summed."""


def measure(what):
    """Compile 'drawing', 'normals' or a solver; return [(kernel, seconds)] and all seconds."""
    from flag_sim.cloth.normals import node_normals
    from flag_sim.declarations.moving_cloth import CLOTH_KERNELS
    from flag_sim.declarations.picture_kernels import PICTURE_KERNELS
    from numba.core import event
    import numpy as np

    class Listener(event.Listener):
        """Counts the seconds of each kernel without those of the kernels that it compiles."""

        def __init__(self):
            self.open, self.seconds = [], Counter()

        def on_start(self, begun):
            self.open.append([time.process_time(), 0.0])

        def on_end(self, ended):
            begin, inner = self.open.pop()
            spent = time.process_time() - begin
            if self.open:
                self.open[-1][1] += spent
            dispatcher = ended.data['dispatcher']
            function = dispatcher.py_func
            kind = 'part' if dispatcher.targetoptions.get('no_cpython_wrapper') else 'code'
            name = f'{function.__module__}.{function.__qualname__}'.removeprefix('flag_sim.')
            self.seconds[f'{kind} {name}'] += spent - inner

    listener = Listener()
    event.register('numba:compile', listener)
    begin = time.process_time()
    if what == 'normals':
        node_normals(np.zeros((3, 3, 3)))
    elif what == 'drawing':
        PICTURE_KERNELS.warm_up(defaults('renderer'))
    else:
        CLOTH_KERNELS.warm_up({**defaults('physics'), 'solver': what})
    return listener.seconds.most_common(), time.process_time() - begin


def measure_apart(what):
    """Do that in a process that finds no machine code kept."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, __file__, '--only', what], check=True, text=True,
                              stdout=subprocess.PIPE,
                              env={**os.environ, 'NUMBA_CACHE_DIR': folder})
    return json.loads(done.stdout)


def main():
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--what', nargs='+', default=['drawing', 'symplectic'],
                        help='drawing, normals, or solvers (drawing symplectic)')
    parser.add_argument('--only', help='in this process, as JSON')
    parser.add_argument('--out', type=given_path, default=Path('out/bench-compiling.json'))
    options = parser.parse_args()
    if options.only:
        print(json.dumps(measure(options.only)))
        return
    results = {what: measure_apart(what) for what in options.what}
    for what, (kernels, seconds) in results.items():
        print(f'{what}: {len(kernels)} kernels, {seconds:.2f} s of processor time')
        for name, spent in kernels[:LONGEST]:
            print(f'  {name:56}{spent:6.2f}')
        others = sum(spent for _, spent in kernels[LONGEST:])
        print(f'  {len(kernels[LONGEST:])} others{others:54.2f}')
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(results, indent=2) + '\n')
    print(f'written to {options.out}')


if __name__ == '__main__':
    main()
