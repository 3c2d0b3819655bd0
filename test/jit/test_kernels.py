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

"""Kernels are vectorised, kept from start to start, and never out of date."""
import importlib
import json
import os
from pathlib import Path
import pkgutil
import shutil
import subprocess
import sys

import flag_sim
from flag_sim.cloth.solvers import SOLVERS
from flag_sim.jit.compilers import KernelCompiler
from numba.core.dispatcher import Dispatcher
import pytest
from support.kernel_copy import PACKAGE, use

TESTS = Path(__file__).resolve().parents[1]
FLY = """
from flag_sim.cloth import Cloth
from flag_sim.cloth.solvers import SOLVERS
import gc, hashlib, json, sys
from numba.core.codegen import CPUCodeLibrary
from numba.core.dispatcher import Dispatcher
from support.object_code import weak_functions
flown, compiled, codes = {}, {}, []
load = CPUCodeLibrary._set_compiled_object
CPUCodeLibrary._set_compiled_object = lambda library, code: [
    codes.append(code), load(library, code)]
for solver in sys.argv[1:]:
    cloth = Cloth(9, 13, solver=solver, pole=(0.5, 0.05, 0.1))
    digest = hashlib.sha256()
    for _ in range(9):
        cloth.advance(0.05, (6.0, 2.0, 0.5))
        digest.update(cloth.positions.tobytes())
    flown[solver] = digest.hexdigest()
    compiled[solver] = sum(SOLVERS[solver].take_steps.stats.cache_misses.values())
for kernel in gc.get_objects():
    if isinstance(kernel, Dispatcher) and kernel.__module__.startswith('flag_sim.'):
        codes += [code.library._compiled_object for code in kernel.overloads.values()]
shared = [name for code in codes if code is not None for name in weak_functions(code)]
print(json.dumps({'flown': flown, 'compiled': compiled, 'shared': shared,
                  'seen': sum(code is not None for code in codes)}))
"""


def test_the_second_start_compiles_nothing(copy):
    """Machine code is kept beside the package."""
    first, hits = use(copy)
    assert hits == 0
    assert use(copy) == (first, 1)


@pytest.fixture
def kept_copy(tmp_path):
    """
    Return a folder with a copy of the package and of the machine code that is kept beside it.

    Most of that code other tests have compiled; to compile it all anew takes more than a minute.
    Files that others are just writing have names that they lose meanwhile.
    """
    shutil.copytree(PACKAGE, tmp_path / 'kept' / 'flag_sim',
                    ignore=shutil.ignore_patterns('*.tmp.*', '*.pyc.*'))
    return tmp_path / 'kept'


def fly(copy, solvers):
    """
    Fly a flag by each method in turn, in a process of its own, by the package's copy.

    Return the hash of each motion; how many kernels of each method were compiled, not loaded; and
    functions that a kernel shares with whatever else the process loads, of how many kernels seen.
    """
    environment = {**os.environ, 'PYTHONPATH': f'{copy}{os.pathsep}{TESTS}'}
    environment.pop('NUMBA_CACHE_DIR', None)
    done = subprocess.run([sys.executable, '-c', FLY, *solvers], check=True, text=True, cwd=copy,
                          capture_output=True, env=environment)
    return json.loads(done.stdout)


def test_the_same_flight_whatever_was_compiled_or_loaded_before(kept_copy):
    """
    To the bit, by every method, in the order of the first process and the other way round.

    In the second process some methods are loaded; some are compiled anew, from kernels that are
    kept.
    """
    first = fly(kept_copy, SOLVERS)
    anew = ['symplectic', 'xpbd']
    for solver in anew:
        for kept in kept_copy.rglob(f'{solver}._take_steps*.nb?'):
            kept.unlink()
    second = fly(kept_copy, list(reversed(SOLVERS)))
    assert {solver for solver, compiled in second['compiled'].items() if compiled} == set(anew)
    assert second['flown'] == first['flown']
    assert len(set(first['flown'].values())) == len(SOLVERS)
    # What lets the first assertions be true by more than luck, whatever the processor.
    assert first['shared'] == second['shared'] == []
    assert min(first['seen'], second['seen']) >= len(SOLVERS)


def test_every_kernel_keeps_to_itself():
    """None is compiled past `kernel`, which sees to what the test above looks at."""
    modules = [importlib.import_module(module.name) for module in pkgutil.walk_packages(
        flag_sim.__path__, 'flag_sim.')
        if not module.name.startswith(('flag_sim.nodes', 'flag_sim.ros', 'flag_sim.tools'))
        and not module.name.endswith('__main__')]
    kernels = {one for module in modules for one in vars(module).values()
               if isinstance(one, Dispatcher)}
    assert len(kernels) > 50
    for one in kernels:
        assert issubclass(one._compiler.pipeline_class, KernelCompiler), one


HALVES = """
from flag_sim.jit.kernels import inner_kernel, kernel
@inner_kernel
def half(number):
    return 0.5 * number
@kernel
def quarter(number):
    return half(half(number))
@kernel
def eighth(number):
    return half(half(half(number)))
"""
USE_HALVES = """
import importlib
from flag_sim import halves
from flag_sim.jit.cache import compilations
print(halves.quarter(8.0), compilations(), len(halves.half.overloads))
importlib.reload(halves)
print(halves.eighth(8.0), compilations(), len(halves.half.overloads))
print(halves.half(8.0), compilations(), len(halves.half.overloads))
"""


def test_what_only_kernels_call_is_compiled_once_and_not_for_python(copy):
    """It is a part of its callers, and of later ones too; Python can call it all the same."""
    (copy / 'flag_sim' / 'halves.py').write_text(HALVES)
    done = subprocess.run([sys.executable, '-c', USE_HALVES], cwd=copy, check=True, text=True,
                          capture_output=True, env={**os.environ, 'PYTHONPATH': str(copy)})
    assert done.stdout.splitlines() == ['2.0 2 0', '1.0 3 0', '4.0 4 1']


def test_an_edit_anywhere_compiles_anew(copy):
    """A kernel that calls others in other files must not go on with their old code."""
    use(copy)
    with open(copy / 'flag_sim' / 'cloth' / 'springs.py', 'a') as file:
        file.write('# edited\n')
    assert use(copy)[1] == 0


def test_a_class_that_is_gone_compiles_anew(copy):
    """What an older version kept for a kernel's argument is not in the way of a newer one."""
    code = ('from typing import NamedTuple\n'
            'from flag_sim.jit.kernels import kernel\n'
            'class {0}(NamedTuple):\n'
            '    number: float\n'
            '@kernel\n'
            'def double(pair):\n'
            '    return 2.0 * pair.number\n'
            'print(double({0}(4.0)))\n')
    for name in ('Before', 'After'):
        (copy / 'flag_sim' / 'pair.py').write_text(code.format(name))
        done = subprocess.run([sys.executable, '-c', 'import flag_sim.pair'], cwd=copy, text=True,
                              capture_output=True, env={**os.environ, 'PYTHONPATH': str(copy)})
        assert done.stdout == '8.0\n', done.stderr
