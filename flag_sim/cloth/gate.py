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
Where the threads that share a step wait for one another.

A step takes some microseconds, too few for Python to be asked between two: so each thread runs
many steps of its band in one compiled call, and meets the others in here.
"""
from flag_sim.kernels import shared_kernel
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
import numpy as np

# Where the cells of a gate lie: each in a cache line of its own.
BANDS, COME, IS_OPEN = 0, 8, 16
CELLS = 24

SPINS = 3000
"""Looks at the others, some microseconds, before the processor is offered to whoever needs it."""

_sched_yield = types.ExternalFunction('sched_yield', types.int32())


def new_gate(bands):
    """Return a gate, an array of int64, for so many threads; for one it is always open."""
    gate = np.zeros(CELLS, np.int64)
    gate[BANDS] = bands
    return gate


def release(gate):
    """Let all threads through from now on: somebody will not come. Their results are void."""
    gate[IS_OPEN] = 1


@intrinsic
def _add(typingctx, cells, index, value):
    """Add to a cell, as one indivisible act that orders all others; return what it held."""
    def code(context, builder, signature, arguments):
        cells, index, value = arguments
        array = context.make_array(signature.args[0])(context, builder, cells)
        cell = cgutils.gep(builder, array.data, index)
        return builder.atomic_rmw('add', cell, value, 'seq_cst')
    return types.int64(cells, types.int64, types.int64), code


@intrinsic
def _read(typingctx, cells, index):
    """Return what a cell holds now; what others wrote before they wrote it is then seen too."""
    def code(context, builder, signature, arguments):
        cells, index = arguments
        array = context.make_array(signature.args[0])(context, builder, cells)
        cell = cgutils.gep(builder, array.data, index)
        return builder.load_atomic(cell, 'seq_cst', 8, typ=ir.IntType(64))
    return types.int64(cells, types.int64), code


@shared_kernel
def meet(gate):
    """Return once all threads of the gate are here: what they wrote before can then be read."""
    bands = gate[BANDS]
    if bands == 1:
        return
    # The counter only grows: all have come to this meeting when it is at the next multiple.
    goal = (_add(gate, COME, 1) // bands + 1) * bands
    looks = 0
    while _read(gate, COME) < goal and _read(gate, IS_OPEN) == 0:
        looks += 1
        if looks > SPINS:
            _sched_yield()
