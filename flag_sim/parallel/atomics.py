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
Atomic operations on int64 arrays that several threads use at once.

numba has them for GPUs alone; LLVM's are the same everywhere. All are sequentially consistent:
a thread that reads what another one wrote sees all that this had written before, too.
"""
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def _element(context, builder, signature, arguments):
    """Return the address of element arguments[1] of the array arguments[0]."""
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return cgutils.gep(builder, array.data, arguments[1])


@intrinsic
def fetch_add(typingctx, array, index, value):
    """Add to array[index], as one indivisible act; return what it held before."""
    def code(context, builder, signature, arguments):
        element = _element(context, builder, signature, arguments)
        return builder.atomic_rmw('add', element, arguments[2], 'seq_cst')
    return types.int64(array, types.int64, types.int64), code


@intrinsic
def load(typingctx, array, index):
    """Return what array[index] holds now, whoever wrote it."""
    def code(context, builder, signature, arguments):
        element = _element(context, builder, signature, arguments)
        return builder.load_atomic(element, 'seq_cst', 8, typ=ir.IntType(64))
    return types.int64(array, types.int64), code
