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
Four numbers at once, as one value in kernels: what a processor's vector instructions work on.

LLVM finds by itself the loops whose turns can go side by side, but not four channels of one
pixel, which lie side by side already. So they are said to be a vector of LLVM's, of float32, or of
float64 where sums must be exact. Operations are elementwise.
"""
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, models, register_model

# So many, one of which is over where colours are red, green and blue.
CHANNELS = 4
INDEX = ir.IntType(32)


class LanesType(types.Type):
    """The type of such a value: CHANNELS numbers of one type."""

    def __init__(self, dtype):
        self.dtype = dtype
        super().__init__(name=f'Lanes({dtype})')


@register_model(LanesType)
class LanesModel(models.PrimitiveModel):
    """Says how LLVM holds it: in a register."""

    def __init__(self, manager, kind):
        super().__init__(manager, kind, _vector(kind))


SINGLE, DOUBLE = LanesType(types.float32), LanesType(types.float64)


def _vector(kind):
    return ir.VectorType(ir.FloatType() if kind.dtype == types.float32 else ir.DoubleType(),
                         CHANNELS)


def _place(context, builder, signature, arguments):
    """Return the address of element arguments[1] of the array arguments[0], as of a vector."""
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    element = cgutils.gep(builder, array.data, arguments[1])
    return builder.bitcast(element, _vector(SINGLE).as_pointer())


def _all(builder, kind, value):
    """Return a vector of one number in all places."""
    whole = _vector(kind)
    one = builder.insert_element(ir.Constant(whole, ir.Undefined), value, INDEX(0))
    zeros = ir.Constant(ir.VectorType(INDEX, CHANNELS), [0] * CHANNELS)
    return builder.shuffle_vector(one, ir.Constant(whole, ir.Undefined), zeros)


@intrinsic
def load(typingctx, array, first):
    """Return elements first .. first + CHANNELS - 1 of a flat float32 array."""
    def code(context, builder, signature, arguments):
        return builder.load(_place(context, builder, signature, arguments), align=4)
    return SINGLE(array, types.uint64), code


@intrinsic
def store(typingctx, array, first, lanes):
    """Write single lanes to elements first and on of a flat float32 array."""
    def code(context, builder, signature, arguments):
        builder.store(arguments[2], _place(context, builder, signature, arguments), align=4)
    return types.void(array, types.uint64, SINGLE), code


@intrinsic
def double(typingctx, lanes):
    """Return single lanes in float64."""
    def code(context, builder, signature, arguments):
        return builder.fpext(arguments[0], _vector(DOUBLE))
    return DOUBLE(SINGLE), code


@intrinsic
def single(typingctx, lanes):
    """Return double lanes rounded to float32."""
    def code(context, builder, signature, arguments):
        return builder.fptrunc(arguments[0], _vector(SINGLE))
    return SINGLE(DOUBLE), code


@intrinsic
def times(typingctx, lanes, factor):
    """Return lanes times a number."""
    def code(context, builder, signature, arguments):
        return builder.fmul(arguments[0], _all(builder, lanes, arguments[1]))
    return lanes(lanes, lanes.dtype), code


@intrinsic
def add_times(typingctx, lanes, others, factor):
    """Return lanes + others times a number, rounded once where the processor can."""
    def code(context, builder, signature, arguments):
        whole = _vector(lanes)
        word = 'f32' if lanes.dtype == types.float32 else 'f64'
        fma = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(whole, [whole] * 3), f'llvm.fmuladd.v{CHANNELS}{word}')
        return builder.call(fma, [arguments[1], _all(builder, lanes, arguments[2]), arguments[0]])
    return lanes(lanes, lanes, lanes.dtype), code


@intrinsic
def least(typingctx, lanes, others):
    """Return the lesser of each two; that of `others` where one is not a number."""
    def code(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered('<', *arguments), *arguments)
    return lanes(lanes, lanes), code


@intrinsic
def most(typingctx, lanes, others):
    """Return the greater of each two; that of `others` where one is not a number."""
    def code(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered('>', *arguments), *arguments)
    return lanes(lanes, lanes), code


@intrinsic
def pack(typingctx, lanes):
    """Return single lanes within 0 .. 255, rounded to whole numbers, in a word, the first lowest."""
    def code(context, builder, signature, arguments):
        half = ir.Constant(_vector(SINGLE), [0.5] * CHANNELS)
        whole = builder.fptosi(builder.fadd(arguments[0], half),
                               ir.VectorType(INDEX, CHANNELS))
        return builder.bitcast(
            builder.trunc(whole, ir.VectorType(ir.IntType(8), CHANNELS)), INDEX)
    return types.uint32(SINGLE), code
