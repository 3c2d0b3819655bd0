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

"""Work dealt piece by piece, to whichever thread asks next."""
import numba
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def take(typing_context, taken):
    """
    Give the number in taken[0] and raise it by one, in one step that no other thread can part.

    taken: (1,) int64. numba has atomic operations for GPUs alone; LLVM's are the same everywhere.
    """
    def generate(context, builder, signature, arguments):
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        first = cgutils.get_item_pointer(
            context, builder, signature.args[0], array, [context.get_constant(numba.intp, 0)])
        return builder.atomic_rmw('add', first, context.get_constant(numba.int64, 1), 'monotonic')

    return numba.int64(taken), generate
