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
Vectors of eight float32 in one piece, where LLVM would make none of a loop.

It unrolls a loop of eight turns before it looks for vectors, and then sees only single numbers.
"""
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

LANES = 8


@intrinsic
def set_from_plane(typingctx, values, target, planes, place, u, v):
    """
    Write values[target + q] = p[q] + p_u[q] u + p_v[q] v for q from 0 to 7.

    values, planes: flat float32 arrays; p, p_u and p_v begin at planes[place], [place + 8] and
    [place + 16]; u, v: float32.
    """
    def code(context, builder, signature, arguments):
        vector = ir.VectorType(ir.FloatType(), LANES)

        def at(number, index):
            array = context.make_array(signature.args[number])(context, builder,
                                                               arguments[number])
            return builder.bitcast(cgutils.gep(builder, array.data, index), vector.as_pointer())

        def all_lanes(scalar):
            one = builder.insert_element(ir.Constant(vector, ir.Undefined), scalar,
                                         ir.Constant(ir.IntType(32), 0))
            zeros = ir.Constant(ir.VectorType(ir.IntType(32), LANES), None)
            return builder.shuffle_vector(one, ir.Constant(vector, ir.Undefined), zeros)

        def piece(number):
            offset = ir.Constant(ir.IntType(64), number * LANES)
            return builder.load(at(2, builder.add(arguments[3], offset)), align=4)

        # As elsewhere (see kernels.kernel), a product and a sum may be rounded once.
        flags = ('contract',)
        value = piece(0)
        for number, factor in ((1, arguments[4]), (2, arguments[5])):
            product = builder.fmul(piece(number), all_lanes(factor), flags=flags)
            value = builder.fadd(value, product, flags=flags)
        builder.store(value, at(0, arguments[1]), align=4)
        return context.get_dummy_value()
    signature = types.void(values, types.uint64, planes, types.uint64, types.float32,
                           types.float32)
    return signature, code
