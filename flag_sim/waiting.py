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

"""Waiting awake for another thread: to be woken takes longer than some kernels run."""
from flag_sim.kernels import shared_kernel
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

SPINS = 3000
"""Looks, some microseconds, before the processor is offered to whoever needs it."""
LOOKS = 5000
"""Looks before waiting is given up, about a millisecond."""

_sched_yield = types.ExternalFunction('sched_yield', types.int32())


@intrinsic
def _read(typingctx, cells):
    """Return what the first cell holds now, whoever wrote it."""
    def code(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        cell = cgutils.gep(builder, array.data, 0)
        return builder.load_atomic(cell, 'seq_cst', 8, typ=ir.IntType(64))
    return types.int64(cells), code


@shared_kernel
def wait_while(cells, value):
    """Wait until cells[0], int64, is another than `value`; say whether it became so in time."""
    for look in range(LOOKS):
        if _read(cells) != value:
            return True
        if look > SPINS:
            _sched_yield()
    return False
